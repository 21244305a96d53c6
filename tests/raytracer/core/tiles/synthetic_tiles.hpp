#pragma once

#include <cmath>
#include <limits>
#include <random>

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::test {

/// A finished tile of numbers of chance, with every kind of value that a pixel may have. The same
/// for the same seed.
inline tiles::TileResult tile_of_chance(const tiles::RenderTile& tile, bool with_layers,
                                        unsigned seed) {
    std::mt19937 random(seed);
    const auto share = [&] { return static_cast<float>(random() % 1025) / 1024; };
    const auto number = [&] {
        return std::ldexp(static_cast<float>(random() % 1'000'001) - 500'000,
                          static_cast<int>(random() % 60) - 40);
    };
    const auto colour = [&] {
        return voxel::Colour{number(), number(), random() % 50 == 0 ? -0.0f : number()};
    };
    tiles::TileResult out;
    out.tile = tile;
    for (auto& n : out.counts.rays)
        n = random();
    out.counts.steps = std::uint64_t{random()} << 20, out.counts.slabs = random(),
    out.counts.spared = random();
    out.counts.parked = random() % 100;
    out.counts.hole_rays = random() % 100;
    for (double& s : out.counts.seconds)
        s = random() / 1e9;
    for (unsigned i = random() % 4; i > 0; --i)
        out.holes.insert({static_cast<int>(random() % 10), static_cast<std::int32_t>(random()),
                          static_cast<std::int32_t>(random() % 7) - 3,
                          static_cast<std::int32_t>(random())});
    tile.each_pixel([&](int, int) {
        tiles::PixelSample s;
        s.colour = colour();
        s.alpha = share();
        s.depth_m = s.alpha == 0 ? std::numeric_limits<float>::infinity() : std::abs(number());
        s.samples = 1 + random() % 4096;
        s.error = share();
        out.samples.push_back(s);
        if (!with_layers)
            return;
        tiles::LayerSample l;
        l.direct = colour();
        l.indirect = colour();
        l.albedo = {share(), share(), share()};
        for (auto* v : {&l.normal, &l.position})
            for (float& part : *v)
                part = number();
        l.sun = share();
        l.water = share();
        l.material =
            static_cast<voxel::Material>(random() % static_cast<unsigned>(voxel::kMaterialCount));
        for (std::size_t i = 0; i < random() % 7; ++i) {
            l.materials.object[i] = random() % static_cast<unsigned>(voxel::kMaterialCount);
            l.materials.share[i] = share();
            l.squares.object[i] = random();
            l.squares.share[i] = share();
        }
        out.layers.push_back(l);
    });
    return out;
}

}  // namespace terravox::test
