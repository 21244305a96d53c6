#include "voxelserver/make/voxelize/points/placer.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/stage_times.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/make/voxelize/points/extent.hpp"

namespace terravox::voxelize {
namespace {

constexpr std::int64_t kPlanOne = 1 << store::VoxelPoint::kPlanBits;
constexpr int kPatchShift = store::VoxelPoint::kPlanBits + 6;

// floor() without a library call: this runs for every return three times.
std::int64_t floor_to_int(double v) noexcept {
    const auto cut = static_cast<std::int64_t>(v);
    return cut - (static_cast<double>(cut) > v ? 1 : 0);
}

// A limit as a coordinate of the file's grid. Limits often lie on that grid, and whether a point on
// them is kept must not depend on the last bit of a sum.
template <class Round>
double on_grid(const pointcloud::PointCloudInfo& info, std::size_t axis, double limit,
               const Round& round) {
    const double scale = info.scale[axis];
    if (scale == 0)
        return limit;
    return round((limit - info.offset[axis]) / scale) * scale + info.offset[axis];
}

void add(voxel::ByteWriter& out, const grid::ColumnRect& r) {
    for (const std::int32_t v : {r.min_x, r.min_z, r.max_x, r.max_z})
        out.add(v);
}

}  // namespace

voxel::Fingerprint to_fingerprint(const SquareSource& source) {
    voxel::ByteWriter out;
    out.add(source.identity);
    out.add(source.info.crs->wkt());
    out.add(source.vertical_metres);
    add(out, source.bounds);
    for (const grid::ColumnRect& island : source.islands)
        add(out, island);
    out.add(source.lowest);
    out.add(source.highest);
    out.add(source.has_colour);
    out.add(source.colour_shift);
    for (const BrightnessScale::Line& line : source.brightness.lines()) {
        out.add(line.number);
        out.add(line.bright_ground);
    }
    return out.fingerprint();
}

Placer::Placer(const SquareSource& source, const grid::Frame& frame, const ClassTable& classes,
               const Settings::Points& filters)
    : m_source(source), m_frame(frame), m_classes(classes), m_filters(filters) {
    if (source.transform)
        m_transform.emplace(*source.info.crs, frame.crs());
    // The bounds hold all kept points (extent.hpp); points beyond their rounding are errors of the
    // survey.
    const pointcloud::PointCloudInfo& info = source.info;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double slack = find_rounding(info, axis);
        const double low = axis == 2 ? source.lowest : info.min[axis] - slack;
        const double high = axis == 2 ? source.highest : info.max[axis] + slack;
        m_min[axis] = on_grid(info, axis, low, [](double v) { return std::ceil(v); });
        m_max[axis] = on_grid(info, axis, high, [](double v) { return std::floor(v); });
    }
}

void Placer::place(std::span<const pointcloud::Point> batch,
                   const std::optional<grid::PatchRect>& wanted, store::PatchedPoints& out,
                   store::PointCounts& counts) {
    const util::Stopwatch transforming;
    transform(batch, counts);
    m_transformation_s += transforming.seconds();
    const util::Stopwatch quantizing;
    quantize(batch, wanted, out, counts);
    m_quantization_s += quantizing.seconds();
}

void Placer::transform(std::span<const pointcloud::Point> batch, store::PointCounts& counts) {
    m_kept.clear();
    m_x.clear();
    m_y.clear();
    for (std::uint32_t i = 0; i < batch.size(); ++i) {
        const pointcloud::Point& p = batch[i];
        if (const FilterResult result = to_filter_result(p, m_filters, m_classes);
            result != FilterResult::kKept) {
            ++(result == FilterResult::kNoise ? counts.noise : counts.withheld);
            continue;
        }
        if (p.x < m_min[0] || p.x > m_max[0] || p.y < m_min[1] || p.y > m_max[1] ||
            p.z < m_min[2] || p.z > m_max[2]) {
            ++counts.outliers;
            continue;
        }
        m_kept.push_back(i);
        m_x.push_back(p.x);
        m_y.push_back(p.y);
    }
    if (m_transform && !m_kept.empty())
        m_transform->apply(m_x, m_y);
}

void Placer::quantize(std::span<const pointcloud::Point> batch,
                      const std::optional<grid::PatchRect>& wanted, store::PatchedPoints& out,
                      store::PointCounts& counts) {
    for (std::size_t k = 0; k < m_kept.size(); ++k) {
        const pointcloud::Point& p = batch[m_kept[k]];
        const double x = m_frame.x(m_x[k]) * static_cast<double>(kPlanOne);
        const double z = m_frame.z(m_y[k]) * static_cast<double>(kPlanOne);
        const double y =
            m_frame.y(p.z * m_source.vertical_metres) * (1 << store::VoxelPoint::kHeightBits);
        constexpr double kFarthest = 1.0e9 * static_cast<double>(kPlanOne);  // voxels are 32-bit
        if (!(std::abs(x) < kFarthest && std::abs(z) < kFarthest && std::abs(y) < 2147483000.0)) {
            ++counts.outliers;
            continue;
        }
        const std::int64_t ix = floor_to_int(x);
        const std::int64_t iz = floor_to_int(z);
        // Strays between two distant parts of a file: the box of both holds them.
        const auto column = [](std::int64_t v) {
            return static_cast<std::int32_t>(v >> store::VoxelPoint::kPlanBits);
        };
        if (m_source.islands.size() > 1 && !m_source.on_island(column(ix), column(iz))) {
            ++counts.outliers;
            continue;
        }
        const grid::PatchKey patch{static_cast<std::int32_t>(ix >> kPatchShift),
                                   static_cast<std::int32_t>(iz >> kPatchShift)};
        if (wanted && !wanted->contains(patch))
            continue;
        store::VoxelPoint point;
        point.x = static_cast<std::uint16_t>(ix);
        point.z = static_cast<std::uint16_t>(iz);
        point.y = static_cast<std::int32_t>(floor_to_int(y));
        point.source_class = p.classification;
        if (m_source.has_colour) {
            const auto channel = [&](std::size_t c) {
                return static_cast<std::uint8_t>(std::min(p.rgb[c] >> m_source.colour_shift, 255));
            };
            point.colour = {channel(0), channel(1), channel(2)};
        } else if (p.return_count == 1) {
            // An echo that is one of several holds only a part of its pulse's light.
            point.colour = {m_source.brightness.brightness(p.intensity, p.line), 0, 0};
        }
        ++counts.kept, ++counts.by_class[p.classification];
        out.add(patch, point);
    }
}

}  // namespace terravox::voxelize
