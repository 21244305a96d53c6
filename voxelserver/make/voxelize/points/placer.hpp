#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/data/grid/frame.hpp"
#include "voxelserver/data/pointcloud/point_source.hpp"
#include "voxelserver/data/store/square.hpp"
#include "voxelserver/make/voxelize/points/brightness.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"

namespace terravox::voxelize {

/// One file of the world and how it is read into voxel space. Immutable once the world is open.
struct SquareSource {
    voxel::Fingerprint identity{};       ///< common/voxel/fingerprint.hpp
    voxel::Fingerprint side_identity{};  ///< of its side file; zeros: it has none
    std::shared_ptr<const pointcloud::PointSource> points;
    /// Of the points, with a CRS; min and max hold all kept points, whatever the header states
    /// (extent.hpp).
    pointcloud::PointCloudInfo info;
    double vertical_metres = 1;  ///< metres per unit of the file's heights
    bool transform = false;      ///< the file's CRS differs from the frame's
    grid::ColumnRect bounds;     ///< of info's min and max
    /// Parts of the bounds, kilometres apart, outside which there is nothing; mostly one, the
    /// bounds.
    std::vector<grid::ColumnRect> islands;
    /// Heights beyond these are outliers; file units, within info's min and max.
    double lowest = 0;
    double highest = 0;
    bool has_colour = false;
    /// Bits to drop for 8-bit colour: the format has 16 bits a channel, but many writers store 8.
    int colour_shift = 0;
    BrightnessScale brightness;  ///< unknown where points have colours
    /// The spatial index in the file or a side file; nullptr where there is none, and where the
    /// file's CRS differs from the frame's.
    std::shared_ptr<const pointcloud::SpatialIndex> spatial_index;

    [[nodiscard]] bool on_island(std::int32_t x, std::int32_t z) const noexcept {
        return std::any_of(islands.begin(), islands.end(), [&](const grid::ColumnRect& r) {
            return x >= r.min_x && x < r.max_x && z >= r.min_z && z < r.max_z;
        });
    }
};
/// Of the file and of how it is read.
/// @param source with a CRS
[[nodiscard]] voxel::Fingerprint to_fingerprint(const SquareSource& source);

/// Whether the filters and the class table keep a return.
enum class FilterResult { kKept, kWithheld, kNoise };
[[nodiscard]] inline FilterResult to_filter_result(const pointcloud::Point& p,
                                                   const Settings::Points& filters,
                                                   const ClassTable& classes) noexcept {
    if ((p.withheld && filters.drop_withheld) || (p.overlap && filters.drop_overlap))
        return FilterResult::kWithheld;
    return classes.meaning[p.classification].role == Role::kDrop ? FilterResult::kNoise
                                                                 : FilterResult::kKept;
}

/// Steps "transformation" and "quantization": turns returns as a file stores them into voxel
/// points, and leaves out those that are filtered. One for each thread.
class Placer {
public:
    Placer(const SquareSource& source, const grid::Frame& frame, const ClassTable& classes,
           const Settings::Points& filters);

    /// @param wanted only points of these patches; nullopt = all
    void place(std::span<const pointcloud::Point> batch,
               const std::optional<grid::PatchRect>& wanted, store::PatchedPoints& out,
               store::PointCounts& counts);

    [[nodiscard]] double transformation_s() const noexcept { return m_transformation_s; }
    [[nodiscard]] double quantization_s() const noexcept { return m_quantization_s; }

private:
    void transform(std::span<const pointcloud::Point> batch, store::PointCounts& counts);
    void quantize(std::span<const pointcloud::Point> batch,
                  const std::optional<grid::PatchRect>& wanted, store::PatchedPoints& out,
                  store::PointCounts& counts);

    const SquareSource& m_source;
    const grid::Frame& m_frame;
    const ClassTable& m_classes;
    const Settings::Points m_filters;
    std::optional<geo::Transform> m_transform;
    std::array<double, 3> m_min{}, m_max{};  // coordinates that are no outliers, closed
    std::vector<std::uint32_t> m_kept;       // indices into the batch
    std::vector<double> m_x, m_y;            // of those kept, in the frame's CRS
    double m_transformation_s = 0;
    double m_quantization_s = 0;
};

}  // namespace terravox::voxelize
