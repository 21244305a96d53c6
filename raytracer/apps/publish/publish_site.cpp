#include "raytracer/apps/publish/publish_site.hpp"

#include <chrono>
#include <cmath>
#include <optional>

#include "common/util/atomic_file.hpp"
#include "common/util/det_math.hpp"
#include "common/util/log.hpp"
#include "common/voxel/log_damage.hpp"
#include "raytracer/apps/publish/appearance_file.hpp"
#include "raytracer/apps/publish/site.hpp"
#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/sky/sun.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"
#include "voxelserver/make/worlds/overlay/overlay_world.hpp"
#include "voxelserver/out/archive/split.hpp"
#include "voxelserver/out/export/formats/formats.hpp"

namespace terravox::publish {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMib = std::uint64_t{1} << 20;

/// What is known once the archive stands.
struct Published {
    voxel::WorldInfo world;
    std::size_t holes = 0;
    std::vector<std::string> damage;
};

bool is_one_archive(const SiteOptions& args) {
    const auto& inputs = args.world.inputs;
    return inputs.size() == 1 && worlds::find_kind(inputs.front()).is_archive;
}

// Taken as it is, unless something is put into it; every other world is converted.
bool is_archive_here(const SiteOptions& args) {
    return args.world.additions.empty() && is_one_archive(args) &&
           worlds::find_kind(args.world.inputs.front()).is_path;
}

bool is_referred_to(const SiteOptions& args) {
    return !args.archive_url.empty();
}

/// @throws UsageError
void check_reference(const SiteOptions& args) {
    if (!is_referred_to(args))
        return;
    check_archive_url(args.archive_url);
    if (!args.world.additions.empty())
        throw util::UsageError(
            "publish: --add with --archive-url; allowed: one of them, as what is "
            "added would not be in the archive that lies there");
    if (!is_one_archive(args))
        throw util::UsageError("publish: --archive-url " + args.archive_url + " with " +
                               args.world.inputs.front() +
                               "; allowed: the archive that lies there, a copy of it here or its "
                               "address; terravox convert makes archives");
}

/// The part of a world that a site shows; an archive is shown as it is.
/// @throws UsageError
std::optional<exports::Part> part_to_publish(const SiteOptions& args,
                                             const voxel::WorldInfo& world) {
    const std::vector<double>& area = args.area_numbers;
    if (is_archive_here(args) || is_referred_to(args)) {
        if (!area.empty())
            throw util::UsageError("publish: --area " + args.area +
                                   " of an archive, which is published whole; terravox convert "
                                   "--area makes a smaller one");
        return std::nullopt;
    }
    const exports::Part part = exports::make_part(world, exports::Selection{0, area, {}});
    if (area.empty() && !(part.bounds == world.bounds)) {
        const auto& [min, max] = part.bounds;
        util::log_info(
            "publishes x {} to {}, z {} to {}, voxels, of a world that has more; --area chooses",
            min[0], max[0], min[2], max[2]);
    }
    return part;
}

void write_archive(const SiteOptions& args, const fs::path& archive, voxel::World& world,
                   const exports::Part* chosen, Published& out) {
    if (is_referred_to(args))
        return;
    if (chosen == nullptr) {
        copy_archive(args.world.inputs.front(), archive);
        return;
    }
    const exports::Part& part = *chosen;
    const exports::Format& format = exports::find_format_by("archive", archive);
    exports::WriteOptions write;
    write.overwrite = true;
    format.check_target(archive, write);
    const voxel::Palette palette = voxel::load_palette(material::find_materials(""));
    exports::Meter meter("publish", format.steps(part, world.info()), args.quiet);
    exports::Job job(world, part, archive, palette, meter);
    job.name = args.conversion(part, world);
    job.threads = args.scene.processing.threads.value_or(0);
    job.stop = args.stop;
    job.memory_bytes = static_cast<std::size_t>(args.memory_mib) << 20;
    format.write(job, write);
    meter.finish();
    out.holes = job.holes().size();
}

SiteView make_site_view(const std::string& name, const scene::Scene& scene,
                        const voxel::WorldInfo& world) {
    const scene::Camera camera = scene::make_camera(scene, world, world.camera_bounds());
    constexpr double kAhead_voxel = 100;
    SiteView view;
    view.name = name;
    view.position = camera.position();
    view.target = camera.position() + camera.forward() * kAhead_voxel;
    const double half = core::length(camera.basis().up);
    view.fov_deg = std::atan(half) * 2 * 180 / det::kPi;
    return view;
}

std::vector<SiteView> list_site_views(const scene::Scene& scene, const voxel::WorldInfo& world) {
    if (scene.camera.projection != core::CameraProjection::kPerspective)
        throw util::UsageError(
            "publish: camera.projection is not perspective; the viewer has no other");
    scene::Scene without_camera = scene;
    without_camera.camera = {};
    SiteView whole = make_site_view("Whole place", without_camera, world);
    whole.frame = world.camera_bounds();
    return {make_site_view("Start", scene, world), whole};
}

std::int64_t time_ms(const scene::Scene& scene, const voxel::WorldInfo& world) {
    const geo::DateTime time = sky::to_time(scene.sun, world.centre ? &*world.centre : nullptr);
    const std::chrono::sys_days day = std::chrono::year(time.year) /
                                      std::chrono::month(static_cast<unsigned>(time.month)) /
                                      std::chrono::day(static_cast<unsigned>(time.day));
    constexpr double kHour_ms = 3'600'000;
    const auto start =
        std::chrono::duration_cast<std::chrono::milliseconds>(day.time_since_epoch());
    return start.count() + std::llround((time.hour - time.utc_offset_h) * kHour_ms);
}

/// @return number of boxes that could not be loaded
std::size_t write_preview(const SiteOptions& args, scene::Scene scene, const fs::path& folder) {
    constexpr std::array kSize_px = {1200, 630};  // what sites that show links expect
    constexpr int kSamples = 16;
    scene.output.size_px = kSize_px;
    scene.quality.samples = kSamples;
    worlds::WorldOptions world = args.world;
    if (!is_referred_to(args))
        world.inputs = {(folder / kSiteArchive).string()};
    world.orthophotos.clear();
    world.additions.clear();  // they are in the archive
    render::PictureRenderer renderer(world, render::RenderPoolOptions{}, scene, args.quiet);
    return renderer.render(scene, {(folder / kSitePreview).string()}).counts.holes.size();
}

std::vector<archive_tools::FilePart> make_archive(const SiteOptions& args,
                                                  const fs::path& archive) {
    if (is_referred_to(args))
        return {{args.archive_url, 0}};
    return archive_tools::split(archive, archive.parent_path(),
                                args.split_mib == 0 ? UINT64_MAX : args.split_mib * kMib);
}

/// The LiDAR squares that lie in a part of a world.
std::vector<SiteSquare> squares_in(const voxel::World& world, const voxel::VoxelBounds& part) {
    const auto* with_objects = dynamic_cast<const overlay::OverlayWorld*>(&world);
    const auto* lidar = dynamic_cast<const voxelize::LidarWorld*>(
        with_objects != nullptr ? &with_objects->base() : &world);
    if (lidar == nullptr)
        return {};
    const decltype(voxelize::SquareInfo::bounds) shown{part.min[0], part.min[2], part.max[0],
                                                       part.max[2]};
    const double units = world.info().crs_units_per_voxel;
    std::vector<SiteSquare> out;
    for (const voxelize::SquareInfo& square : lidar->squares()) {
        const auto& [min_x, min_z, max_x, max_z] = square.bounds;
        if (square.bounds.overlaps(shown))
            out.push_back(
                {square.name, min_x * units, -max_z * units, max_x * units, -min_z * units});
    }
    if (out.size() <= kMaxSquares)
        return out;
    util::log_info("publishes no list of its {} LiDAR squares; one of up to {} is published",
                   out.size(), kMaxSquares);
    return {};
}

void check_facts(const SiteFacts& facts) {
    for (const auto& [name, text] :
         {std::pair{"title", &facts.title}, std::pair{"attribution", &facts.attribution},
          std::pair{"licence", &facts.licence}})
        if (text->size() > kMaxText_bytes)
            throw util::UsageError(std::string("publish: the ") + name + " has " +
                                   std::to_string(text->size()) + " bytes; allowed: up to " +
                                   std::to_string(kMaxText_bytes));
    for (const SiteView& view : facts.views)
        if (!(view.fov_deg >= kMinFov_deg && view.fov_deg <= kMaxFov_deg))
            throw util::UsageError("publish: camera.fov_deg = " + std::to_string(view.fov_deg) +
                                   "; the viewer has 5 to 120");
    if (facts.time_ms < 0 || facts.time_ms > kMaxTime_ms)
        throw util::UsageError("publish: sun.date lies before 1970 or after 2199");
}

SiteFacts collect_facts(const SiteOptions& args, const scene::Scene& scene,
                        const voxel::WorldInfo& world) {
    if (scene.sun.altitude_deg || scene.sun.azimuth_deg)
        throw util::UsageError(
            "publish: sun.altitude_deg and sun.azimuth_deg; the viewer places the sun by date and "
            "time alone");
    SiteFacts facts;
    facts.title = args.title.empty() ? world.title : args.title;
    facts.attribution = args.attribution.empty() ? world.attribution : args.attribution;
    facts.licence = args.licence.empty() ? world.licence : args.licence;
    facts.views = list_site_views(scene, world);
    facts.time_ms = time_ms(scene, world);
    facts.has_preview = !args.no_preview;
    check_facts(facts);
    return facts;
}

void check_target(const SiteOptions& args, const fs::path& archive) {
    std::error_code none;
    const bool removes_archive = args.split_mib != 0 || is_referred_to(args);
    if (is_archive_here(args) && removes_archive &&
        fs::equivalent(args.world.inputs.front(), archive, none))
        throw util::UsageError("publish: " + archive.string() +
                               " would be removed from the site; move it elsewhere first");
}

/// What may lie in the folder of a site before it is one.
fs::path find_input(const SiteOptions& args) {
    return is_archive_here(args) ? fs::path(args.world.inputs.front()) : fs::path();
}

}  // namespace

