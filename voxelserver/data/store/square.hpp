#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/voxel/material.hpp"
#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/data/pointcloud/point.hpp"

namespace terravox::store {

/// One return in voxel space, in fixed point: x and z are relative to the first column of its
/// patch, y is absolute. Because fractions are rounded down, `>> bits` gives exactly the voxel that
/// contained the original point. Stored as is in prepared squares.
struct VoxelPoint {
    static constexpr int kPlanBits = 10;    ///< fraction of x and z: 64 columns fill 16 bits
    static constexpr int kHeightBits = 12;  ///< fraction of y: heights up to 524,287 voxels
    std::uint16_t x = 0;
    std::uint16_t z = 0;
    std::int32_t y = 0;
    std::uint8_t source_class = 0;
    /// Of the point itself where its square has colours; elsewhere `r` is its brightness.
    voxel::Rgb8 colour;

    [[nodiscard]] int column() const noexcept { return (z >> kPlanBits) * 64 + (x >> kPlanBits); }
    [[nodiscard]] float height() const noexcept {
        return static_cast<float>(y) * (1.0f / (1 << kHeightBits));
    }
    /// How bright a single return is, in hundredths of bright ground, up to 255; 0 = not known.
    /// Valid where the square has no colours.
    [[nodiscard]] std::uint8_t brightness() const noexcept { return colour.r; }
    [[nodiscard]] std::int32_t voxel_y() const noexcept { return y >> kHeightBits; }
};
static_assert(sizeof(VoxelPoint) == 12);

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

[[nodiscard]] std::uint64_t compute_checksum(std::span<const VoxelPoint> points) noexcept;

/// Points with the patch of each, in file order: consecutive points mostly share a patch, so
/// patches are stored as runs.
struct PatchedPoints {
    struct Run {
        grid::PatchKey patch;
        std::size_t begin = 0;
    };
    std::vector<VoxelPoint> points;
    std::vector<Run> runs;  ///< each extends to the beginning of the next one
    void add(grid::PatchKey patch, const VoxelPoint& point) {
        if (runs.empty() || !(runs.back().patch == patch))
            runs.push_back({patch, points.size()});
        points.push_back(point);
    }
};

/// Step "binning": groups the points of all parts by patch and column. The result does not depend
/// on how the points were divided into parts.
/// @param threads 0 = one per core
[[nodiscard]] std::shared_ptr<const Square> bin_points(std::vector<PatchedPoints> parts,
                                                       const PointCounts& counts, int threads);

/// Maps chunks of a file to the patches that their points lie in: built when a file is decoded for
/// the first time, so that later only the required part needs to be decoded.
class ChunkIndex {
public:
    struct Chunk {
        pointcloud::PointRange points;
        std::vector<grid::PatchKey> patches;  ///< sorted, without duplicates
    };
    ChunkIndex() = default;
    /// @param chunks in ascending order of points
    explicit ChunkIndex(std::vector<Chunk> chunks) : m_chunks(std::move(chunks)) {}

    /// The chunks that hold points of the rectangle's patches, ascending.
    [[nodiscard]] std::vector<std::size_t> over(const grid::PatchRect& rect) const;
    /// Ranges that contain every kept point of the rectangle's patches, sorted and merged; they may
    /// contain others.
    [[nodiscard]] std::vector<pointcloud::PointRange> ranges_over(
        const grid::PatchRect& rect) const;
    [[nodiscard]] std::span<const Chunk> chunks() const noexcept { return m_chunks; }

private:
    std::vector<Chunk> m_chunks;
};

}  // namespace terravox::store
