#pragma once

#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/checkpoint/tile_grid.hpp"

namespace terravox::farm {

/// Everything that the pixels of a picture, and its division into tiles, depend on. Tiles of equal
/// keys can be combined, whatever rendered them; the order of tiles, threads and memory are not
/// part of the key.
struct PictureKey {
    /// "terravox 0.1.0" and kBuild: pictures are bit-identical within one build.
    std::string software;
    std::string build;
    std::string scene;                ///< a scene file: to_toml(what_shows(scene))
    std::string world;                ///< voxel::world_to_json
    std::vector<std::string> inputs;  ///< name_inputs
    TileGrid grid;
    bool with_layers = false;

    /// The key as JSON, for files. The inverse takes untrusted text.
    /// @param origin names the text in messages
    /// @throws Error for what is missing or impossible: a size beyond 65536 pixels, tiles beyond
    /// 4096, more than 2^20 of them
    [[nodiscard]] std::string to_json() const;
    [[nodiscard]] static PictureKey from_json(const std::string& text, const std::string& origin);
    friend bool operator==(const PictureKey&, const PictureKey&) = default;
};

/// The key of a picture in this build.
/// @param scene as it is rendered: with the actual tiles and layers
/// @param inputs of name_inputs
[[nodiscard]] PictureKey key_of(const scene::Scene& scene, const voxel::WorldInfo& world,
                                std::vector<std::string> inputs);

/// A description of the difference between two keys: "camera.fov_deg = 40.0 there, 50.0 here".
/// Empty for equal ones.
[[nodiscard]] std::string difference(const PictureKey& there, const PictureKey& here);

}  // namespace terravox::farm
