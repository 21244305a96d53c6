#include "tests/bench/paper/cube_trees.hpp"

#include <algorithm>
#include <random>
#include <set>
#include <tuple>

#include "tests/catch.hpp"

using namespace terravox;
using bench::Brick;

namespace {

constexpr std::int32_t kSide = 96;  // voxels, around the origin

/// Bricks here and there, some of them full.
std::vector<Brick> made_bricks(std::mt19937& random) {
    std::set<std::tuple<int, int, int>> places;
    std::vector<Brick> out;
    const auto coordinate = [&] { return static_cast<int>(random() % (kSide / 4)) - kSide / 8; };
    for (int i = 0; i < 400; ++i) {
        const core::VoxelCoord at{coordinate(), coordinate(), coordinate()};
        if (!places.emplace(at.x, at.y, at.z).second)
            continue;
        const std::uint64_t mask =
            random() % 4 == 0 ? ~std::uint64_t{0} : std::uint64_t{1} << random() % 64 | random();
        out.push_back({at, mask});
    }
    return out;
}

struct End {
    bool hit = false;
    double t = 0;
    core::VoxelCoord voxel;
    friend bool operator==(const End&, const End&) = default;
};

template <class Walk>
End end_of(core::RayState ray, const Walk& walk) {
    if (!walk(ray))
        return {};
    return {true, ray.t, {ray.voxel[0], ray.voxel[1], ray.voxel[2]}};
}

}  // namespace

TEST_CASE("rays end in the same voxel in boxes of any size", "[bench]") {
    std::mt19937 random(3);
    const std::vector<Brick> bricks = made_bricks(random);
    constexpr voxel::VoxelBounds kBounds{{-kSide / 2, -kSide / 2, -kSide / 2},
                                         {kSide / 2, kSide / 2, kSide / 2}};
    bench::CubeTrees<2> small(bricks, kBounds);
    bench::CubeTrees<3> middle(bricks, kBounds);
    bench::CubeTrees<4> large(bricks, kBounds);
    CHECK(small.cubes() > middle.cubes());
    CHECK(middle.cubes() == 8);
    CHECK(large.cubes() == 8);

    const auto is_solid = [&](const core::RayState& ray) {
        const core::VoxelCoord at{ray.voxel[0] >> 2, ray.voxel[1] >> 2, ray.voxel[2] >> 2};
        const auto brick =
            std::find_if(bricks.begin(), bricks.end(), [&](const Brick& b) { return b.at == at; });
        return brick != bricks.end() &&
               (brick->mask >> voxel::child_bit(ray.voxel[0], ray.voxel[1], ray.voxel[2]) & 1) != 0;
    };
    const auto voxel_by_voxel = [&](core::RayState& ray) {
        while (!is_solid(ray)) {
            ray.leap(0);
            for (std::size_t a = 0; a < 3; ++a)
                if (ray.voxel[a] < kBounds.min[a] || ray.voxel[a] >= kBounds.max[a])
                    return false;
        }
        return true;
    };
    std::uniform_real_distribution<double> place(-kSide, kSide);
    std::uniform_real_distribution<double> direction(-1, 1);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        core::RayState ray(core::Ray{{place(random), place(random), place(random)},
                                     {direction(random), direction(random), direction(random)}});
        if (!ray.enter(kBounds))
            continue;
        const End wanted = end_of(ray, voxel_by_voxel);
        INFO("ray " << i);
        CHECK(end_of(ray, [&](auto& r) { return small.first_hit(r); }) == wanted);
        CHECK(end_of(ray, [&](auto& r) { return middle.first_hit(r); }) == wanted);
        CHECK(end_of(ray, [&](auto& r) { return large.first_hit(r); }) == wanted);
        hits += wanted.hit ? 1 : 0;
    }
    CHECK(hits > 100);
}
