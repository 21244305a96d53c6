#include "voxelserver/data/ply/ply_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/data/ply/ply_file.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::ply {

std::optional<geo::Crs> find_crs(const std::filesystem::path& file, const std::string& comment) {
    try {
        return comment.empty() ? geo::Crs::from_side_file(file) : geo::Crs::from_file_text(comment);
    } catch (const geo::ProjUnusableError&) {
        throw;
    } catch (const util::Error& e) {
        util::log_info("{}: {}; --crs sets one", file.string(), e.what());
        return std::nullopt;
    }
}

namespace {

using pointcloud::FileBytes;
using pointcloud::Point;
using pointcloud::PointCloudInfo;
using pointcloud::PointRange;

constexpr std::uint64_t kPartPoints = 50'000;
constexpr std::uint64_t kBatchPoints = 1024;

void widen(PointCloudInfo& info, const Point& point, bool first) {
    const std::array<double, 3> at{point.x, point.y, point.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        info.min[axis] = first ? at[axis] : std::min(info.min[axis], at[axis]);
        info.max[axis] = first ? at[axis] : std::max(info.max[axis], at[axis]);
    }
}

// Coordinates of a national grid have seven digits before the decimal point, and a 32-bit float has
// seven significant digits.
void warn_of_coarse_floats(const PointCloudInfo& info, const Header& header) {
    constexpr float kFine = 0.02F;  // in units of the CRS: two centimetres of a metric system
    const std::array<Field, 2> axes{kX, kY};
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        const Property& property = header.properties[*header.fields[axes[axis]]];
        const double farthest = std::max(std::abs(info.min[axis]), std::abs(info.max[axis]));
        const auto value = static_cast<float>(farthest);
        const float step = std::nextafter(value, std::numeric_limits<float>::infinity()) - value;
        if (property.type != Scalar::kFloat32 || !(step > kFine))
            continue;
        util::warn_of_file(
            info.path.string(),
            "32-bit floats are too coarse for its coordinates: points form rows unless the file is "
            "written with double",
            fmt::format("values of {} lie {:.3g} apart near {:.0f}", property.name, step,
                        farthest));
        return;
    }
}

}  // namespace

PlySource::Contents PlySource::scan(const std::filesystem::path& path) {
    Contents out;
    const FileBytes file(path);
    out.header = read_header(file);
    PointCloudInfo& info = out.info;
    info.path = path;
    info.file_bytes = file.size();
    info.point_count = out.header.vertex_count;
    info.measured_bounds = true;
    const auto vertices = open_vertices(file, out.header);
    Point point;
    for (std::uint64_t i = 0; i < info.point_count; ++i) {
        if (i % kPartPoints == 0)
            out.part_at.push_back(vertices->at_byte());
        vertices->next(point);
        widen(info, point, i == 0);
    }
    info.crs = find_crs(path, out.header.crs);
    warn_of_coarse_floats(info, out.header);
    return out;
}

PlySource::PlySource(const std::filesystem::path& path) : PlySource(scan(path)) {}

PlySource::PlySource(Contents contents)
    : PointSource(std::move(contents.info)),
      m_header(std::move(contents.header)),
      m_part_at(std::move(contents.part_at)) {}

std::vector<PointRange> PlySource::parts(std::uint64_t points) const {
    const std::uint64_t step = std::max<std::uint64_t>(1, points / kPartPoints) * kPartPoints;
    std::vector<PointRange> out;
    for (std::uint64_t begin = 0; begin < info().point_count; begin += step)
        out.push_back({begin, std::min(begin + step, info().point_count)});
    return out;
}

void PlySource::read(std::span<const PointRange> ranges,
                     const pointcloud::PointBatchSink& sink) const {
    const FileBytes file(info().path);
    const auto vertices = open_vertices(file, m_header);
    std::vector<Point> batch;
    for (const PointRange& range : ranges) {
        if (range.end > info().point_count)
            file.fail("points " + std::to_string(range.begin) + " to " + std::to_string(range.end) +
                      "; it has " + std::to_string(info().point_count));
        if (range.begin >= range.end)
            continue;
        const std::uint64_t part = range.begin / kPartPoints;
        vertices->seek(m_part_at[static_cast<std::size_t>(part)], part * kPartPoints, range.begin);
        for (std::uint64_t at = range.begin; at < range.end; at += batch.size()) {
            batch.resize(static_cast<std::size_t>(std::min(kBatchPoints, range.end - at)));
            for (Point& point : batch)
                vertices->next(point);
            sink(batch);
        }
    }
}

std::vector<Point> PlySource::sample(std::size_t about) const {
    constexpr std::uint64_t kMaxStretches = 64;
    const std::uint64_t count = info().point_count;
    const std::uint64_t stretches = std::min({kMaxStretches, std::uint64_t{about}, count});
    std::vector<PointRange> ranges;
    for (std::uint64_t i = 0; i < stretches; ++i) {
        const std::uint64_t begin = i * count / stretches;
        const std::uint64_t end = (i + 1) * count / stretches;
        ranges.push_back({begin, std::min(end, begin + (about + stretches - 1) / stretches)});
    }
    std::vector<Point> out;
    read(ranges,
         [&](std::span<const Point> batch) { out.insert(out.end(), batch.begin(), batch.end()); });
    return out;
}

bool PlySource::sampled_all_over() const {
    constexpr std::uint64_t kWellSampled = 64 * kPartPoints;
    return info().point_count >= kWellSampled;
}

std::unique_ptr<const pointcloud::PointSource> PlyFormat::open(const std::filesystem::path& path) {
    return std::make_unique<const PlySource>(path);
}

}  // namespace terravox::ply
