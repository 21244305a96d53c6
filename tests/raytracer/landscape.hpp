#pragma once

#include <memory>
#include <string>

#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"
#include "raytracer/farm/render/passes/passes.hpp"
#include "tests/common/voxel/array_world.hpp"

namespace terravox::test {

/// A small valley over several boxes: hills, a lake, a house, trees and a floating rock.
inline std::unique_ptr<ArrayWorld> landscape() {
    using voxel::Material;
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-80, -10, -70},
                                              ArrayWorld::Coord{90, 60, 75});
    world->fill_with([](int x, int y, int z) {
        const int height = (x * x + z * z) / 300 - 4 + ((x * 13 ^ z * 7) & 3) / 3;
        if (y < height)
            return y == height - 1 ? Material::kGrass : Material::kRock;
        if (y < 2)
            return Material::kWater;
        return (x & 15) == 3 && (z & 15) == 5 && y < height + 6 ? Material::kHighVegetation
                                                                : Material::kAir;
    });
    world->fill({20, 0, 20}, {40, 22, 36}, Material::kWall);
    world->fill({20, 22, 20}, {40, 23, 36}, Material::kOrangeRoof);
    world->fill({-30, 40, -30}, {-20, 44, -12}, Material::kRock);
    world->editable_info().bounds = world->level_bounds();
    return world;
}

inline scene::Scene small_scene() {
    scene::Scene scene;
    scene.output.size_px = {97, 53};
    scene.quality.samples = 2;
    scene.quality.tile = {16};
    scene.sun.altitude_deg = 30;
    scene.sun.azimuth_deg = 240;
    return scene;
}

/// A world opened for rendering with one scene; everything a processor refers to.
struct Job {
    std::unique_ptr<ArrayWorld> world;
    blocks::BlockManager blocks;
    shade::View view;
    explicit Job(const scene::Scene& scene, std::size_t memory_bytes = std::size_t{256} << 20,
                 std::unique_ptr<ArrayWorld> w = landscape(),
                 shade::MakeMeasuring measure = nullptr)
        : world(std::move(w)),
          blocks(*world, memory_bytes),
          view(shade::make_view(scene, blocks, measure)) {}
};

inline output::Film render_scene(Job& job, int threads) {
    const auto [width, height] = job.view.scene.output.size_px;
    output::Film film(width, height, job.view.wants_layers());
    processors::ThreadProcessor processor(job.view, job.blocks, threads);
    (void)render::render_film({job.view, processor, true, {}}, film);
    return film;
}

/// The bytes of all pixels: bit-identical or not.
inline std::string to_bytes(const output::Film& film) {
    std::string out;
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x) {
            const tiles::PixelSample& p = film.at(x, y);
            const auto append = [&](float v) {
                out.append(reinterpret_cast<const char*>(&v), sizeof v);
            };
            for (const float v : {p.colour.r, p.colour.g, p.colour.b, p.alpha, p.depth_m, p.error,
                                  static_cast<float>(p.samples)})
                append(v);
            if (!film.has_layers())
                continue;
            const tiles::LayerSample& l = film.layers_at(x, y);
            for (const voxel::Colour c : {l.direct, l.indirect, l.albedo}) {
                append(c.r);
                append(c.g);
                append(c.b);
            }
            for (const auto& v : {l.normal, l.position}) {
                append(v[0]);
                append(v[1]);
                append(v[2]);
            }
            append(l.sun);
            append(l.water);
            append(static_cast<float>(l.material));
            for (const tiles::Matte& m : {l.materials, l.squares})
                for (std::size_t i = 0; i < tiles::Matte::kMax; ++i) {
                    append(static_cast<float>(m.object[i]));
                    append(m.share[i]);
                }
        }
    return out;
}

}  // namespace terravox::test
