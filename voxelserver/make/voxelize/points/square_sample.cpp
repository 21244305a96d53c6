#include "voxelserver/make/voxelize/points/square_sample.hpp"

#include <algorithm>
#include <cstdint>
#include <set>
#include <span>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/voxel/fingerprint.hpp"

namespace terravox::voxelize {
namespace {

void keep_wanted(std::vector<pointcloud::Point>& sample, const ClassTable& classes,
                 const Settings::Points& filters) {
    std::erase_if(sample, [&](const pointcloud::Point& p) {
        return to_filter_result(p, filters, classes) != FilterResult::kKept;
    });
}

std::vector<GroundEcho> echoes_from(const SquareSource& source,
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

std::uint16_t find_brightest(std::span<const pointcloud::Point> points) {
    std::uint16_t out = 0;
    for (const pointcloud::Point& p : points)
        for (const std::uint16_t c : p.rgb)
            out = std::max(out, c);
    return out;
}

void set_colours(SquareSource& source, std::uint16_t brightest) {
    source.has_colour = brightest > 0;
    source.colour_shift = brightest > 255 ? 8 : 0;
}

/// What points of a file tell of all of them.
struct PointFacts {
    std::vector<double> heights;  ///< of those that are kept; empty: not enough is known
    std::uint16_t brightest = 0;  ///< colour
};

/// Looks at the sample or, where that says too little and the file is small, at all points.
/// @param sample kept points, at least one
PointFacts look_at_points(const SquareSource& source, std::span<const pointcloud::Point> sample,
                          const KeepsPoint& keeps) {
    // The sample of a file with few chunks comes from a corner of it, and says nothing of the rest;
    // such files are mostly small, and then all points are read in tenths of a second.
    constexpr std::size_t kSpread = 24;  // of 64
    const bool is_spread = parts_met(source.info, sample) >= kSpread;
    if (!is_spread && source.info.point_count > kFewPoints)
        return {};
    PointFacts out;
    const auto add = [&](std::span<const pointcloud::Point> points) {
        out.brightest = std::max(out.brightest, find_brightest(points));
        for (const pointcloud::Point& p : points)
            if (keeps(p))
                out.heights.push_back(p.z);
    };
    if (is_spread) {
        add(sample);
        return out;
    }
    try {
        const pointcloud::PointRange all{0, source.info.point_count};
        source.points->read({&all, 1}, add);
    } catch (const util::Error&) {
        return {};  // whoever wants the square's voxels hears of the damage
    }
    // Without any that is kept, another file has taken its place.
    return out.heights.empty() ? PointFacts{} : out;
}

/// Sets the heights between which nearly all points lie.
/// @param heights at least one
void set_heights(SquareSample& out, std::vector<double>& heights) {
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

void look_over(const pointcloud::PointSource& points, const pointcloud::PointBatchSink& sink) {
    constexpr std::size_t kMostParts = 256;
    try {
        std::vector<pointcloud::PointRange> ranges{{0, points.info().point_count}};
        if (points.info().point_count > kFewPoints) {
            const std::vector<pointcloud::PointRange> parts = points.parts(1);
            const std::size_t used = std::min(kMostParts, parts.size());
            ranges.clear();
            for (std::size_t i = 0; i < used; ++i) {
                const pointcloud::PointRange& part = parts[i * parts.size() / used];
                ranges.push_back({part.begin, std::min(part.end, part.begin + kFewPoints / used)});
            }
        }
        points.read_without_echoes(ranges, sink);
    } catch (const util::Error&) {
        return;
    }
}

SquareSample take_sample(SquareSource& source, const ClassTable& classes,
                         const Settings::Points& filters, int threads) {
    const KeepsPoint keeps = [&](const pointcloud::Point& p) {
        return to_filter_result(p, filters, classes) == FilterResult::kKept;
    };
    std::vector<pointcloud::Point> sample = source.points->sample(kSampledPoints);
    SquareSample out;
    for (const pointcloud::Point& p : sample)
        out.water = out.water || classes.meaning[p.classification].role == Role::kWater;
    const std::uint16_t brightest = find_brightest(sample);
    set_colours(source, brightest);
    keep_wanted(sample, classes, filters);
    pointcloud::PointCloudInfo& info = source.info;
    out.islands = settle_extent(*source.points, info, sample, keeps, threads);
    out.low = info.min[2];
    out.high = info.max[2];
    if (sample.empty())
        return out;
    PointFacts facts = look_at_points(source, sample, keeps);
    if (!facts.heights.empty())
        set_heights(out, facts.heights);
    // Points without colours, or dark ones, may come first.
    set_colours(source, std::max(brightest, facts.brightest));
    out.echoes = echoes_from(source, sample, classes);
    out.has_echoes = !out.echoes.empty();
    return out;
}

std::vector<GroundEcho> sampled_echoes(const SquareSource& source, const ClassTable& classes,
                                       const Settings::Points& filters) {
    std::vector<pointcloud::Point> sample = source.points->sample(kSampledPoints);
    keep_wanted(sample, classes, filters);
    return echoes_from(source, sample, classes);
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

namespace {

using voxel::Fingerprint;

/// Brings the echoes of a file to voxels of the world.
void place_echoes(std::vector<GroundEcho>& echoes, const SquareSource& source,
                  const grid::Frame& frame) {
    std::vector<double> x;
    std::vector<double> y;
    for (const GroundEcho& e : echoes) {
        x.push_back(e.x);
        y.push_back(e.z);
    }
    if (source.transform && !echoes.empty())
        geo::Transform(*source.info.crs, frame.crs()).apply(x, y);
    for (std::size_t i = 0; i < echoes.size(); ++i) {
        echoes[i].x = frame.x(x[i]);
        echoes[i].z = frame.z(y[i]);
    }
}

/// Of each file what its echoes depend on.
std::vector<Fingerprint> fingerprints_of_echoes(const Sources& sources, int threads) {
    std::vector<Fingerprint> out(sources.files.size());
    const std::string frame = sources.frame.crs().wkt();
    thread::parallel_for(sources.files.size(), threads, [&](std::size_t i) {
        const SquareSource& file = sources.files[i];
        voxel::ByteWriter print;
        print.add(file.identity);
        print.add(file.side_identity);
        print.add(file.info.crs->wkt());
        for (const double v : {file.info.min[0], file.info.min[1], file.info.max[0],
                               file.info.max[1], sources.frame.voxel_m()})
            print.add(v);
        print.add(frame);
        out[i] = print.fingerprint();
    });
    return out;
}

}  // namespace

std::vector<Fingerprint> share_brightness(Sources& sources, std::vector<SquareSample>& samples,
                                          const std::vector<const KnownSquare*>& known,
                                          const ClassTable& classes,
                                          const Settings::Points& filters, int threads) {
    const std::size_t count = sources.files.size();
    std::vector<Fingerprint> scale_from(count);
    if (std::none_of(samples.begin(), samples.end(), [](const auto& s) { return s.has_echoes; }))
        return scale_from;
    std::vector<grid::ColumnRect> bounds;
    for (const SquareSource& file : sources.files)
        bounds.push_back(file.bounds);
    const std::vector<Fingerprint> echoes_from = fingerprints_of_echoes(sources, threads);
    std::vector<std::vector<std::size_t>> shares(count);
    thread::parallel_for(count, threads, [&](std::size_t i) {
        if (!samples[i].has_echoes)
            return;
        shares[i] = files_sharing_scale(i, bounds, sources.frame.voxel_m());
        voxel::ByteWriter print;
        for (const std::size_t k : shares[i])
            print.add(echoes_from[k]);
        scale_from[i] = print.fingerprint();
    });
    std::vector<std::size_t> missing;
    std::set<std::size_t> sampled;
    for (std::size_t i = 0; i < count; ++i) {
        if (!samples[i].has_echoes)
            continue;
        if (known[i] != nullptr && known[i]->scale_from == scale_from[i]) {
            sources.files[i].brightness = known[i]->brightness;
            continue;
        }
        missing.push_back(i);
        sampled.insert(shares[i].begin(), shares[i].end());
    }
    const std::vector<std::size_t> wanted(sampled.begin(), sampled.end());
    thread::parallel_for(wanted.size(), threads, [&](std::size_t n) {
        const SquareSource& file = sources.files[wanted[n]];
        SquareSample& sample = samples[wanted[n]];
        if (sample.has_echoes && sample.echoes.empty())
            sample.echoes = sampled_echoes(file, classes, filters);
        place_echoes(sample.echoes, file, sources.frame);
    });
    thread::parallel_for(missing.size(), threads, [&](std::size_t n) {
        std::vector<GroundEcho> near;
        for (const std::size_t k : shares[missing[n]])
            near.insert(near.end(), samples[k].echoes.begin(), samples[k].echoes.end());
        sources.files[missing[n]].brightness =
            voxelize::scale_from(std::move(near), sources.frame.voxel_m());
    });
    std::set<std::uint16_t> lines;
    for (const SquareSource& file : sources.files)
        for (const BrightnessScale::Line& line : file.brightness.lines())
            lines.insert(line.number);
    sources.flight_lines = lines.size();
    return scale_from;
}

}  // namespace terravox::voxelize
