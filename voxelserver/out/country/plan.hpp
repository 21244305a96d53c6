#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/out/export/core/job.hpp"

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

/// The folder of a plan: plan.json, and what its tasks leave there (docs/formats/country-plan.md).
/// A path and nothing more; const functions do not look at the disk.
class PlanFolder {
public:
    /// @param folder that exists
    /// @throws UsageError when it does not, or its scratch() is a link
    explicit PlanFolder(const std::filesystem::path& folder);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] std::filesystem::path plan() const { return m_path / "plan.json"; }
    /// What opening has found of the squares, so that tasks need not read all of them
    /// (voxelize/points/known_squares.hpp). Without it they do.
    [[nodiscard]] std::filesystem::path known_squares() const { return m_path / "squares.known"; }
    /// Which points of the squares lie where, so that a patch reads parts of them alone.
    [[nodiscard]] std::filesystem::path chunks() const { return m_path / "chunks"; }
    /// Facts of the last `country run`: where its archive goes.
    [[nodiscard]] std::filesystem::path run() const { return m_path / "run.json"; }
    [[nodiscard]] std::filesystem::path run_lock() const { return m_path / "run.lock"; }
    [[nodiscard]] std::filesystem::path scratch() const { return m_path / "scratch"; }

    /// @param number of a shard, 1 to the number of shards
    [[nodiscard]] std::filesystem::path shard(int number) const;
    [[nodiscard]] std::filesystem::path lock(int number) const;
    [[nodiscard]] std::filesystem::path record(int number) const;  ///< how the task ended
    [[nodiscard]] std::filesystem::path log(int number) const;     ///< what it said

    /// Makes the folders for all of these.
    /// @throws Error
    void make_folders() const;

private:
    [[nodiscard]] std::filesystem::path of_task(int number, const char* ending) const;
    std::filesystem::path m_path;  ///< absolute, without links
};

/// Names the bytes of PlanFolder::known_squares(): 32 hexadecimal digits.
[[nodiscard]] std::string fingerprint_of_known(std::string_view bytes);
/// Whether the facts that are there are those of the plan (Plan::known_squares).
[[nodiscard]] bool has_known_squares(const PlanFolder& folder, const Plan& plan);

/// Writes plan.json, whole or not at all. Paths of the plan that were given relative to the current
/// folder are written relative to the plan's, so that both can be moved together, or mounted
/// elsewhere.
/// @throws Error
void write_plan(const PlanFolder& folder, const Plan& plan);

/// @throws UsageError when there is no plan; Error when it is damaged, of another version of the
/// format, or holds values that no plan has
[[nodiscard]] Plan read_plan(const PlanFolder& folder);

struct PlanOptions {
    worlds::WorldOptions world;
    std::vector<double> area;     ///< as exports::Selection
    std::vector<double> heights;  ///< as exports::Selection
    int shards = 0;               ///< 0: so many that each takes about kUsualTask_s
    std::size_t sample = 6;       ///< columns of boxes to measure
    std::uint64_t scratch_bytes = std::uint64_t{2} << 30;
    std::filesystem::path scratch;  ///< folder for the squares of the sample; it is removed
    static constexpr double kUsualTask_s = 900;
};

struct PlannedCountry {
    Plan plan;
    std::string known_squares;  ///< bytes of PlanFolder::known_squares()
};

/// Plans a country: looks at all inputs, opens the world of those that can be read, measures some
/// places, and foresees the rest.
/// @param progress called with the places that were measured, and all of them
/// @throws UsageError for inputs and options that do not apply; Error when the world cannot be
/// opened
[[nodiscard]] PlannedCountry make_plan(
    const PlanOptions& options, const std::function<void(std::size_t, std::size_t)>& progress = {});

/// A folder of a plan for what is needed for a while only; it is removed in the end.
class ScratchFolder {
public:
    /// @param path need not exist
    explicit ScratchFolder(std::filesystem::path path) : m_path(std::move(path)) {}
    ~ScratchFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(m_path, ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }

private:
    const std::filesystem::path m_path;
};

}  // namespace terravox::country
