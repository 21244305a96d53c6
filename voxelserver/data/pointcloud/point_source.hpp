#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/geo/crs.hpp"
#include "voxelserver/data/pointcloud/point.hpp"

namespace terravox::pointcloud {

/// A spatial index of the points of a file. Immutable, so it may be shared between threads.
class SpatialIndex {
public:
    /// A closed rectangle in file coordinates, and points that lie in it. The rectangle may be
    /// infinite.
    struct Cell {
        double min_x = 0;
        double min_y = 0;
        double max_x = 0;
        double max_y = 0;
        PointRange points;
    };
    /// @param source  the index's origin, for messages
    /// @param chunks  whether each cell is one chunk of the file
    SpatialIndex(std::vector<Cell> cells, std::string source, bool chunks)
        : m_cells(std::move(cells)), m_source(std::move(source)), m_chunks(chunks) {}

    /// Ranges of points (sorted, merged, half-open) that contain every point inside the closed
    /// rectangle in file coordinates; they may contain others. Linear in the number of cells, some
    /// thousand for a square.
    [[nodiscard]] std::vector<PointRange> ranges_over(double min_x, double min_y, double max_x,
                                                      double max_y) const;
    /// Whether its cells correspond one to one to the file's chunks, as in COPC.
    [[nodiscard]] bool by_chunk() const noexcept { return m_chunks; }
    /// The same ranges, sorted, but not merged: one per cell.
    [[nodiscard]] std::vector<PointRange> cells_over(double min_x, double min_y, double max_x,
                                                     double max_y) const;
    [[nodiscard]] const std::string& source() const noexcept { return m_source; }

private:
    std::vector<Cell> m_cells;
    std::string m_source;
    bool m_chunks;
};

/// Metadata of a point file, available before its points are read. Coordinates are the file's own.
struct PointCloudInfo {
    std::filesystem::path path;
    std::uint64_t file_bytes = 0;
    std::uint64_t point_count = 0;
    /// The grid of the coordinates: scale * integer + offset along each axis, in double precision.
    /// A scale of 0: the coordinates are not quantised.
    std::array<double, 3> scale{};
    std::array<double, 3> offset{};
    /// Closed bounds of all points; if not measured_bounds, as claimed by the file.
    std::array<double, 3> min{};
    std::array<double, 3> max{};
    /// Whether min and max were computed from the points instead of read from a header.
    bool measured_bounds = false;
    std::optional<geo::Crs> crs;  ///< nullopt when the file has none that can be used
    std::string crs_fault;        ///< why it cannot; empty: it has none
};

/// A file of points, open for reading: the format-independent interface that voxelization uses.
/// Immutable; all functions may be called from several threads at once.
///
/// A file whose content changes while it is open gives wrong points or an Error, never undefined
/// behaviour; detecting the change is the caller's task.
class PointSource {
public:
    virtual ~PointSource() = default;
    PointSource(const PointSource&) = delete;
    PointSource& operator=(const PointSource&) = delete;

    [[nodiscard]] const PointCloudInfo& info() const noexcept { return m_info; }

    /// Divides the file into ranges that can be read independently. Together they hold every point
    /// once, in order.
    /// @param points  desired number of points per part; parts that a format cannot divide hold
    /// more
    [[nodiscard]] virtual std::vector<PointRange> parts(std::uint64_t points) const = 0;

    /// Reads the points of the ranges in the given order. Memory is bounded by the size of a batch,
    /// whatever the size of the ranges.
    /// @param ranges within [0, point_count]; empty ones are skipped
    /// @throws Error when the file is damaged or truncated, or a range ends beyond it; the sink may
    /// have been called for earlier points
    virtual void read(std::span<const PointRange> ranges, const PointBatchSink& sink) const = 0;

    /// As read(), but intensities and flight lines may be left 0 where that saves time.
    virtual void read_without_echoes(std::span<const PointRange> ranges,
                                     const PointBatchSink& sink) const {
        read(ranges, sink);
    }

    /// A deterministic sample spread over the file, in file order.
    /// @param about  approximate number of points
    /// @throws Error as read
    [[nodiscard]] virtual std::vector<Point> sample(std::size_t about) const = 0;

    /// Whether the sample is taken from many parts all over the file, so that areas without a
    /// sampled point are likely to be empty.
    [[nodiscard]] virtual bool sampled_all_over() const = 0;

    /// The spatial index of the file, from the file itself or a side file.
    /// @return nullptr when there is none
    /// @throws Error when the index is damaged or belongs to another file
    [[nodiscard]] virtual std::shared_ptr<const SpatialIndex> spatial_index() const {
        return nullptr;
    }

protected:
    explicit PointSource(PointCloudInfo info) : m_info(std::move(info)) {}

private:
    const PointCloudInfo m_info;
};

}  // namespace terravox::pointcloud
