#include <algorithm>
#include <random>
#include <thread>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/patchwork.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::BoxKey;
using voxel::InputExtent;

namespace {

const Patchwork& patchwork() {
    static const Patchwork made;
    return made;
}

const Kept& reference() {
    static const Kept made = [] {
        OpenWorld world(patchwork().options());
        return keep(world.world());
    }();
    return made;
}

std::string text(const BoxKey& k, const InputExtent& r) {
    return "level " + std::to_string(k.level) + " box " + std::to_string(k.bx) + ", " +
           std::to_string(k.by) + ", " + std::to_string(k.bz) + " reaches " +
           std::to_string(r.min_bx) + ", " + std::to_string(r.min_bz) + " to " +
           std::to_string(r.max_bx) + ", " + std::to_string(r.max_bz);
}

void check_same(const Kept& found) {
    for (const auto& [key, one] : found.boxes) {
        const auto& expected = reference().boxes.at(key);
        INFO(text(key, one.reach) << "; expected: " << text(key, expected.reach));
        CHECK((one.reach == expected.reach && one.fingerprint == expected.fingerprint &&
               one.checksum == expected.checksum));
    }
}

bool holds(const InputExtent& outer, const InputExtent& inner) {
    return inner.min_bx >= outer.min_bx && inner.min_bz >= outer.min_bz &&
           inner.max_bx <= outer.max_bx && inner.max_bz <= outer.max_bz;
}

BoxKey box_at(double east, double north) {
    return {0, voxel_x(east) >> 6, 1, voxel_z(north) >> 6};
}

}  // namespace

TEST_CASE(
    "a box is the same and reaches as far whatever was requested before, by however many threads "
    "and with however little memory",
    "[voxelserver][voxelize][reach]") {
    struct Case {
        const char* name;
        std::size_t memory_bytes;
        int threads;
        unsigned seed;
    };
    const auto c = GENERATE(values<Case>({{"backwards", std::size_t{4} << 30, 1, 0},
                                          {"shuffled", std::size_t{64} << 20, 2, 3},
                                          {"no memory at all", 1, 2, 6}}));
    DYNAMIC_SECTION(c.name) {
        auto options = patchwork().options();
        options.memory_bytes = c.memory_bytes;
        options.threads = c.threads;
        OpenWorld world(options);
        auto keys = keys_of_all_levels(world.info());
        if (c.seed == 0)
            std::reverse(keys.begin(), keys.end());
        else
            std::shuffle(keys.begin(), keys.end(), std::mt19937(c.seed));
        check_same(keep(world.world(), keys));
    }
    SECTION("by four threads at once") {
        OpenWorld world(patchwork().options());
        std::vector<Kept> found(4);
        std::vector<std::thread> threads;
        for (unsigned t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                auto keys = keys_of_all_levels(world.info());
                std::shuffle(keys.begin(), keys.end(), std::mt19937(t));
                found[t] = keep(world.world(), keys);
            });
        for (auto& t : threads)
            t.join();
        for (const Kept& kept : found)
            check_same(kept);
    }
}

TEST_CASE("a box on land reaches one patch far, one at a lake as far as the lake",
          "[voxelserver][voxelize][reach]") {
    OpenWorld world(patchwork().options());
    const BoxKey land = box_at(470, 10);
    const InputExtent near = world.world().box_with_inputs(land).reach;
    INFO(text(land, near));
    CHECK((near == InputExtent{land.bx - 1, land.bz - 1, land.bx + 2, land.bz + 2}));
    for (const double east : {40.0, 220.0, 420.0}) {
        const BoxKey shore = box_at(east, 250);
        const InputExtent reach = world.world().box_with_inputs(shore).reach;
        INFO(text(shore, reach));
        CHECK(reach.min_bx <= voxel_x(21) >> 6);
        CHECK(reach.max_bx > voxel_x(439) >> 6);
    }
    // Under the hall no ground lies within 32 columns: it is interpolated from around.
    const BoxKey hall = box_at(75, 75);
    const InputExtent wide = world.world().box_with_inputs(hall).reach;
    INFO(text(hall, wide));
    CHECK(holds(wide, {hall.bx - 1, hall.bz - 1, hall.bx + 2, hall.bz + 2}));
}

TEST_CASE("a coarse box reaches over all that lies under it and as far as its children",
          "[voxelserver][voxelize][reach]") {
    OpenWorld world(patchwork().options());
    const auto range = voxel::boxes_over(world.info().bounds, 0);
    for (const auto& [key, one] : reference().boxes) {
        if (key.level == 0)
            continue;
        INFO(text(key, one.reach));
        CHECK(holds(one.reach, {key.bx << key.level, key.bz << key.level, (key.bx + 1) << key.level,
                                (key.bz + 1) << key.level}));
        for (int i = 0; i < 8; ++i) {
            const BoxKey child{key.level - 1, 2 * key.bx + (i & 1), 2 * key.by + (i >> 2),
                               2 * key.bz + (i >> 1 & 1)};
            if (const auto found = reference().boxes.find(child); found != reference().boxes.end())
                CHECK(holds(one.reach, found->second.reach));
        }
    }
    SECTION("next to the land a box reaches its own columns only, above it everything") {
        const voxel::BoxWithInputs beside =
            world.world().box_with_inputs({0, range.max.bx + 10, 1, range.min.bz});
        CHECK(beside.box == nullptr);
        CHECK((beside.reach ==
               InputExtent{range.max.bx + 10, range.min.bz, range.max.bx + 11, range.min.bz + 1}));
        const voxel::BoxWithInputs above =
            world.world().box_with_inputs({0, range.min.bx, range.max.by + 3, range.min.bz});
        CHECK(above.box == nullptr);
        CHECK(holds(above.reach, {-1'000'000, -1'000'000, 1'000'000, 1'000'000}));
    }
}
