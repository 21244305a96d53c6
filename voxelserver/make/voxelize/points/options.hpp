#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace terravox::voxelize {

/// LidarWorldOptions::classes: whichever table is meant for such files (class_choice.hpp).
inline constexpr const char* kAnyClassTable = "auto";

/// The inputs of a LiDAR world.
struct LidarWorldOptions {
    std::vector<std::filesystem::path> files;        ///< of points, or folders of them
    std::vector<std::filesystem::path> left_out;     ///< those of them that are not opened
    std::vector<std::filesystem::path> orthophotos;  ///< image files or folders; may be empty
    std::string classes = kAnyClassTable;            ///< id of a class table, or a path to one
    bool mark_unknown = false;                       ///< show classes that the table does not name
    std::filesystem::path settings;  ///< which steps run and how; empty = config/voxelize.toml
    std::string steps;  ///< switches steps over the settings (switch_steps); empty = no change
    std::string photo;  ///< "raw" or "albedo": colours of orthophotos; empty: as settings say
    std::optional<std::string> crs;  ///< overrides that of the files
    /// The CRS of files that carry none, by the paths in `files`, as a store has recorded it.
    std::map<std::filesystem::path, std::string> recorded_crs;
    std::string title;        ///< of the world; empty: by the files
    std::string licence;      ///< of the data, for WorldInfo; empty = unknown
    std::string attribution;  ///< as above
    /// "m", "ft" or "us-ft"; default: from the CRS, else its horizontal unit.
    std::optional<std::string> vertical_unit;
    double voxel_m = 1;
    /// File with what an earlier opening has found of the files (known_squares.hpp): those that
    /// have not changed are not read again. Empty: none.
    std::filesystem::path known_squares;
    /// Folder that receives the chunk index of each file that is decoded: which of its points lie
    /// where (store/square.hpp). Nothing is ever removed from it. Empty: none.
    std::filesystem::path chunk_indices;
    /// Whether files are read in parts by the indices that chunk_indices holds already. Faster
    /// where few places of many files are needed, slower where most of each file is.
    bool reads_chunk_indices = false;
    /// For decoded squares, columns and boxes together; at least 24 MiB are used.
    std::size_t memory_bytes = std::size_t{4} << 30;
    int threads = 0;  ///< 0 = one for each core
    /// Folder in which prepared squares are kept, so that a restart need not decode them again;
    /// empty = nothing is kept on disk.
    std::filesystem::path cache_dir;
    /// Limit of cache_dir: the least recently used squares are removed first.
    std::uint64_t cache_bytes = std::uint64_t{20} << 30;
};

/// The point files that the options name, and those in the folders that they name, sorted by path.
/// Without those that the options leave out.
/// @throws UsageError when there are none
[[nodiscard]] std::vector<std::filesystem::path> lidar_files(const LidarWorldOptions& options);

/// The title of a world: that of the options; else the name of its only input, or of the folder in
/// which all of its inputs lie; else the name of the first one, and how many more there are.
[[nodiscard]] std::string world_title(const LidarWorldOptions& options);

}  // namespace terravox::voxelize
