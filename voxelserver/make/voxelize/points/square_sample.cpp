#include "voxelserver/make/voxelize/points/square_sample.hpp"

#include <algorithm>
#include <cstdint>
#include <span>

#include "common/util/error.hpp"

namespace terravox::voxelize {
namespace {

void keep_wanted(std::vector<pointcloud::Point>& sample, const ClassTable& classes,
                 const Settings::Points& filters) {
    std::erase_if(sample, [&](const pointcloud::Point& p) {
        return filter_result_of(p, filters, classes) != FilterResult::kKept;
    });
}

std::vector<GroundEcho> echoes_of(const SquareSource& source,
                                  const std::vector<pointcloud::Point>& kept,
                                  const ClassTable& classes) {
    std::vector<GroundEcho> out;
    if (source.has_colour)
        return out;
    const pointcloud::PointCloudInfo& info = source.info;
    // Points outside of the extent may lie where the CRS is not defined.
    const auto is_inside = [&](const pointcloud::Point& p) {
        return p.x >= info.min[0] && p.x <= info.max[0] && p.y >= info.min[1] && p.y <= info.max[1];
    };
    for (const pointcloud::Point& p : kept)
        if (p.return_count == 1 && p.intensity > 0 && is_inside(p) &&
            classes.meaning[p.classification].role == Role::kGround)
            out.push_back({p.x, p.y, p.intensity, p.line});
    return out;
}

// Sets the heights that nearly all points keep, where enough points are known.
// @param sample kept points, at least one
void set_heights(SquareSample& out, const SquareSource& source,
                 std::span<const pointcloud::Point> sample, const KeepsPoint& keeps) {
    // The sample of a file with few chunks comes from a corner of it, and says nothing of the rest;
    // such files are mostly small, and then all points are read in tenths of a second.
    constexpr std::size_t kSpread = 24;  // of 64
    constexpr std::uint64_t kFewPoints = 250'000;
    const bool is_spread = parts_met(source.info, sample) >= kSpread;
    if (!is_spread && source.info.point_count > kFewPoints)
        return;
    std::vector<double> heights;
    const auto add = [&](std::span<const pointcloud::Point> points) {
        for (const pointcloud::Point& p : points)
            if (keeps(p))
                heights.push_back(p.z);
    };
    const pointcloud::PointRange all{0, source.info.point_count};
    try {
        if (is_spread)
            add(sample);
        else
            source.points->read({&all, 1}, add);
    } catch (const util::Error&) {
        return;  // whoever wants the square's voxels hears of the damage
    }
    if (heights.empty())
        return;  // another file has taken its place
    const std::size_t beyond = heights.size() / 50;
    const auto at = [&](std::size_t i) {
        const auto place = heights.begin() + static_cast<std::ptrdiff_t>(i);
        std::nth_element(heights.begin(), place, heights.end());
        return *place;
    };
    out.low = at(beyond);
    out.high = at(heights.size() - 1 - beyond);
}

}  // namespace

SquareSample take_sample(SquareSource& source, const ClassTable& classes,
                         const Settings::Points& filters, int threads) {
    const KeepsPoint keeps = [&](const pointcloud::Point& p) {
        return filter_result_of(p, filters, classes) == FilterResult::kKept;
    };
    std::vector<pointcloud::Point> sample = source.points->sample(kSampledPoints);
    SquareSample out;
    std::uint16_t brightest = 0;
    for (const pointcloud::Point& p : sample) {
        for (const std::uint16_t c : p.rgb)
            brightest = std::max(brightest, c);
        out.water = out.water || classes.meaning[p.classification].role == Role::kWater;
    }
    source.has_colour = brightest > 0;
    source.colour_shift = brightest > 255 ? 8 : 0;
    keep_wanted(sample, classes, filters);
    pointcloud::PointCloudInfo& info = source.info;
    out.islands = settle_extent(*source.points, info, sample, keeps, threads);
    out.low = info.min[2];
    out.high = info.max[2];
    if (sample.empty())
        return out;
    out.echoes = echoes_of(source, sample, classes);
    out.has_echoes = !out.echoes.empty();
    set_heights(out, source, sample, keeps);
    return out;
}

std::vector<GroundEcho> sampled_echoes(const SquareSource& source, const ClassTable& classes,
                                       const Settings::Points& filters) {
    std::vector<pointcloud::Point> sample = source.points->sample(kSampledPoints);
    keep_wanted(sample, classes, filters);
    return echoes_of(source, sample, classes);
}

SquareSample known_sample(SquareSource& source, const KnownSquare& known) {
    source.has_colour = known.has_colour;
    source.colour_shift = known.colour_shift;
    source.info.min = known.min;
    source.info.max = known.max;
    SquareSample out;
    out.has_echoes = known.has_echoes;
    out.low = known.low;
    out.high = known.high;
    out.water = known.has_water;
    out.islands = known.islands;
    return out;
}

}  // namespace terravox::voxelize
