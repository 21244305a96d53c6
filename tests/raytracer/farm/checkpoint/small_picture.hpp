#pragma once

#include <functional>

#include "common/util/error.hpp"
#include "raytracer/core/tiles/tile_plan.hpp"
#include "raytracer/farm/checkpoint/picture_key.hpp"
#include "tests/raytracer/core/tiles/synthetic_tiles.hpp"
#include "tests/raytracer/landscape.hpp"

namespace terravox::test {

inline scene::Scene small_picture(bool with_layers = false) {
    scene::Scene scene = small_scene();
    scene.output.size_px = {45, 33};
    scene.quality.coarse_step = 1;
    scene.output.layers = with_layers ? core::PictureLayers::kAll : core::PictureLayers::kBeauty;
    return scene;
}

/// 3 x 3 tiles of 16 pixels.
inline farm::PictureKey small_key(bool with_layers = false) {
    return farm::to_key(small_picture(with_layers), landscape()->info(), {"test"});
}

/// Random tiles, without holes, in the given order.
inline std::vector<tiles::TileResult> small_tiles(bool with_layers = false, unsigned seed = 1,
                                                  core::TileOrder order = core::TileOrder::kRows) {
    std::vector<tiles::TileResult> out;
    const auto passes = tiles::plan_tiles(45, 33, 1, 16, order);
    for (const tiles::RenderTile& tile : passes.front()) {
        out.push_back(tile_of_chance(tile, with_layers,
                                     seed + static_cast<unsigned>(tile.x0 * 100 + tile.y0)));
        out.back().holes.clear();
    }
    return out;
}

/// What is said of the failure; "nothing": there is none.
inline std::string to_message(const std::function<void()>& what) {
    try {
        what();
    } catch (const util::Error& e) {
        return e.what();
    }
    return "nothing";
}

}  // namespace terravox::test
