#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

/// Which axis of a file is up.
enum class UpAxis : std::uint8_t {
    kZ,  ///< x east, y north, z up: as in Blender
    kY,  ///< x east, y up, z south: as in Houdini
};

/// One of several conversions that share a world, each on a machine of its own.
struct ShardChoice {
    int number = 0;  ///< 1 to `of`
    int of = 0;      ///< 0: no shard, but the whole world
    static constexpr int kMost = 100'000;
};

/// A column of boxes of level 0 of what is written.
struct ColumnAt {
    std::int32_t bx = 0;
    std::int32_t bz = 0;
};
/// Columns of boxes that are made anew, as a change of an archive.
struct ChangedColumns {
    std::vector<ColumnAt> replaced;  ///< empty: no change, but all is written
    std::vector<ColumnAt> compared;  ///< that have not changed: what patches compares them
};

/// What a user can choose of the written form. Each format reads those members that apply to it.
struct WriteOptions {
    UpAxis up = UpAxis::kZ;   ///< of .vdb
    bool merge_faces = true;  ///< of meshes: adjacent faces of one appearance become one
    int colour_steps = 0;     ///< of meshes: steps of each colour channel, 0 = colours as they are
    bool overwrite = false;   ///< earlier output may be replaced
    std::string title;        ///< of Minecraft worlds; empty: the world's, else the folder's name
    ShardChoice shard;        ///< of archives
    ChangedColumns changed;   ///< of archives
};

/// A format that a world can be converted to. A new format is a folder below voxelserver/out/export
/// that defines one of these, and a row of formats() (voxelserver/out/export/formats/formats.cpp).
struct Format {
    std::string_view name;         ///< for --to
    std::string_view extension;    ///< of the output, lower case, with its dot; empty: a folder
    std::string_view folder = {};  ///< what a folder of it is, for messages: "a Minecraft world"
    /// Tests whether `out` may be written, before the world is opened.
    /// @throws UsageError when something is there that is not to be replaced; Error when the folder
    /// cannot be written
    void (*check_target)(const std::filesystem::path& out, const WriteOptions& options);
    /// The number of steps that write() reports to the job's meter.
    std::uint64_t (*steps)(const Part& part, const voxel::WorldInfo& world);
    /// Writes the job's part to the job's output.
    /// @throws UsageError for options out of range; Error when it cannot be written
    void (*write)(Job& job, const WriteOptions& options);
    bool has_title = false;   ///< whether WriteOptions::title applies to it
    bool has_shards = false;  ///< whether WriteOptions::shard and changed apply
};

/// check_target() of formats that write one file.
void check_file_target(const std::filesystem::path& out, const WriteOptions& options);

/// steps() of formats that take one step for each column of boxes.
[[nodiscard]] std::uint64_t column_steps(const Part& part, const voxel::WorldInfo& world);

/// What a change of a part replaces and compares.
/// @param changed, others  columns of boxes of the world's level 0
/// @return columns of the part's level; a coarser one that holds columns of both kinds is replaced
[[nodiscard]] ChangedColumns changed_columns(const Part& part, std::span<const ColumnAt> changed,
                                             std::span<const ColumnAt> others);

}  // namespace terravox::exports
