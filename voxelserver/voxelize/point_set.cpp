#include "voxelserver/voxelize/point_set.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::voxelize {
namespace {

double vertical_metres(const geo::Crs& crs, const std::optional<std::string>& unit) {
    if (unit) {
        if (*unit == "m") return 1;
        if (*unit == "ft") return 0.3048;
        if (*unit == "us-ft") return 1200.0 / 3937.0;
        throw UsageError("set the vertical unit: '" + *unit + "'; allowed: m, ft, us-ft");
    }
    // Without a vertical system, surveys in feet are in feet upwards too.
    return crs.vertical_metres_per_unit().value_or(crs.metres_per_unit());
}

struct Corners {
    std::vector<double> x, y;
};

Corners corners_of(const lidar::LasInfo& info) {
    return {{info.min[0], info.max[0], info.min[0], info.max[0]}, {info.min[1], info.min[1], info.max[1], info.max[1]}};
}

}  // namespace

PointSet::PointSet(const LidarWorldOptions& options, util::StageTimes& times)
    : m_times(times),
      m_classes(load_class_table(options.classes)),
      m_threads(thread::thread_count(options.threads)),
      m_squares(options.memory_bytes / 2),
      m_columns(options.memory_bytes / 4) {
    const util::StageTimes::Scope timed(times, "open files");
    if (options.files.empty()) throw UsageError("open the LiDAR data: no file or folder given");
    auto files = util::expand_folders(options.files, {".las", ".laz"}, "LiDAR data");
    std::sort(files.begin(), files.end());  // the voxels must not depend on the order of the arguments
    std::vector<lidar::LasInfo> infos(files.size());
    thread::parallel_for(files.size(), m_threads, [&](std::size_t i) { infos[i] = lidar::read_las_info(files[i]); });
    std::erase_if(infos, [](const lidar::LasInfo& info) {
        if (info.point_count == 0) spdlog::warn("{}: holds no points; left out", info.path.string());
        return info.point_count == 0;
    });
    if (infos.empty()) throw Error("open the LiDAR data: none of the " + std::to_string(files.size()) + " files holds a point");

    // Step 1: each file's CRS: what the person says, else the file, else the source's table.
    const auto fixed = options.crs ? std::optional(geo::Crs::from_text(*options.crs)) : std::nullopt;
    const auto fallback = m_classes.crs ? std::optional(geo::Crs::from_text(*m_classes.crs)) : std::nullopt;
    for (lidar::LasInfo& info : infos) {
        if (fixed) info.crs = fixed;
        if (!info.crs) info.crs = fallback;
        if (!info.crs)
            throw UsageError("place the point cloud " + info.path.string() + ": the file carries no coordinate reference system and class table '" + m_classes.id +
                             "' names none; give one with --crs EPSG:<code>");
        m_point_count += info.point_count;
    }

    // Step 2: one frame for all.
    const lidar::LasInfo& first = infos.front();
    const double mid_x = (first.min[0] + first.max[0]) / 2, mid_y = (first.min[1] + first.max[1]) / 2;
    const geo::Crs crs = voxel_crs_for(*first.crs, mid_x, mid_y);
    m_frame = std::make_unique<Frame>(crs, options.voxel_m, mid_x, mid_y);
    const auto horizontal = [&](const lidar::LasInfo& info) {
        Corners c = corners_of(info);
        if (!info.crs->same_horizontal(crs)) geo::Transform(*info.crs, crs).apply(c.x, c.y);
        return c;
    };
    bool have_base = false;
    for (lidar::LasInfo& info : infos) {
        const Corners c = horizontal(info);
        const auto [x0, x1] = std::minmax_element(c.x.begin(), c.x.end());
        const auto [y0, y1] = std::minmax_element(c.y.begin(), c.y.end());
        const double vx0 = std::floor(m_frame->x(*x0)), vx1 = std::floor(m_frame->x(*x1)) + 1;
        const double vz0 = std::floor(m_frame->z(*y1)), vz1 = std::floor(m_frame->z(*y0)) + 1;
        constexpr double kFarthest = 400'000;  // voxels from the base: what fixed point holds, with room for margins
        if (!have_base) {
            if (!(std::abs(vx0) < 1.0e9 && std::abs(vz0) < 1.0e9)) throw Error("place the point cloud " + info.path.string() + ": coordinates beyond 32-bit voxels");
            m_base = {static_cast<std::int32_t>(std::floor(vx0 / kPatchSize)) * kPatchSize, static_cast<std::int32_t>(std::floor(vz0 / kPatchSize)) * kPatchSize};
        }
        if (!(std::abs(vx0 - m_base.x) < kFarthest && std::abs(vx1 - m_base.x) < kFarthest && std::abs(vz0 - m_base.z) < kFarthest && std::abs(vz1 - m_base.z) < kFarthest))
            throw Error("place the point cloud " + info.path.string() + ": " + (have_base ? "too far from " + infos.front().path.string() : "too wide") +
                        "; allowed: within 400,000 voxels of " + std::to_string(options.voxel_m) + " m");
        const Bounds b{static_cast<std::int32_t>(vx0 - m_base.x), static_cast<std::int32_t>(vz0 - m_base.z), static_cast<std::int32_t>(vx1 - m_base.x),
                       static_cast<std::int32_t>(vz1 - m_base.z)};
        if (!have_base) m_bounds = b;
        m_bounds = {std::min(m_bounds.min_x, b.min_x), std::min(m_bounds.min_z, b.min_z), std::max(m_bounds.max_x, b.max_x), std::max(m_bounds.max_z, b.max_z)};
        have_base = true;
        const bool transform = !info.crs->same_horizontal(crs);
        const double vertical = vertical_metres(*info.crs, options.vertical_unit);
        m_sources.push_back({SquareSource{std::move(info), vertical, transform}, b});
    }
}

