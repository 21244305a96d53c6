#include "raytracer/core/blocks/load_queue.hpp"

#include <exception>
#include <stdexcept>

#include "common/voxel/world.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using blocks::HoleRecord;

namespace {

constexpr voxel::BoxKey kBroken{0, 1, 0, 0};
constexpr voxel::BoxKey kChanged{0, 2, 0, 0};

std::exception_ptr damage() {
    return std::make_exception_ptr(std::runtime_error("a damaged file"));
}

}  // namespace

TEST_CASE("a hole is counted once, whatever it failed with", "[raytracer][world][hole]") {
    HoleRecord holes;
    CHECK_FALSE(holes.contains(kBroken));
    holes.add(kBroken, damage());
    holes.add(kBroken, std::make_exception_ptr(42));
    CHECK(holes.contains(kBroken));
    CHECK(holes.size() == 1);
    CHECK_NOTHROW(holes.check_world());
}

TEST_CASE("holes that may be forgotten are, and each call begins a generation",
          "[raytracer][world][hole]") {
    HoleRecord holes;
    holes.add(kBroken, damage());
    holes.add(kChanged, damage());
    CHECK(holes.generation() == 0);
    holes.forget([](const voxel::BoxKey& key) { return key == kBroken; });
    CHECK(holes.generation() == 1);
    CHECK_FALSE(holes.contains(kBroken));
    CHECK(holes.contains(kChanged));
    holes.forget([](const voxel::BoxKey&) { return false; });
    CHECK(holes.generation() == 2);
    CHECK(holes.size() == 1);
}

TEST_CASE("the first change of the world is kept, also when its hole is forgotten",
          "[raytracer][world][hole]") {
    HoleRecord holes;
    holes.add(kChanged, std::make_exception_ptr(voxel::ChangedError("the first")));
    holes.add(kBroken, std::make_exception_ptr(voxel::ChangedError("the second")));
    CHECK(holes.size() == 2);
    CHECK_THROWS_WITH(holes.check_world(), "the first");
    holes.forget([](const voxel::BoxKey&) { return true; });
    CHECK(holes.size() == 0);
    CHECK_THROWS_AS(holes.check_world(), voxel::ChangedError);
}
