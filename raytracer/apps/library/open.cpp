#include <terravox/error.hpp>
#include <terravox/world.hpp>

#include <cmath>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/source_world.hpp"
#include "raytracer/apps/library/state.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox {
namespace {

worlds::WorldOptions world_options(const scene::Scene& settings, const OpenOptions& options) {
    worlds::WorldOptions out = scene::to_world_options(settings);
    out.orthophotos.assign(options.orthophotos.begin(), options.orthophotos.end());
    out.additions = options.additions;
    out.cache_dir = util::cache_dir(options.cache);
    return out;
}

lidar::LasWritePoint written(const Point& point) {
    lidar::LasWritePoint out;
    out.x = point.x;
    out.y = point.y;
    out.z = point.z;
    out.intensity = point.intensity;
    out.return_number = point.return_number;
    out.return_count = point.return_count;
    out.classification = point.classification;
    out.rgb = point.rgb;
    return out;
}

/// Writes points to a LAZ file.
/// @return its path
std::string spool(PointSource& points, const std::filesystem::path& folder,
                  const Control& control) {
    constexpr int kWithColours = 7;
    constexpr double kStep_m = 0.001;
    std::vector<Point> batch;
    const auto next = [&] {
        check_stop(control);
        batch.clear();
        return points.next(batch);
    };
    bool more = next();
    while (more && batch.empty())
        more = next();
    if (!more)
        throw util::UsageError("voxelize points: there are none; allowed: at least 1");
    lidar::LasWriterOptions options;
    options.point_format = kWithColours;
    options.scale = {kStep_m, kStep_m, kStep_m};
    // Coordinates are whole numbers of steps from here, 2147 km to each side.
    options.offset = {std::floor(batch.front().x), std::floor(batch.front().y), 0};
    const std::filesystem::path file = folder / "points.laz";
    lidar::LasWriter writer(file, options);
    while (more) {
        for (const Point& point : batch)
            writer.write(written(point));
        more = next();
    }
    writer.close();
    return file;
}

}  // namespace

World World::open(const std::vector<std::string>& inputs, const OpenOptions& options,
                  const Control& control) {
    return guarded(control, [&] {
        set_up_log_once();
        const scene::Scene settings = make_settings(options);
        worlds::WorldOptions from = world_options(settings, options);
        from.inputs = inputs;
        const auto open = [&](util::StageTimes& times) {
            check_stop(control);
            return worlds::open_world(from, times, control.stop);
        };
        World out(make_state(settings, open));
        check_stop(control);
        return out;
    });
}

World World::of(std::shared_ptr<VoxelSource> source, const OpenOptions& options) {
    return guarded([&] {
        set_up_log_once();
        if (!source)
            throw util::UsageError("open a world of one's own: no source; allowed: one");
        if (!options.crs.empty() || !options.classes.empty() || options.voxel_m ||
            !options.orthophotos.empty() || !options.additions.empty())
            throw util::UsageError(
                "open a world of one's own: crs, classes, voxel_m, orthophotos or additions; "
                "allowed: fields, since a source says the rest itself");
        const scene::Scene settings = make_settings(options);
        const auto open = [&](util::StageTimes&) {
            return std::make_unique<SourceWorld>(
                source, static_cast<std::size_t>(settings.world.memory_mib) << 20);
        };
        return World(make_state(settings, open));
    });
}

World World::voxelize(PointSource& points, const OpenOptions& options, const Control& control) {
    return guarded(control, [&] {
        set_up_log_once();
        const scene::Scene settings = make_settings(options);
        auto folder = util::TemporaryFolder::make("voxelize points");
        worlds::WorldOptions from = world_options(settings, options);
        if (from.crs.empty())
            from.crs = points.crs();
        // Its name is another one each time.
        from.cache_dir.clear();
        from.inputs = {spool(points, folder.path(), control)};
        const auto open = [&](util::StageTimes& times) {
            return worlds::open_world(from, times, control.stop);
        };
        return World(make_state(settings, open, std::move(folder)));
    });
}

const WorldInfo& World::info() const noexcept {
    return m_state->info;
}

std::vector<std::string> World::damage() const {
    return guarded([&] { return m_state->world->damage(); });
}

VoxelBlock World::block_of(const std::optional<MapBounds>& bounds, int level) const {
    return guarded([&] {
        const voxel::VoxelBounds found = m_state->block_over(bounds, level);
        return VoxelBlock{level, found.min, found.max};
    });
}

}  // namespace terravox
