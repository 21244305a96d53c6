#include "raytracer/apps/library/state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <terravox/error.hpp>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/core/scene/views.hpp"

namespace terravox {
namespace {

/// Voxels [begin, end) that cover [low, high], within those of the world.
void cover(double low, double high, std::int32_t begin, std::int32_t end, std::int32_t& from,
           std::int32_t& to) {
    // Borders that are meant to be those of voxels may be off by rounding.
    constexpr double kSlack = 1e-6;
    from = static_cast<std::int32_t>(
        std::clamp(std::floor(low + kSlack), static_cast<double>(begin), static_cast<double>(end)));
    to = static_cast<std::int32_t>(
        std::clamp(std::ceil(high - kSlack), static_cast<double>(begin), static_cast<double>(end)));
}

std::string to_text(const MapBounds& b) {
    return std::to_string(b.west) + ", " + std::to_string(b.south) + ", " + std::to_string(b.east) +
           ", " + std::to_string(b.north) + ", heights " + std::to_string(b.bottom) + " to " +
           std::to_string(b.top);
}

}  // namespace

voxel::VoxelBounds MapFrame::block_over(const MapBounds& bounds, int level,
                                        const voxel::VoxelBounds& world) const {
    for (const double edge :
         {bounds.west, bounds.south, bounds.east, bounds.north, bounds.bottom, bounds.top})
        if (std::isnan(edge))
            throw util::UsageError("find voxels: an edge of the bounds is not a number (" +
                                   to_text(bounds) + "); allowed: numbers");
    const double scale = static_cast<double>(std::int64_t{1} << level);
    const std::int32_t side = std::int32_t{1} << level;
    const double low[3] = {bounds.west / m_units, bounds.bottom / m_voxel_m,
                           -bounds.north / m_units};
    const double high[3] = {bounds.east / m_units, bounds.top / m_voxel_m, -bounds.south / m_units};
    voxel::VoxelBounds out;
    for (std::size_t a = 0; a < 3; ++a) {
        const std::int32_t begin = voxel::floor_div(world.min[a], side);
        const std::int32_t end = voxel::floor_div(world.max[a] - 1, side) + 1;
        cover(low[a] / scale, high[a] / scale, begin, end, out.min[a], out.max[a]);
    }
    if (out.empty())
        throw util::UsageError("find voxels: nothing is within " + to_text(bounds) +
                               "; allowed: what overlaps " + to_text(measure_bounds(world)));
    return out;
}

namespace {

WorldInfo make_info(const voxel::WorldInfo& world, const MapFrame& frame) {
    WorldInfo out;
    out.title = world.title;
    out.bounds = frame.measure_bounds(world.framed_bounds());
    out.block = {0, world.framed_bounds().min, world.framed_bounds().max};
    out.voxel_m = world.voxel_m;
    out.map_units = frame.units();
    out.levels = world.levels;
    out.crs = world.crs;
    out.crs_wkt = world.crs_wkt;
    if (world.centre)
        out.centre = {world.centre->lat_deg, world.centre->lon_deg};
    out.convergence_deg = world.centre ? world.centre->convergence_deg : 0;
    out.licence = world.licence;
    out.attribution = world.attribution;
    return out;
}

}  // namespace

WorldState::WorldState(const scene::Scene& settings, const OpenWorld& open,
                       util::TemporaryFolder files)
    : folder(std::move(files)),
      world(open(times)),
      frame(world->info()),
      info(make_info(world->info(), frame)),
      blocks(*world, static_cast<std::size_t>(settings.processing.memory_mib) << 20,
             world->useful_concurrency(
                 thread::thread_count(settings.processing.threads.value_or(0)))) {}

voxel::VoxelBounds WorldState::block_over(const std::optional<MapBounds>& bounds, int level) const {
    check_level(level);
    const voxel::WorldInfo& all = world->info();
    if (bounds)
        return frame.block_over(*bounds, level, all.bounds);
    return frame.block_over(frame.measure_bounds(all.framed_bounds()), level, all.framed_bounds());
}

voxel::VoxelBounds WorldState::columns_over(const std::optional<MapBounds>& area, int level) const {
    check_level(level);
    const voxel::WorldInfo& all = world->info();
    MapBounds wanted = area.value_or(frame.measure_bounds(all.framed_bounds()));
    wanted.bottom = -std::numeric_limits<double>::infinity();
    wanted.top = std::numeric_limits<double>::infinity();
    return frame.block_over(wanted, level, all.bounds);
}

void WorldState::check_level(int level) const {
    const int levels = world->info().levels;
    if (level < 0 || level >= levels)
        throw util::UsageError("read the world '" + world->info().title +
                               "': level = " + std::to_string(level) + "; allowed: 0 to " +
                               std::to_string(levels - 1));
}

std::shared_ptr<WorldState> make_state(const scene::Scene& settings, const OpenWorld& open,
                                       util::TemporaryFolder files) {
    note_process();
    auto state = std::make_unique<WorldState>(settings, open, std::move(files));
    return {state.release(), [](WorldState* made) {
                if (has_threads_here())
                    delete made;
            }};
}

scene::Scene make_settings(const OpenOptions& options) {
    for (const auto& [path, text] : options.fields) {
        const std::string section = path.substr(0, path.find('.'));
        if (section != "world" && section != "generated" && section != "processing")
            throw util::UsageError("open a world: field '" + path + "' = " + text +
                                   "; allowed: those of world, generated and processing");
    }
    scene::Scene out = scene::compose_scene({scene::fields_layer(options.fields)});
    if (!out.world.plane.empty() && out.world.plane != "none")
        throw util::UsageError("open a world: world.plane = " + out.world.plane +
                               "; allowed: none; terravox render makes pictures on a plane");
    if (!options.crs.empty())
        out.world.crs = options.crs;
    if (!options.classes.empty())
        out.world.classes = options.classes;
    if (options.voxel_m)
        out.world.voxel_m = *options.voxel_m;
    return out;
}

void check_threads(int threads) {
    constexpr int kMost = 1024;
    if (threads < 0 || threads > kMost)
        throw util::UsageError("use threads: " + std::to_string(threads) + "; allowed: 0 to " +
                               std::to_string(kMost));
}

WorldCall::WorldCall(const WorldState& state, int threads) : m_state(state) {
    check_threads(threads);
    // Others that are under way need one answer for each box.
    if (m_state.calls++ == 0)
        m_state.blocks.forget_holes();
}

WorldCall::~WorldCall() {
    --m_state.calls;
}

std::size_t WorldCall::checked(std::size_t holes) const {
    if (holes > 0)
        m_state.blocks.check_world();
    return holes;
}

void check_stop(const Control& control) {
    if (control.stop.stop_requested())
        throw Stopped("stopped");
}

}  // namespace terravox
