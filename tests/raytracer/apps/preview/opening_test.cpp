#include "raytracer/apps/preview/opening.hpp"

#include "tests/catch.hpp"
#include "tests/eventually.hpp"

using namespace terravox;
using preview::Opening;

namespace {

worlds::WorldOptions from(const std::string& input) {
    worlds::WorldOptions out;
    out.inputs = {input};
    return out;
}

}  // namespace

TEST_CASE("a world that was opened is handed over once", "[preview][world]") {
    Opening opening(from("generated:3"), scene::Scene{});
    std::shared_ptr<render::LoadedWorld> world;
    REQUIRE(test::eventually([&] {
        world = opening.take();
        return world != nullptr || !opening.failure().empty();
    }));
    REQUIRE(world);
    CHECK(world->inputs == std::vector<std::string>{"generated:3"});
    CHECK_FALSE(opening.runs());
    CHECK(opening.failure().empty());
    CHECK_FALSE(opening.take());
}

TEST_CASE("a world that cannot be opened leaves the reason", "[preview][world]") {
    Opening opening(from("/nowhere/at-all.laz"), scene::Scene{});
    REQUIRE(test::eventually([&] { return !opening.runs(); }));
    CHECK_THAT(opening.failure(), test::contains("/nowhere/at-all.laz"));
    CHECK_FALSE(opening.take());
}