util::ExitCode publish_site(const fs::path& folder, const SiteOptions& args) {
    const fs::path archive = folder / kSiteArchive;
    const scene::Scene& scene = args.scene;
    check_reference(args);
    check_target(args, archive);
    const SiteFolder held(folder, find_input(args), args.overwrite);
    util::check_writable(archive);
    std::optional<std::stop_callback<std::function<void()>>> at_once;
    if (args.abandon)
        at_once.emplace(args.stop, args.abandon);
    util::StageTimes times;
    const auto world = worlds::open_world(args.world, times);
    Published published{world->info(), 0, {}};
    if (published.world.bounds.empty())
        throw util::Error("publish the world '" + published.world.title + "': it is empty");
    const auto materials =
        material::read_materials(material::find_materials(scene.quality.materials));
    const std::optional<exports::Part> part = part_to_publish(args, published.world);
    if (part)
        published.world.framed = part->bounds;
    SiteFacts facts = collect_facts(args, scene, published.world);
    facts.squares = squares_in(*world, published.world.framed_bounds());

    at_once.reset();
    write_archive(args, archive, *world, part ? &*part : nullptr, published);
    if (facts.has_preview)
        published.holes += write_preview(args, scene, folder);
    published.damage = world->damage();
    const AirOptions air{
        std::clamp(scene.sky.turbidity, 1.0, 20.0),
        std::clamp(published.world.bounds.min[1] * published.world.voxel_m, 0.0, 10'000.0)};
    util::write_file_atomically(folder / kSiteAppearance,
                                appearance_file(materials.appearances, air), util::Links::kReplace);
    facts.archive = make_archive(args, archive);
    write_site(folder, facts);
    if (published.holes > 0)
        util::log_error("the place has holes: {} boxes could not be loaded", published.holes);
    if (!published.damage.empty())
        voxel::log_damage(published.damage);
    return published.holes > 0 || !published.damage.empty() ? util::ExitCode::kHoles
                                                            : util::ExitCode::kDone;
}

}  // namespace terravox::publish
