#pragma once

#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/farm/checkpoint/tile_grid.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::farm {

/// All that the pixels of a picture, and the tiles that they come in, depend on. Tiles of equal
/// keys belong together, whoever rendered them; the order of tiles, threads and memory are no part
/// of it.
struct PictureKey {
    std::string software,
        build;          ///< "terravox 0.1.0", kBuild: pictures are bit-identical within one build
    std::string scene;  ///< a scene file: to_toml(what_shows(scene))
    std::string world;  ///< voxel::world_to_json
    std::vector<std::string> inputs;  ///< name_inputs
    TileGrid grid;
    bool with_layers = false;

    /// For files. The inverse takes text from anywhere. @param origin names it in messages
    /// @throws Error for what is missing or impossible: a size beyond 65536 pixels, tiles beyond
    /// 4096, more than 2^20 of them
    [[nodiscard]] std::string to_json() const;
    [[nodiscard]] static PictureKey from_json(const std::string& text, const std::string& origin);
    friend bool operator==(const PictureKey&, const PictureKey&) = default;
};

/// Of this build. @param scene as it is rendered: with the tiles and layers that it really has
/// @param inputs of name_inputs
[[nodiscard]] PictureKey key_of(const scene::Scene& scene, const voxel::WorldInfo& world,
                                std::vector<std::string> inputs);

/// What a person has to know of two keys that are not equal: "camera.fov_deg = 40.0 there, 50.0
/// here". Empty for equal ones.
[[nodiscard]] std::string difference(const PictureKey& there, const PictureKey& here);

}  // namespace terravox::farm
