#pragma once

#include <filesystem>
#include <vector>

#include "voxelserver/data/ply/ply_header.hpp"
#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::ply {

/// A PLY point cloud as a source of points. Since the format has neither bounds nor an index,
/// opening reads all vertices once, and keeps their bounds and, for text files, the offset of every
/// 50,000th.
class PlySource final : public pointcloud::PointSource {
public:
    /// @throws Error naming the fault in the header or in any vertex
    explicit PlySource(const std::filesystem::path& path);

    [[nodiscard]] std::vector<pointcloud::PointRange> parts(std::uint64_t points) const override;
    void read(std::span<const pointcloud::PointRange> ranges,
              const pointcloud::PointBatchSink& sink) const override;
    /// Samples the beginnings of 64 sections of the file.
    [[nodiscard]] std::vector<pointcloud::Point> sample(std::size_t about) const override;
    [[nodiscard]] bool sampled_all_over() const override;

private:
    struct Contents {
        pointcloud::PointCloudInfo info;
        Header header;
        std::vector<std::uint64_t> part_at;  ///< offset of every 50,000th vertex, bytes
    };
    [[nodiscard]] static Contents scan(const std::filesystem::path& path);
    explicit PlySource(Contents contents);

    const Header m_header;
    const std::vector<std::uint64_t> m_part_at;
};

}  // namespace terravox::ply
