#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/out/export/core/columns.hpp"

namespace terravox::exports {

/// Reports the progress of a conversion: a bar on a terminal, an occasional plain line elsewhere.
/// Writes to standard error. Thread-safe.
class Meter {
public:
    /// @param what text before the bar
    /// @param total steps
    /// @param quiet print nothing
    /// @param told called for each step with what is done and all there is, one call at a time
    Meter(std::string what, std::uint64_t total, bool quiet,
          std::function<void(std::uint64_t, std::uint64_t)> told = {});
    ~Meter() { finish(); }
    Meter(const Meter&) = delete;
    Meter& operator=(const Meter&) = delete;
    void add(std::uint64_t steps = 1);
    /// For callers that say how much of how much is done: adds the steps to that share.
    void reach(std::uint64_t done, std::uint64_t all);
    void finish();  ///< ends the bar's line; idempotent

private:
    void advance(std::uint64_t done);
    void show(bool last);
    const std::string m_what;
    const std::uint64_t m_total;
    const bool m_quiet;
    const bool m_terminal;
    const std::function<void(std::uint64_t, std::uint64_t)> m_told;
    std::mutex m_mutex;
    std::uint64_t m_done = 0;
    bool m_shown = false;
    bool m_finished = false;
    const std::chrono::steady_clock::time_point m_start;
    std::chrono::steady_clock::time_point m_last;
};

/// A part of a world that is to be written in another format.
struct Part {
    int level = 0;
    /// Voxels of `level`, half-open, not empty, within the world's bounds.
    voxel::VoxelBounds bounds;

    /// The boxes that cover it. Those at its edges extend beyond it: a writer leaves out what lies
    /// outside.
    [[nodiscard]] voxel::BoxRange boxes() const noexcept {
        voxel::BoxRange range = voxel::boxes_over(bounds, 0);
        range.min.level = range.max.level = level;
        return range;
    }
    [[nodiscard]] bool holds(std::int32_t x, std::int32_t y, std::int32_t z) const noexcept {
        return x >= bounds.min[0] && x < bounds.max[0] && y >= bounds.min[1] && y < bounds.max[1] &&
               z >= bounds.min[2] && z < bounds.max[2];
    }
};

/// Which colour a voxel has in a format with colours.
enum class Colours : std::uint8_t {
    kMaterial,  ///< its material's
    kTrue,      ///< its own where it has one, else its material's
};

/// One conversion: the source of boxes, the destination of files, the progress. Thread-safe except
/// for the public fields.
class Job {
public:
    /// The references must outlive the job.
    Job(voxel::World& from, const Part& of, std::filesystem::path to,
        const voxel::Palette& material_colours, Meter& progress)
        : part(of), out(std::move(to)), palette(material_colours), meter(progress), m_world(from) {}

    const Part part;
    const std::filesystem::path out;  ///< as the user named it: a file or a folder
    const voxel::Palette& palette;
    Meter& meter;  ///< one step for each finished column of boxes of the part
    /// The first line of a Journal. Two conversions have the same name when everything that affects
    /// their files is the same.
    std::string name = "conversion";
    Colours colours = Colours::kTrue;
    /// Data that were left out before the world was opened, since they are damaged: a line each.
    std::vector<std::string> left_out;
    int threads = 0;       ///< 0 = one for each core
    std::stop_token stop;  ///< ends the conversion, with an Error
    /// What the writer may hold in addition to the world's own caches.
    std::size_t memory_bytes = std::size_t{1} << 30;
    [[nodiscard]] const voxel::WorldInfo& world() const noexcept { return m_world.info(); }
    /// Edge of a voxel of the part, metres.
    [[nodiscard]] double voxel_m() const noexcept {
        return m_world.info().voxel_m * static_cast<double>(std::int64_t{1} << part.level);
    }

    /// A box of the part's level. A hole is logged and counted.
    /// @throws voxel::ChangedError, and Error "interrupted" once stopped, with which the conversion
    /// ends
    [[nodiscard]] voxel::BoxOutcome outcome(std::int32_t bx, std::int32_t by, std::int32_t bz);
    /// @return nullptr = air, or a hole
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(std::int32_t bx, std::int32_t by,
                                                        std::int32_t bz) {
        return outcome(bx, by, bz).box;
    }
    /// The extent of a column of the part's level, as World::column(), cut to the part; a hole is
    /// assumed to extend through the whole part.
    [[nodiscard]] voxel::ColumnExtent column(std::int32_t bx, std::int32_t bz);

    /// Whether columns of boxes of the part (half-open) may hold anything over its whole height, as
    /// World::may_hold(); true for a hole.
    [[nodiscard]] bool may_hold(const ColumnBlock& columns);
    /// The columns of boxes of the part that may hold anything; the meter counts those that are
    /// left out as finished.
    [[nodiscard]] Columns columns(std::size_t edge);

    /// The colour of a voxel in the output.
    [[nodiscard]] voxel::Rgb8 to_colour(const voxel::VoxelAttr& attr) const noexcept {
        return attr.has_colour() && colours == Colours::kTrue ? attr.colour
                                                              : palette.of(attr.material).colour;
    }

    /// For the report: a finished file, and voxels that were written.
    void wrote(const std::filesystem::path& file);
    void count_voxels(std::uint64_t n) noexcept { m_voxels += n; }
    [[nodiscard]] std::uint64_t voxels() const noexcept { return m_voxels; }
    [[nodiscard]] std::vector<std::filesystem::path> files() const;
    [[nodiscard]] std::vector<voxel::BoxKey> holes() const;
    /// Places where the world's data are damaged, as far as known, a line each.
    [[nodiscard]] std::vector<std::string> damage_lines() const;

private:
    void hole(const voxel::BoxKey& key, const char* what);
    voxel::World& m_world;
    std::atomic<std::uint64_t> m_voxels{0};
    mutable std::mutex m_mutex;
    std::vector<std::filesystem::path> m_files;
    std::set<voxel::BoxKey> m_holes;
};

/// The part of a world that the user requests.
struct Selection {
    int level = 0;
    /// West, south, east, north in the world's CRS; x0, z0, x1, z1 in voxels of level 0 in a world
    /// without one; empty: all.
    std::vector<double> area;
    std::vector<double> heights;  ///< lowest, highest, metres; empty: all
};

/// The part of a world inside a selection; where no area is given for an unbounded world, what a
/// camera frames.
/// @throws UsageError for a level that the world does not have, reversed limits, an empty result,
/// and more than 4096 boxes above each other
[[nodiscard]] Part make_part(const voxel::WorldInfo& world, const Selection& selection);

}  // namespace terravox::exports
