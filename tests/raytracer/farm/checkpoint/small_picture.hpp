#pragma once

#include "raytracer/farm/checkpoint/picture_key.hpp"
#include "raytracer/tiles/tile_plan.hpp"
#include "tests/raytracer/landscape.hpp"
#include "tests/raytracer/tiles/invented_tiles.hpp"

namespace terravox::test {

inline Scene small_picture(bool with_layers = false) {
    Scene scene = small_scene();
    scene.output.size_px = {45, 33}, scene.quality.coarse_step = 1;
    scene.output.layers = with_layers ? PictureLayers::kAll : PictureLayers::kBeauty;
    return scene;
}

/// 3 x 3 tiles of 16 pixels.
inline PictureKey small_key(bool with_layers = false) {
    return key_of(small_picture(with_layers), landscape()->info(), {"test"});
}

/// Tiles of chance, without holes, in the order asked for.
inline std::vector<TileResult> small_tiles(bool with_layers = false, unsigned seed = 1,
                                           TileOrder order = TileOrder::kRows) {
    std::vector<TileResult> out;
    const auto passes = plan_tiles(45, 33, 1, 16, order);
    for (const RenderTile& tile : passes.front()) {
        out.push_back(tile_of_chance(tile, with_layers,
                                     seed + static_cast<unsigned>(tile.x0 * 100 + tile.y0)));
        out.back().holes.clear();
    }
    return out;
}

}  // namespace terravox::test
