#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/export/core/columns.hpp"
#include "voxelserver/export/core/meter.hpp"

namespace terravox::exports {

/// A part of a world that is to be written in another format.
struct Part {
    int level = 0;
    voxel::VoxelBounds
        bounds;  ///< voxels of `level`, half-open, not empty, within the world's bounds

    /// The boxes that cover it. Those at its edges reach beyond: a writer leaves out what lies
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

/// What colour a voxel has in a format with colours.
enum class Colours : std::uint8_t {
    kMaterial,  ///< its material's
    kTrue,      ///< its own where it has one, else its material's
};

/// One conversion: where boxes come from, where files go, what was done so far. Thread-safe but for
/// the public fields.
class Job {
public:
    /// The references must outlive the job.
    Job(voxel::World& from, const Part& of, std::filesystem::path to, const voxel::Palette& looks,
        Meter& tells)
        : part(of), out(std::move(to)), palette(looks), meter(tells), m_world(from) {}

    const Part part;
    const std::filesystem::path out;  ///< what the person named: a file or a folder
    const voxel::Palette& palette;
    Meter& meter;  ///< one step for each column of boxes of the part that is done
    std::string name = "conversion";  ///< two that are alike in all that shapes their files have
                                      ///< the same: what a Journal begins with
    Colours colours = Colours::kTrue;
    int threads = 0;  ///< 0 = one for each core
    std::size_t memory_bytes = std::size_t{1}
                               << 30;  ///< what the writer may hold beside the world's own caches

    [[nodiscard]] const voxel::WorldInfo& world() const noexcept { return m_world.info(); }
    /// Edge of a voxel of the part, metres.
    [[nodiscard]] double voxel_m() const noexcept {
        return m_world.info().voxel_m * static_cast<double>(std::int64_t{1} << part.level);
    }

    /// A box of the part's level. A hole is told and counted. @throws voxel::ChangedError, with
    /// which the conversion ends
    [[nodiscard]] voxel::BoxOutcome outcome(std::int32_t bx, std::int32_t by, std::int32_t bz);
    /// @return nullptr = air, or a hole
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(std::int32_t bx, std::int32_t by,
                                                        std::int32_t bz) {
        return outcome(bx, by, bz).box;
    }
    /// As World::column, of the part's level, cut to the part; a hole is taken to reach through the
    /// whole part.
    [[nodiscard]] voxel::ColumnExtent column(std::int32_t bx, std::int32_t bz);

    /// As World::may_hold, of columns of boxes of the part (half-open), over its whole height; a
    /// hole may be something.
    [[nodiscard]] bool may_hold(const ColumnBlock& columns);
    /// The columns of boxes of the part in which something may stand; those that are left out are
    /// done, as the meter counts.
    [[nodiscard]] Columns columns(std::size_t edge);

    /// The colour that a voxel is to have.
    [[nodiscard]] voxel::Rgb8 colour_of(const voxel::VoxelAttr& attr) const noexcept {
        return attr.has_colour() && colours == Colours::kTrue ? attr.colour
                                                              : palette.of(attr.material).colour;
    }

    /// For the report: a finished file, and voxels that were written.
    void wrote(const std::filesystem::path& file);
    void count_voxels(std::uint64_t n) noexcept { m_voxels += n; }
    [[nodiscard]] std::uint64_t voxels() const noexcept { return m_voxels; }
    [[nodiscard]] std::vector<std::filesystem::path> files() const;
    [[nodiscard]] std::vector<voxel::BoxKey> holes() const;
    /// Slots in which the world's data are damaged, as far as known.
    [[nodiscard]] std::size_t damage() const { return m_world.damage().size(); }

private:
    void hole(const voxel::BoxKey& key, const char* what);
    voxel::World& m_world;
    std::atomic<std::uint64_t> m_voxels{0};
    mutable std::mutex m_mutex;
    std::vector<std::filesystem::path> m_files;
    std::set<voxel::BoxKey> m_holes;
};

}  // namespace terravox::exports
