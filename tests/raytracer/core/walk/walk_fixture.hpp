#pragma once

#include <memory>
#include <optional>
#include <random>

#include "raytracer/core/base/random.hpp"
#include "raytracer/core/walk/walk.hpp"
#include "tests/raytracer/pyramid_world.hpp"

namespace terravox::test {

inline constexpr int kLevels = 4;
using Random = std::mt19937_64;
inline double real(Random& r, double low, double high) {
    return low + core::unit_from(r()) * (high - low);
}

inline std::unique_ptr<PyramidWorld> made_towers() {
    auto finest = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-90, -20, -100},
                                               ArrayWorld::Coord{170, 80, 140});
    finest->fill_with([](int x, int y, int z) {
        const std::uint64_t h = core::hash64(static_cast<std::uint64_t>(x >> 2) << 32 ^
                                             static_cast<std::uint32_t>(z >> 2));
        const int height = h % 23 == 0 ? static_cast<int>(h >> 20 & 63) : (x * x + z * z) / 900;
        return y < height                    ? voxel::Material::kGround
               : h % 31 == 1 && (y & 7) == 3 ? voxel::Material::kRoof
                                             : voxel::Material::kAir;
    });
    return std::make_unique<PyramidWorld>(std::move(finest), kLevels);
}

/// The same for all that make no holes in it: it takes long to make.
inline PyramidWorld& towers() {
    static const std::unique_ptr<PyramidWorld> world = made_towers();
    return *world;
}

struct Fixture {
    explicit Fixture(double detail, std::size_t pinned_bytes = std::size_t{64} << 20)
        : cut(towers().info().bounds, {-80, 60, -90}, 0.03, detail, 0, kLevels - 1),
          blocks(towers(), std::size_t{1} << 30),
          reader(blocks, pinned_bytes),
          walker(reader, cut),
          single(reader, cut) {}
    walk::LevelCut cut;
    blocks::BlockManager blocks;
    walk::BlockReader reader;
    walk::Walker walker;
    walk::RayWalk single;

    /// The end of a ray that packets or lanes have left: it continues with single steps, and waits
    /// for boxes.
    std::optional<walk::Hit> finish(core::RayState& ray, double t_max = core::kFar) {
        walk::Hit hit;
        while (true) {
            const walk::WalkEnd end = single.first_hit(ray, walk::StopAt::kSolid, t_max, hit);
            if (end != walk::WalkEnd::kWaits)
                return end == walk::WalkEnd::kHit ? std::optional(hit) : std::nullopt;
            (void)blocks.get(single.missing());
        }
    }
};

inline bool same(const std::optional<walk::Hit>& a, const std::optional<walk::Hit>& b) {
    if (a.has_value() != b.has_value())
        return false;
    return !a || (a->t == b->t && a->voxel == b->voxel && a->face == b->face &&
                  a->level == b->level && a->attr == b->attr && a->hole == b->hole);
}

}  // namespace terravox::test
