#include "voxelserver/data/lidar/las_source.hpp"

#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"

namespace terravox::lidar {
namespace {

// Into its place: a copy of what has just been written in parts waits for all of it.
void convert(const RawPoint& raw, const LasInfo& las, pointcloud::Point& out) noexcept {
    out.x = raw.x * las.scale[0] + las.offset[0];
    out.y = raw.y * las.scale[1] + las.offset[1];
    out.z = raw.z * las.scale[2] + las.offset[2];
    out.classification = raw.classification;
    out.return_number = raw.return_number;
    out.return_count = raw.return_count;
    out.withheld = raw.withheld;
    out.overlap = raw.overlap;
    out.intensity = raw.intensity;
    out.line = raw.point_source;
    out.rgb = raw.rgb;
}

}  // namespace

LasSource::LasSource(const std::filesystem::path& path) : LasSource(read_las_info(path)) {}

LasSource::LasSource(LasInfo las) : PointSource(las), m_las(std::move(las)) {}

std::vector<PointRange> LasSource::parts(std::uint64_t points) const {
    return split_by_chunk(m_las, points);
}

void LasSource::read(std::span<const PointRange> ranges,
                     const pointcloud::PointBatchSink& sink) const {
    read(ranges, sink, Echoes::kRead);
}

void LasSource::read_without_echoes(std::span<const PointRange> ranges,
                                    const pointcloud::PointBatchSink& sink) const {
    read(ranges, sink, Echoes::kSkip);
}

void LasSource::read(std::span<const PointRange> ranges, const pointcloud::PointBatchSink& sink,
                     Echoes echoes) const {
    std::vector<pointcloud::Point> points;
    const RawBatchSink convert_all = [&](std::span<const RawPoint> batch) {
        points.resize(batch.size());
        for (std::size_t i = 0; i < batch.size(); ++i)
            convert(batch[i], m_las, points[i]);
        sink(points);
    };
    read_point_batches(m_las, ranges, convert_all, echoes);
}

std::vector<pointcloud::Point> LasSource::sample(std::size_t about) const {
    std::vector<pointcloud::Point> out;
    for (const RawPoint& raw : sample_points(m_las, about))
        convert(raw, m_las, out.emplace_back());
    return out;
}

// The sample of a file with chunks of many sizes (COPC) may come from a single node, whose points
// some writers sort by position.
bool LasSource::sampled_all_over() const {
    constexpr std::uint64_t kWellSampled = 64 * 50'000;  // enough chunks
    if (!m_las.seekable || m_las.point_count < kWellSampled)
        return false;
    if (!m_las.chunks)
        return true;
    const auto& starts = m_las.chunks->first_point;
    for (std::size_t i = 2; i + 1 < starts.size(); ++i) {
        if (starts[i] - starts[i - 1] != starts[1])
            return false;
    }
    return true;
}

std::shared_ptr<const pointcloud::SpatialIndex> LasSource::spatial_index() const {
    return read_spatial_index(m_las);
}

std::unique_ptr<const pointcloud::PointSource> LasFormat::open(const std::filesystem::path& path) {
    return std::make_unique<const LasSource>(path);
}

}  // namespace terravox::lidar
