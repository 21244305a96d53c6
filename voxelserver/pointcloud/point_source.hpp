#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/geo/crs.hpp"
#include "voxelserver/pointcloud/point.hpp"
#include "voxelserver/pointcloud/spatial_index.hpp"

namespace terravox::pointcloud {

/// What is known of a file of points before its points are read. Coordinates are the file's own.
struct PointCloudInfo {
    std::filesystem::path path;
    std::uint64_t file_bytes = 0;
    std::uint64_t point_count = 0;
    /// The grid that coordinates lie on, scale * integer + offset along each axis, in double
    /// precision. A scale of 0: the file stores numbers that lie on no grid.
    std::array<double, 3> scale{}, offset{};
    std::array<double, 3> min{}, max{};  ///< closed; of all points, as far as the file is right
    bool measured_bounds = false;        ///< min and max are those of the points, not of a header
    std::optional<geo::Crs> crs;         ///< when the file names one that can be understood
};

/// A file of points, open for reading: the one thing that voxelizing knows of any format.
/// Immutable; all functions may be called from several threads at once.
///
/// A file whose content changes while it is open gives wrong points or an Error, never undefined
/// behaviour; noticing the change is the caller's task.
class PointSource {
public:
    virtual ~PointSource() = default;
    PointSource(const PointSource&) = delete;
    PointSource& operator=(const PointSource&) = delete;

    [[nodiscard]] const PointCloudInfo& info() const noexcept { return m_info; }

    /// Cuts the file into ranges of which each can be read without the others. Together they hold
    /// every point once, in order.
    /// @param points  how many a part should hold; parts that a format cannot cut hold more
    [[nodiscard]] virtual std::vector<PointRange> parts(std::uint64_t points) const = 0;

    /// Reads the points of the ranges in the order given. Memory is bounded by a batch, whatever
    /// the size of the ranges.
    /// @param ranges within [0, point_count]; empty ones are skipped
    /// @throws Error when the file is damaged or cut short, or a range ends beyond it; the sink may
    /// have been called for points before
    virtual void read(std::span<const PointRange> ranges, const PointBatchSink& sink) const = 0;

    /// A deterministic sample spread over the file, in file order.
    /// @param about  how many
    /// @throws Error as read
    [[nodiscard]] virtual std::vector<Point> sample(std::size_t about) const = 0;

    /// Whether the sample is of many parts all over the file, so that land without a sampled point
    /// is likely to be empty.
    [[nodiscard]] virtual bool sampled_all_over() const = 0;

    /// Which points lie where, as the file or a side file says.
    /// @return nullptr when nothing says so
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