std::shared_ptr<const Square> PointSet::square(std::size_t index, int threads) {
    return m_squares.get(
        index,
        [&] {
            const util::StageTimes::Scope timed(m_times, "point load");
            return load_square(m_sources[index].source, *m_frame, m_base, m_classes, threads);
        },
        [](const auto& s) { return s->memory_bytes(); });
}

TerrainGrid PointSet::scan_terrain() {
    double area = 0;
    for (const Entry& e : m_sources) area += static_cast<double>(e.bounds.max_x - e.bounds.min_x) * (e.bounds.max_z - e.bounds.min_z);
    TerrainGrid grid(m_bounds.min_x, m_bounds.min_z, m_bounds.max_x, m_bounds.max_z, static_cast<double>(m_point_count) / std::max(area, 1.0),
                     m_frame->voxel_m());
    // Squares are decoded in parallel, a few at a time so that their points need not all be in memory, but added in order: sums
    // of floating-point numbers then do not depend on timing.
    const std::size_t batch = static_cast<std::size_t>(m_threads);
    for (std::size_t begin = 0; begin < m_sources.size(); begin += batch) {
        const std::size_t end = std::min(begin + batch, m_sources.size());
        std::vector<std::shared_ptr<const Square>> squares(end - begin);
        thread::parallel_for(end - begin, m_threads, [&](std::size_t i) { squares[i] = square(begin + i, m_threads); });
        const util::StageTimes::Scope timed(m_times, "terrain scan");
        for (std::size_t i = begin; i < end; ++i) {
            const Square& s = *squares[i - begin];
            grid.add_square(s, m_classes);
            m_wild_points += s.wild_points();
            if (s.wild_points() > 0) spdlog::warn("{}: {} points far outside the bounds in its header; left out", m_sources[i].source.info.path.string(), s.wild_points());
            const Bounds& b = m_sources[i].bounds;
            grid.cover(b.min_x, b.min_z, b.max_x, b.max_z);
        }
    }
    const util::StageTimes::Scope timed(m_times, "terrain scan");
    grid.finish();
    return grid;
}

Margined<char> PointSet::surveyed(std::int32_t x0, std::int32_t z0) const {
    constexpr int kMargin = Margined<char>::kMargin;
    Margined<char> out(0);
    for (const Entry& e : m_sources) {
        const int left = std::max(e.bounds.min_x - x0, -kMargin), right = std::min(e.bounds.max_x - x0, kPatchSize + kMargin);
        const int top = std::max(e.bounds.min_z - z0, -kMargin), bottom = std::min(e.bounds.max_z - z0, kPatchSize + kMargin);
        for (int z = top; z < bottom; ++z)
            for (int x = left; x < right; ++x) out.at(x, z) = 1;
    }
    return out;
}

std::shared_ptr<const PatchColumns> PointSet::columns(PatchKey key) {
    return m_columns.get(
        key,
        [&] {
            std::vector<std::shared_ptr<const Square>> held;
            std::vector<PatchPoints> points;
            const std::int32_t x0 = key.px * kPatchSize, z0 = key.pz * kPatchSize;
            // A margin of one voxel: a transformed or rounded point may lie just outside its file's bounds.
            constexpr std::int32_t kSlack = 1;
            for (std::size_t i = 0; i < m_sources.size(); ++i) {
                const Bounds& b = m_sources[i].bounds;
                if (b.min_x - kSlack >= x0 + kPatchSize || b.max_x + kSlack <= x0 || b.min_z - kSlack >= z0 + kPatchSize || b.max_z + kSlack <= z0) continue;
                held.push_back(square(i, 1));
                const auto inside = held.back()->points(key);
                if (!inside.empty()) points.push_back({inside, held.back()->colour_shift(), held.back()->has_colour()});
            }
            const util::StageTimes::Scope timed(m_times, "column init");
            return init_columns(points, m_classes);
        },
        [](const auto& p) { return p->memory_bytes(); });
}

}  // namespace terravox::voxelize
