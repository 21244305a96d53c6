#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/out/export/core/part.hpp"

namespace terravox::country {

inline constexpr int kPlanVersion = 1;
/// Most shards of a plan.
inline constexpr int kMaxShards = 65536;

/// A file as it was when the plan was made.
struct PlannedFile {
    std::filesystem::path file;
    std::uint64_t bytes = 0;
    std::uint64_t points = 0;  ///< as its header says; 0 of an image
    std::string identity;      ///< 32 hexadecimal digits, of size, time, beginning and end
};

/// A square that was asked for and cannot be read: a hole of the country.
struct MissingSquare {
    std::string name;
    std::string reason;  ///< one line
};

/// What the plan foresees of one shard, when it is made alone.
struct PlannedShard {
    std::uint64_t columns = 0;   ///< columns of boxes of the coarsest level of a shard
    std::uint64_t subtrees = 0;  ///< steps in which it is made
    std::uint64_t squares = 0;   ///< squares that are decoded for it
    double cpu_s = 0;
    std::uint64_t scratch_bytes = 0;
};

/// A measured quantity. The error is that of the sample: the truth lies within value +- error with
/// a probability of about 95 %, as far as the sample stands for the rest.
struct Measured {
    double value = 0;
    double error = 0;
};

/// What the plan foresees of the country, from a sample.
struct Estimate {
    std::uint64_t sampled_columns = 0;
    Measured cpu_s;              ///< each shard made alone: squares are decoded for each anew
    Measured one_machine_cpu_s;  ///< shards that are made after each other share decoded squares
    double memory_mib = 0;       ///< of a task
    Measured output_bytes;
};

/// How the archive of a country is made: of which data, in which shards. Plain data.
struct Plan {
    std::string program;           ///< version
    std::uint32_t box_recipe = 0;  ///< voxelize::kBoxRecipe
    /// Inputs and options that matter for voxels, and the memory of a task. Paths are absolute.
    worlds::WorldOptions world;
    std::vector<double> area;     ///< as exports::Selection; empty: all
    std::vector<double> heights;  ///< as exports::Selection; empty: all
    /// Of all inputs and settings, as voxel::ProvenanceWorld::fingerprint(): 32 digits.
    std::string fingerprint;
    /// Of what all boxes depend on (OpenedCountry::fingerprint_of_all_boxes()): while it is the
    /// same, a part of an archive can be made anew.
    std::string fingerprint_of_all_boxes;
    /// Of the bytes of PlanFolder::known_squares() that belong to these data, 32 digits
    /// (fingerprint_of_known()). Other bytes say where squares lay, but not what their intensities
    /// meant in the plan's archive.
    std::string known_squares;
    std::string crs;  ///< name
    double voxel_m = 1;
    voxel::VoxelBounds bounds;  ///< of the part that is made
    std::vector<PlannedFile> squares;
    std::vector<PlannedFile> images;
    std::vector<MissingSquare> missing;
    std::uint64_t scratch_bytes = 0;  ///< limit of decoded squares that a task keeps on disk
    std::vector<PlannedShard> shards;
    Estimate estimate;

    [[nodiscard]] exports::Selection selection() const { return {0, area, heights}; }

    /// Identifies what is made, in shards and journals: everything above that affects their bytes.
    [[nodiscard]] std::string id() const;
    /// The conversion that its shards name (voxel::archive::Shard::job).
    [[nodiscard]] std::string job() const { return "terravox country " + id(); }
};

}  // namespace terravox::country
