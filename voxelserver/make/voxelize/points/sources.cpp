#include "voxelserver/make/voxelize/points/sources.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/log.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/data/pointcloud/formats/open.hpp"
#include "voxelserver/make/voxelize/points/class_choice.hpp"
#include "voxelserver/make/voxelize/points/extent.hpp"
#include "voxelserver/make/voxelize/points/file_crs.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/square_sample.hpp"

namespace terravox::voxelize {
namespace {

double vertical_metres(const geo::Crs& crs, const std::optional<std::string>& unit) {
    if (unit) {
        if (*unit == "m")
            return 1;
        if (*unit == "ft")
            return 0.3048;
        if (*unit == "us-ft")
            return 1200.0 / 3937.0;
        throw util::UsageError("set the vertical unit: '{}'; allowed: m, ft, us-ft", *unit);
    }
    // Without a vertical system, surveys in feet use feet for heights as well.
    return crs.vertical_metres_per_unit().value_or(crs.metres_per_unit());
}

void open_file(SquareSource& file, const std::filesystem::path& path, const KnownSquares& known) {
    file.identity = voxel::file_identity(path, "point cloud");
    if (const auto side_file = pointcloud::find_side_file(path))
        file.side_identity = voxel::file_identity(*side_file, "side file");
    if (const KnownSquare* const found = known.find(file.identity, file.side_identity)) {
        file.info = found->stated;
        file.info.path = path;
        file.points = std::make_shared<const pointcloud::DeferredSource>(file.info);
        return;
    }
    file.points = pointcloud::open_point_source(path);
    file.info = file.points->info();
}

std::vector<SquareSource> open_files(const LidarWorldOptions& options, const KnownSquares& known) {
    const auto paths = lidar_files(options);
    std::vector<SquareSource> files(paths.size());
    thread::parallel_for(paths.size(), options.threads,
                         [&](std::size_t i) { open_file(files[i], paths[i], known); });
    std::erase_if(files, [](const SquareSource& file) {
        if (file.info.point_count == 0)
            util::warn_of_file(file.info.path.string(), "holds no points; left out");
        return file.info.point_count == 0;
    });
    if (files.empty())
        throw util::Error("open the LiDAR data: none of the {} files holds a point", paths.size());
    return files;
}

// What cannot be read is not known: opening takes longer then, and gives the same.
KnownSquares read_known(const LidarWorldOptions& options, const voxel::Fingerprint& way) {
    if (options.known_squares.empty())
        return {};
    // Some hundred bytes a square.
    constexpr std::size_t kMaxBytes = std::size_t{256} << 20;
    std::error_code failed;
    if (!std::filesystem::is_regular_file(options.known_squares, failed))
        return {};
    try {
        return KnownSquares::from_bytes(
            util::read_text(options.known_squares, kMaxBytes, "read what is known of squares"),
            way);
    } catch (const util::Error& e) {
        util::log_info("{}: {}; all files are read", options.known_squares.string(), e.what());
        return {};
    }
}

// Of each file what is known of it, unless another CRS applies now.
std::vector<const KnownSquare*> trusted_squares(const std::vector<SquareSource>& files,
                                                const KnownSquares& known) {
    std::vector<const KnownSquare*> out(files.size(), nullptr);
    // Writing a CRS takes longer than all else, and thousands of files have the same one.
    std::map<const OGRSpatialReference*, std::string> texts;
    for (std::size_t i = 0; i < files.size() && !known.empty(); ++i) {
        const KnownSquare* const found = known.find(files[i].identity, files[i].side_identity);
        if (found == nullptr)
            continue;
        const geo::Crs& crs = *files[i].info.crs;
        const auto [text, is_new] = texts.try_emplace(&crs.ogr());
        if (is_new)
            text->second = crs.wkt();
        if (text->second == found->crs_wkt)
            out[i] = found;
    }
    return out;
}

std::vector<pointcloud::PointCloudInfo> list_infos(const std::vector<SquareSource>& files) {
    std::vector<pointcloud::PointCloudInfo> out;
    for (const SquareSource& file : files)
        out.push_back(file.info);
    return out;
}

// The columns that a rectangle of a file's coordinates covers.
grid::ColumnRect columns_over(const PlanRect& rect, const SquareSource& source,
                              const grid::Frame& frame) {
    std::array<double, 4> edges{rect.min_x, rect.min_y, rect.max_x, rect.max_y};
    if (source.transform)
        edges = geo::Transform(*source.info.crs, frame.crs()).around(edges);
    const double west = std::floor(frame.x(edges[0]));
    const double east = std::floor(frame.x(edges[2])) + 1;
    const double north = std::floor(frame.z(edges[3]));
    const double south = std::floor(frame.z(edges[1])) + 1;
    constexpr double kFarthest = 1.0e9;
    if (!(std::abs(west) < kFarthest && std::abs(east) < kFarthest && std::abs(north) < kFarthest &&
          std::abs(south) < kFarthest))
        throw util::Error("place the point cloud {}: coordinates beyond 32-bit voxels of {:f} m",
                          source.info.path.string(), frame.voxel_m());
    return {static_cast<std::int32_t>(west), static_cast<std::int32_t>(north),
            static_cast<std::int32_t>(east), static_cast<std::int32_t>(south)};
}

grid::ColumnRect around(const grid::ColumnRect& a, const grid::ColumnRect& b) noexcept {
    return {std::min(a.min_x, b.min_x), std::min(a.min_z, b.min_z), std::max(a.max_x, b.max_x),
            std::max(a.max_z, b.max_z)};
}

// A ray visits the boxes between two places one by one, and there would be millions: an error is
// better than the wait.
void check_apart(const Sources& sources) {
    constexpr double kFarthest_m = 100'000;
    struct Stretch {
        std::int64_t begin;
        std::int64_t end;
        const std::filesystem::path* path;
    };
    for (const bool along_x : {true, false}) {
        std::vector<Stretch> stretches;
        for (const SquareSource& s : sources.files)
            for (const grid::ColumnRect& r : s.islands)
                stretches.push_back(along_x ? Stretch{r.min_x, r.max_x, &s.info.path}
                                            : Stretch{r.min_z, r.max_z, &s.info.path});
        std::stable_sort(stretches.begin(), stretches.end(),
                         [](const Stretch& a, const Stretch& b) { return a.begin < b.begin; });
        Stretch farthest = stretches.front();
        for (const Stretch& s : stretches) {
            const double apart_m =
                static_cast<double>(s.begin - farthest.end) * sources.frame.voxel_m();
            if (apart_m > kFarthest_m)
                throw util::UsageError(
                    "put the LiDAR data into one world: {} and {} lie {:.0f} km apart with nothing "
                    "between; allowed: up to {:.0f} km",
                    farthest.path->string(), s.path->string(), apart_m / 1000, kFarthest_m / 1000);
            if (s.end > farthest.end)
                farthest = s;
        }
    }
}

// An index that was left behind by an older state of a file, or copied by a program that knows
// nothing of it, hides no points: they are read without it.
std::shared_ptr<const pointcloud::SpatialIndex> usable_index(
    const pointcloud::PointSource& points) {
    try {
        return points.spatial_index();
    } catch (const util::Error& e) {
        util::warn_of_file(points.info().path.string(),
                           "its index is not used, since it does not fit the points", e.what());
    }
    return nullptr;
}

// Places one file in the frame: its columns, and the heights outside of which its points are
// outliers.
void place(SquareSource& source, const SquareSample& sample, const grid::Frame& frame,
           const std::optional<std::string>& vertical_unit, const KnownSquare* known) {
    source.transform = !source.info.crs->same_horizontal(frame.crs());
    source.vertical_metres = vertical_metres(*source.info.crs, vertical_unit);
    for (const PlanRect& island : sample.islands)
        source.islands.push_back(columns_over(island, source, frame));
    source.bounds = source.islands.front();
    for (const grid::ColumnRect& island : source.islands)
        source.bounds = around(source.bounds, island);
    // Mountains rise a kilometre within a square; a point farther from nearly all others is not
    // part of it.
    constexpr double kOutlier_m = 1000;
    const double outlier = kOutlier_m / source.vertical_metres;
    const double rounding = find_rounding(source.info, 2);
    source.lowest = std::max(source.info.min[2] - rounding, sample.low - outlier);
    source.highest = std::min(source.info.max[2] + rounding, sample.high + outlier);
    if (!source.transform && (known == nullptr || known->has_index))
        source.spatial_index = usable_index(*source.points);
}

KnownSquare known_square(const SquareSource& file, const SquareSample& sample,
                         const voxel::Fingerprint& scale_from) {
    KnownSquare out;
    out.identity = file.identity;
    out.side_identity = file.side_identity;
    out.stated = file.points->info();
    out.crs_wkt = file.info.crs->wkt();
    out.min = file.info.min;
    out.max = file.info.max;
    out.islands = sample.islands;
    out.low = sample.low;
    out.high = sample.high;
    out.has_water = sample.water;
    out.has_colour = file.has_colour;
    out.colour_shift = file.colour_shift;
    // Where no index could be used, it was not looked for.
    out.has_index = file.transform || file.spatial_index != nullptr;
    out.has_echoes = sample.has_echoes;
    out.scale_from = scale_from;
    out.brightness = file.brightness;
    out.bounds = file.bounds;
    return out;
}

/// Heights of all files together, in voxels.
struct AllHeights {
    double lowest = INFINITY;
    double highest = -INFINITY;
    double floor = INFINITY;  ///< below nearly all points
    double typical_lowest = INFINITY;
    double typical_highest = -INFINITY;
};

AllHeights collect_heights(const Sources& sources, const std::vector<SquareSample>& samples) {
    AllHeights out;
    for (std::size_t i = 0; i < sources.files.size(); ++i) {
        const SquareSource& s = sources.files[i];
        const auto voxels = [&](double height) {
            return sources.frame.y(height * s.vertical_metres);
        };
        // Single low returns (unclassified noise) must not lower the base of the model.
        constexpr double kBelowMost_m = 50;
        const double floor = std::max(s.lowest, samples[i].low - kBelowMost_m / s.vertical_metres);
        out.lowest = std::min(out.lowest, voxels(s.lowest));
        out.highest = std::max(out.highest, voxels(s.highest));
        out.floor = std::min(out.floor, voxels(floor));
        // Towers and gorges are few points of their square, too, and the steeper the land, the
        // farther they reach.
        constexpr double kBeyondMost_m = 30;
        const double beyond =
            std::max(kBeyondMost_m / s.vertical_metres, (samples[i].high - samples[i].low) / 4);
        out.typical_lowest = std::min(out.typical_lowest, voxels(samples[i].low - beyond));
        out.typical_highest = std::max(out.typical_highest, voxels(samples[i].high + beyond));
    }
    return out;
}

// Sets the members that sum up all files, except for the heights.
void sum_up(Sources& sources, const std::vector<SquareSample>& samples) {
    double area = 0;
    for (std::size_t i = 0; i < sources.files.size(); ++i) {
        const SquareSource& s = sources.files[i];
        sources.bounds = i == 0 ? s.bounds : around(sources.bounds, s.bounds);
        for (const grid::ColumnRect& r : s.islands)
            area += static_cast<double>(r.max_x - r.min_x) * static_cast<double>(r.max_z - r.min_z);
        sources.has_water_class = sources.has_water_class || samples[i].water;
        sources.point_count += s.info.point_count;
    }
    sources.density = static_cast<double>(sources.point_count) / std::max(area, 1.0);
}

void set_heights(Sources& sources, const AllHeights& range, double ground_depth_m) {
    constexpr double kMaxY = 500'000;  // fixed point holds 524,287
    if (!(range.lowest > -kMaxY && range.highest < kMaxY))
        throw util::Error(
            "place the LiDAR data: heights from {:f} to {:f} voxels; allowed: -500,000 to 500,000",
            range.lowest, range.highest);
    sources.floor_y = static_cast<std::int32_t>(
        std::floor(range.floor - ground_depth_m / sources.frame.voxel_m()));
    sources.lowest_y =
        std::min(static_cast<std::int32_t>(std::floor(range.lowest)), sources.floor_y);
    sources.highest_y = static_cast<std::int32_t>(std::floor(range.highest)) + 1;
    const auto within = [&](double y) {
        return static_cast<std::int32_t>(
            std::clamp<double>(y, sources.lowest_y, sources.highest_y));
    };
    // The land is solid down to its floor.
    const voxel::HeightRange typical{
        within(std::min<double>(std::floor(range.typical_lowest), sources.floor_y)),
        within(std::floor(range.typical_highest) + 1)};
    if (typical != voxel::HeightRange{sources.lowest_y, sources.highest_y})
        sources.typical_heights = typical;
}

geo::LatLon find_centre(const Sources& sources) {
    const grid::ColumnRect& b = sources.bounds;
    return geo::to_lat_lon(sources.frame.crs(), sources.frame.easting((b.min_x + b.max_x) / 2.0),
                           sources.frame.northing((b.min_z + b.max_z) / 2.0));
}

}  // namespace

Sources open_sources(const LidarWorldOptions& options, const Settings& settings) {
    if (options.classes != kAnyClassTable)
        (void)load_class_table(options.classes);  // refused before any file is read
    KnownSquares known = read_known(options, way_of_opening(settings.points));
    auto files = open_files(options, known);
    use_recorded_crs(files, options);
    const auto squares = list_squares(files, options);
    settle_crs(files, options, squares);
    const ClassTable classes = choose_class_table(options, files, squares);
    if (known.roles != fingerprint_of_roles(classes))
        known = {};
    warn_of_mixed_datums(list_infos(files));
    const std::vector<const KnownSquare*> trusted = trusted_squares(files, known);
    std::vector<SquareSample> samples(files.size());
    thread::parallel_for(files.size(), options.threads, [&](std::size_t i) {
        samples[i] = trusted[i] != nullptr
                         ? known_sample(files[i], *trusted[i])
                         : take_sample(files[i], classes, settings.points, options.threads);
    });
    const pointcloud::PointCloudInfo& first = files.front().info;
    const double mid_x = (first.min[0] + first.max[0]) / 2;
    const double mid_y = (first.min[1] + first.max[1]) / 2;
    Sources out{
        grid::Frame(grid::voxel_crs_for(*first.crs, mid_x, mid_y), options.voxel_m, mid_x, mid_y),
        std::move(files), classes};
    for (const auto& square : squares)
        if (square)
            out.named_squares.push_back(*square);
    thread::parallel_for(out.files.size(), options.threads, [&](std::size_t i) {
        place(out.files[i], samples[i], out.frame, options.vertical_unit, trusted[i]);
    });
    std::vector<voxel::Fingerprint> scale_from(out.files.size());
    if (settings.steps.material_guesses)
        scale_from =
            share_brightness(out, samples, trusted, classes, settings.points, options.threads);
    sum_up(out, samples);
    check_apart(out);
    if (settings.steps.colour_variation)
        out.tints = choose_tints(settings.tints, find_centre(out));
    set_heights(out, collect_heights(out, samples), settings.ground.depth_m);
    for (std::size_t i = 0; i < out.files.size(); ++i)
        out.known.add(known_square(out.files[i], samples[i], scale_from[i]));
    out.known.roles = fingerprint_of_roles(classes);
    out.known_before = std::move(known);
    return out;
}

}  // namespace terravox::voxelize
