#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::procedural {

/// Parameters of a generated world: equal settings give equal voxels, on every machine. Heights and
/// lengths are voxels of level 0.
struct Settings {
    std::uint64_t seed = 1;
    /// The sea's surface is the upper face of voxel water_level - 1; 0 and multiples of large
    /// powers of two are at the same height on all levels; [-4096, 4096]
    int water_level = 0;
    /// Approximate height of the highest summits above the sea; the deepest sea is half as deep;
    /// [8, 4096]
    int world_height = 160;
    /// Octaves of hills and ridges, each twice as fine as the one before; [1, 16]
    int harmonics = 6;
    /// Frequency of the first octave of the hills, 1 / voxels; continents and climates are wider by
    /// fixed ratios; [1e-5, 0.1]
    double frequency = 1.0 / 256;
    /// Height of an octave relative to the one before: 0 smooth, 1 jagged; [0, 1]
    double smoothness = 0.45;
    double voxel_m = 1;  ///< edge of a voxel, metres; (0, 1000]
    bool trees = true;   ///< and bushes, cacti, grass tufts

    friend bool operator==(const Settings&, const Settings&) = default;
};

/// @throws UsageError naming field, value and allowed range
void check(const Settings& settings);

}  // namespace terravox::procedural

namespace terravox::worlds {

/// The inputs and settings of a world of any kind. A kind of world ignores the settings that do not
/// concern it.
struct WorldOptions {
    /// Paths or addresses, all of one kind (voxelserver/make/worlds/open/open_world.hpp); several
    /// only of LiDAR data and rasters of heights.
    std::vector<std::string> inputs;
    /// Files of points that the inputs name and that are not opened.
    std::vector<std::filesystem::path> left_out;
    /// Images, or folders of them, for LiDAR data, stores and rasters of heights.
    std::vector<std::filesystem::path> orthophotos;

    /// Planned objects that are put into the world
    /// (voxelserver/make/worlds/overlay/overlay_world.hpp).
    std::vector<std::string> additions;

    std::string plane;  ///< of pictures: "table" or "sea" beneath; else nothing
    std::string title;  ///< of a world of LiDAR data; empty: by the inputs
    std::string crs;    ///< overrides that of the files; empty: theirs
    /// Id of a LiDAR class table, or a path to one; "auto": the one that is meant for the files.
    std::string classes = "auto";
    bool mark_unknown = false;       ///< show LiDAR classes that the table does not name
    std::string vertical_unit;       ///< "m", "ft" or "us-ft"; empty: from the files
    std::filesystem::path settings;  ///< of voxelization; empty: config/voxelize.toml
    std::string steps;               ///< of voxelization that run; empty: as in the settings
    std::string photo;               ///< "raw" or "albedo" (LiDAR data); empty: as in the settings
    double voxel_m = 1;              ///< edge of a voxel at level 0, metres
    std::string dimension = "overworld";  ///< of a Minecraft world
    /// For rasters of heights: rock down to this height, metres; default: a little below the
    /// lowest.
    std::optional<double> base_m;
    /// For procedural worlds. Its voxel_m is not used, the one above is; a seed in the input
    /// overrides its seed.
    procedural::Settings generated;

    /// What an earlier opening has found of LiDAR files (LidarWorldOptions); empty: nothing.
    std::filesystem::path known_squares;
    std::filesystem::path chunk_indices;  ///< of LiDAR files (LidarWorldOptions); empty: none
    bool reads_chunk_indices = false;     ///< rather than only write them

    std::size_t memory_bytes = std::size_t{4} << 30;  ///< decoded squares, chunks and columns
    int threads = 0;                                  ///< 0: one for each core
    std::filesystem::path cache_dir;  ///< keeps prepared LiDAR squares; empty: nothing is kept
    std::uint64_t cache_bytes = std::uint64_t{20} << 30;  ///< limit of cache_dir
    std::chrono::seconds box_timeout{300};  ///< for each box of a voxel server or remote archive
};

/// Rejects command-line options that do not apply to the kind of world that is opened.
/// @param input names the world in the message
/// @param noun of its kind, with an article (WorldKind::noun)
/// @param suitable flags that apply to the kind, separated by spaces; empty: none
/// @param given command-line flags that apply to some kinds of worlds only
/// @throws UsageError naming the first that does not apply, and those that do
void check_flags(const std::string& input, std::string_view noun, std::string_view suitable,
                 std::span<const std::string> given);

/// Whether a world's input is an address (of a voxel server, or of an archive on a web server)
/// rather than a path. Says nothing about whether the address is valid.
[[nodiscard]] inline bool is_http_address(const std::string& input) noexcept {
    return input.starts_with("http://") || input.starts_with("https://");
}

}  // namespace terravox::worlds
