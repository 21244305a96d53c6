#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>

#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/pointcloud/point_format.hpp"
#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::lidar {

/// The entry of LAS, LAZ and COPC in the list of point formats (pointcloud/point_format.hpp).
struct LasFormat {
    static constexpr std::string_view kName = "LAS, LAZ or COPC";
    static constexpr std::array<std::string_view, 2> kEndings{".las", ".laz"};
    static constexpr std::string_view kSideEnding{};  ///< none: an index does not affect voxels
    [[nodiscard]] static pointcloud::Recognition recognise(std::string_view head) noexcept;
    [[nodiscard]] static std::unique_ptr<const pointcloud::PointSource> open(
        const std::filesystem::path& path);
};

/// A LAS, LAZ or COPC file as a source of points. Its parts are chunks of the file.
class LasSource final : public pointcloud::PointSource {
public:
    /// Reads and checks the header; reads no points.
    /// @throws Error as read_las_info
    explicit LasSource(const std::filesystem::path& path);

    [[nodiscard]] std::vector<PointRange> parts(std::uint64_t points) const override;
    void read(std::span<const PointRange> ranges,
              const pointcloud::PointBatchSink& sink) const override;
    void read_without_echoes(std::span<const PointRange> ranges,
                             const pointcloud::PointBatchSink& sink) const override;
    [[nodiscard]] std::vector<pointcloud::Point> sample(std::size_t about) const override;
    [[nodiscard]] bool sampled_all_over() const override;
    /// The COPC hierarchy, else the .lax file next to the point cloud (spatial_index.hpp).
    [[nodiscard]] std::shared_ptr<const pointcloud::SpatialIndex> spatial_index() const override;

private:
    void read(std::span<const PointRange> ranges, const pointcloud::PointBatchSink& sink,
              Echoes echoes) const;
    explicit LasSource(LasInfo las);

    const LasInfo m_las;
};

}  // namespace terravox::lidar
