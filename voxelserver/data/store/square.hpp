#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/data/store/voxel_point.hpp"

namespace terravox::store {

/// The range of one patch in a square's points. Stored as is in prepared squares.
struct PatchEntry {
    grid::PatchKey key;
    std::uint64_t begin = 0;
    std::uint64_t count = 0;
    /// XXH64 of the points' bytes; set when the square is written to disk.
    std::uint64_t checksum = 0;
};
static_assert(sizeof(PatchEntry) == 32);

/// Statistics from decoding a square. Stored as is in prepared squares.
struct PointCounts {
    std::uint64_t kept = 0;
    std::uint64_t outliers = 0;  ///< far outside the bounds: errors of the survey
    /// Marked as withheld by the survey, or as overlap where that is dropped.
    std::uint64_t withheld = 0;
    std::uint64_t noise = 0;                    ///< of classes that the table drops
    std::array<std::uint64_t, 256> by_class{};  ///< of the points kept
    void add(const PointCounts& other) noexcept;
};

/// Some or all points of a LiDAR file in voxel space, grouped by patch; within a patch by column
/// (z, then x), then by ascending y. Immutable. The points are in memory owned by this object, or
/// in a mapped file that it keeps open.
class Square {
public:
    /// @param holder keeps the memory of both spans alive
    /// @param patches sorted by key
    Square(std::shared_ptr<const void> holder, std::span<const PatchEntry> patches,
           std::span<const VoxelPoint> points, const PointCounts& counts, std::size_t memory_bytes,
           bool checked)
        : m_holder(std::move(holder)),
          m_patches(patches),
          m_points(points),
          m_counts(counts),
          m_memory_bytes(memory_bytes),
          m_checked(checked) {}

    /// @throws Error when the patch's checksum does not match (only a mapped file can be damaged)
    [[nodiscard]] std::span<const VoxelPoint> points(grid::PatchKey patch) const;
    [[nodiscard]] std::span<const PatchEntry> patches() const noexcept { return m_patches; }
    [[nodiscard]] std::span<const VoxelPoint> all() const noexcept { return m_points; }
    [[nodiscard]] const PointCounts& counts() const noexcept { return m_counts; }
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return m_memory_bytes + sizeof *this;
    }

private:
    std::shared_ptr<const void> m_holder;
    std::span<const PatchEntry> m_patches;
    std::span<const VoxelPoint> m_points;
    PointCounts m_counts;
    std::size_t m_memory_bytes;  ///< includes mapped pages: they are resident while in use
    bool m_checked;              ///< checksums need not be verified
};

[[nodiscard]] std::uint64_t checksum_of(std::span<const VoxelPoint> points) noexcept;

/// Points with the patch of each, in file order: consecutive points mostly share a patch, so
/// patches are stored as runs.
struct PatchedPoints {
    struct Run {
        grid::PatchKey patch;
        std::size_t begin = 0;
        /// For binning: first the patch's number, then the destination of the run.
        std::size_t place = 0;
    };
    std::vector<VoxelPoint> points;
    std::vector<Run> runs;  ///< each extends to the beginning of the next one
    void add(grid::PatchKey patch, const VoxelPoint& point) {
        if (runs.empty() || !(runs.back().patch == patch))
            runs.push_back({patch, points.size(), 0});
        points.push_back(point);
    }
};

/// Step "binning": groups the points of all parts by patch and column. The result does not depend
/// on how the points were divided into parts.
/// @param threads 0 = one per core
[[nodiscard]] std::shared_ptr<const Square> bin_points(std::vector<PatchedPoints> parts,
                                                       const PointCounts& counts, int threads);

}  // namespace terravox::store
