#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/tiles/tile.hpp"

namespace terravox::farm {

/// The tiles of a picture of a single pass, numbered row by row from the upper left. The numbers,
/// called *cells*, do not depend on the order of rendering.
struct TileGrid {
    int width_px = 1, height_px = 1, tile_px = 1;  ///< each at least 1

    [[nodiscard]] std::uint32_t columns() const noexcept {
        return static_cast<std::uint32_t>((width_px + tile_px - 1) / tile_px);
    }
    [[nodiscard]] std::uint32_t rows() const noexcept {
        return static_cast<std::uint32_t>((height_px + tile_px - 1) / tile_px);
    }
    [[nodiscard]] std::uint32_t cells() const noexcept { return columns() * rows(); }

    /// @return nullopt for anything but a whole tile of a single pass with a pixel's first samples
    [[nodiscard]] std::optional<std::uint32_t> find_cell(
        const tiles::RenderTile& t) const noexcept {
        const bool whole = t.step == 1 && !t.refines && t.first_sample == 0 && t.x0 >= 0 &&
                           t.y0 >= 0 && t.x0 < width_px && t.y0 < height_px &&
                           t.x0 % tile_px == 0 && t.y0 % tile_px == 0 &&
                           t.x1 == std::min(t.x0 + tile_px, width_px) &&
                           t.y1 == std::min(t.y0 + tile_px, height_px);
        if (!whole)
            return std::nullopt;
        return static_cast<std::uint32_t>(t.y0 / tile_px) * columns() +
               static_cast<std::uint32_t>(t.x0 / tile_px);
    }
    friend bool operator==(const TileGrid&, const TileGrid&) = default;
};

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
[[nodiscard]] PictureKey to_key(const scene::Scene& scene, const voxel::WorldInfo& world,
                                std::vector<std::string> inputs);

/// A description of the difference between two keys: "camera.fov_deg = 40.0 there, 50.0 here".
/// Empty for equal ones.
[[nodiscard]] std::string difference(const PictureKey& there, const PictureKey& here);

using IsOutput = std::function<bool(const std::filesystem::path& file)>;

/// Identifies the inputs of a picture by their contents, one line each, so that a checkpoint, or a
/// finished frame, is recognised as that of its picture, on another machine too: the inputs, the
/// orthophotos, and the data files that affect voxels and looks (material file, classes, palettes,
/// blocks, voxelize.toml).
///   a file or folder   its name without the folder that contains it, files, bytes, and a hash: of
///                      names, sizes, and the first and the last 16 KiB of each file, where formats
///                      keep counts, times and indices. That takes two reads per file, however
///                      large. Hidden files and locks are ignored.
///   anything else      unchanged: an address, "generated:7"
/// @param is_output whether a file in a folder of inputs is ignored, since the program writes it
/// itself; called with the file's canonical path
/// @throws Error for a file that cannot be read
[[nodiscard]] std::vector<std::string> name_inputs(
    const std::vector<std::string>& inputs, const std::vector<std::filesystem::path>& orthophotos,
    const scene::Scene& scene, const IsOutput& is_output = {});

}  // namespace terravox::farm
