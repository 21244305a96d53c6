#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/geo/crs.hpp"
#include "voxelserver/data/ply/ply_file.hpp"
#include "voxelserver/data/pointcloud/point_format.hpp"
#include "voxelserver/data/pointcloud/point_source.hpp"

namespace terravox::ply {

/// The entry of PLY in the list of point formats (pointcloud/point_format.hpp).
struct PlyFormat {
    static constexpr std::string_view kName = "PLY";
    static constexpr std::array<std::string_view, 1> kEndings{".ply"};
    static constexpr std::string_view kSideEnding = ".prj";
    /// @return kOther for a file with faces: a mesh, like those that the exporters write
    [[nodiscard]] static pointcloud::Recognition recognise(std::string_view head) noexcept;
    [[nodiscard]] static std::unique_ptr<const pointcloud::PointSource> open(
        const std::filesystem::path& path);
};

/// The CRS of a file, which the PLY format itself cannot store: from a comment, else from the .prj
/// file of the same name next to it. One that cannot be parsed is logged and treated as absent.
/// @param comment  "EPSG:n", "EPSG:n+m" or WKT; empty when there is none
[[nodiscard]] std::optional<geo::Crs> find_crs(const std::filesystem::path& file,
                                               const std::string& comment);

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
