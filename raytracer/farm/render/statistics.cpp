#include "raytracer/farm/render/statistics.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>

#include "common/util/version.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/walk/traced_ray.hpp"

namespace terravox::render {
namespace {

double mebibytes(std::size_t bytes) noexcept {
    return static_cast<double>(bytes) / (1 << 20);
}

double per_ray(const tiles::TraceCounts& c, std::uint64_t n) noexcept {
    return static_cast<double>(n) / static_cast<double>(std::max<std::uint64_t>(c.all_rays(), 1));
}

double hit_rate(const blocks::BlockStats& b) noexcept {
    return static_cast<double>(b.hits) /
           static_cast<double>(std::max<std::uint64_t>(b.hits + b.misses, 1));
}

nlohmann::json make_levels(const blocks::BlockStats& blocks) {
    nlohmann::json out = nlohmann::json::array();
    for (std::size_t l = 0; l < blocks.levels.size(); ++l) {
        const auto& level = blocks.levels[l];
        if (level.loaded == 0)
            continue;
        out.push_back({{"level", l},
                       {"loaded", level.loaded},
                       {"evicted", level.evicted},
                       {"reloaded", level.reloaded},
                       {"bytes", level.bytes_loaded}});
    }
    return out;
}

nlohmann::json list_rays(const tiles::TraceCounts& counts) {
    nlohmann::json out;
    for (std::size_t k = 0; k < walk::kRayKinds; ++k)
        out[walk::to_name(static_cast<walk::RayKind>(k))] = counts.rays[k];
    return out;
}

nlohmann::json to_seconds(const tiles::TraceCounts& counts) {
    nlohmann::json out;
    for (std::size_t i = 0; i < tiles::kTraceStages; ++i)
        out[tiles::to_name(static_cast<tiles::TraceStage>(i))] = counts.seconds[i];
    return out;
}

void print_shares(const tiles::TraceCounts& counts) {
    const double all = std::accumulate(counts.seconds.begin(), counts.seconds.end(), 0.0);
    if (!(all > 0))
        return;
    std::printf("tracing:");
    for (std::size_t i = 0; i < tiles::kTraceStages; ++i)
        std::printf("%s %s %.0f %%", i == 0 ? "" : ",",
                    tiles::to_name(static_cast<tiles::TraceStage>(i)),
                    100 * counts.seconds[i] / all);
    std::printf("\n");
}

}  // namespace

std::uint64_t peak_rss_bytes() noexcept {
    rusage usage{};
    return getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::uint64_t>(usage.ru_maxrss) * 1024
                                               : 0;
}

namespace {

nlohmann::json describe_pool(const RenderStatistics& s) {
    nlohmann::json participants = nlohmann::json::array();
    for (const processors::ProcessorPool::Status& h : s.participants)
        participants.push_back({{"name", h.name},
                                {"kind", h.kind},
                                {"state", h.state},
                                {"threads", h.threads},
                                {"bands", h.bands},
                                {"pixels", h.pixels},
                                {"pixels_per_s", h.pixels_per_s},
                                {"latency_s", h.latency_s},
                                {"busy_share", h.busy_share}});
    const processors::ProcessorPool::Counts& c = s.pool;
    return {{"processors", participants},
            {"late_answers", c.late},
            {"unasked_answers", c.unrequested},
            {"checked", c.checked},
            {"expelled", c.expelled},
            {"lost", c.lost},
            {"given_back", c.given_back},
            {"second_leases", c.second},
            {"mended", c.mended}};
}

}  // namespace

nlohmann::json make_report(const RenderStatistics& s, const util::StageTimes& times,
                           const shade::View& view) {
    nlohmann::json stages = nlohmann::json::array();
    for (const auto& stage : times.stages())
        stages.push_back(
            {{"name", stage.name}, {"seconds", stage.seconds}, {"count", stage.count}});
    const tiles::TraceCounts& t = s.counts.trace;
    nlohmann::json out = {{"software", std::string("terravox ") + kVersion},
                          {"seconds", s.seconds},
                          {"threads", s.threads},
                          {"stages", stages},
                          {"size", view.scene.output.size_px},
                          {"samples", s.counts.samples},
                          {"tiles", s.counts.tiles},
                          {"rays", t.all_rays()},
                          {"rays_by_kind", list_rays(t)},
                          {"tracing_seconds", to_seconds(t)},
                          {"steps", t.steps},
                          {"slabs", t.slabs},
                          {"rays_spared", t.spared},
                          {"rays_parked", t.parked},
                          {"hole_rays", t.hole_rays},
                          {"holes", s.counts.holes.size()},
                          {"damage", s.damage},
                          {"boxes",
                           {{"levels", make_levels(s.blocks)},
                            {"hit_rate", hit_rate(s.blocks)},
                            {"waits", s.blocks.waits},
                            {"limit_bytes", s.limit_bytes},
                            {"peak_bytes", s.blocks.peak_bytes}}},
                          {"peak_rss_bytes", s.peak_rss_bytes}};
    out["tiles_resumed"] = s.counts.resumed;
    out["tiles_missing"] = s.counts.missing;
    if (!s.participants.empty())
        out["farm"] = describe_pool(s);
    return out;
}

void print_statistics(const RenderStatistics& s, const util::StageTimes& times) {
    // Stages that run on several threads sum up to more than the clock shows.
    std::printf("\n%-22s %9s %7s\n", "stage", "seconds", "times");
    for (const auto& stage : times.stages())
        std::printf("%-22s %9.3f %7llu\n", stage.name.c_str(), stage.seconds,
                    static_cast<unsigned long long>(stage.count));
    std::printf("%-22s %9.3f\n", "whole (clock)", s.seconds);
    const tiles::TraceCounts& t = s.counts.trace;
    std::printf("%.2f million rays (", static_cast<double>(t.all_rays()) / 1e6);
    for (std::size_t k = 0; k < walk::kRayKinds; ++k)
        std::printf("%s%s %.2f", k == 0 ? "" : ", ", walk::to_name(static_cast<walk::RayKind>(k)),
                    static_cast<double>(t.rays[k]) / 1e6);
    std::printf("), %.1f steps a ray, %.0f %% spared, %d threads\n", per_ray(t, t.steps),
                100 * per_ray(t, t.spared), s.threads);
    print_shares(t);
    for (std::size_t l = 0; l < s.blocks.levels.size(); ++l) {
        const auto& level = s.blocks.levels[l];
        if (level.loaded == 0)
            continue;
        std::printf(
            "boxes of level %zu: %llu loaded (%.1f MiB), %llu evicted, %llu of them loaded again\n",
            l, static_cast<unsigned long long>(level.loaded), mebibytes(level.bytes_loaded),
            static_cast<unsigned long long>(level.evicted),
            static_cast<unsigned long long>(level.reloaded));
    }
    std::printf(
        "%.1f MiB of boxes at most (limit %.0f), %llu waits for boxes, %.0f MiB of memory at "
        "most\n",
        mebibytes(s.blocks.peak_bytes), mebibytes(s.limit_bytes),
        static_cast<unsigned long long>(s.blocks.waits), mebibytes(s.peak_rss_bytes));
}

namespace {

output::ImageMetadata make_metadata(const shade::View& view, const voxel::WorldInfo& world,
                                    const RenderStatistics& s) {
    const auto text = [](double v) { return std::to_string(v); };
    const auto texts = [&](core::Vec3 v) { return text(v.x) + " " + text(v.y) + " " + text(v.z); };
    const core::Vec3 to_sun = view.sky.to_sun();
    output::ImageMetadata out = {
        {"Software", std::string("terravox ") + kVersion},
        {"ImageDescription", world.title},
        {"terravox:voxel_m", text(world.voxel_m)},
        {"terravox:camera", texts(view.camera.position())},
        {"terravox:projection", std::string(core::to_word(view.scene.camera.projection))},
        {"terravox:origin", texts(view.origin)},
        {"terravox:to_sun", texts(to_sun)},
        {"terravox:detail", text(view.scene.quality.detail)},
        {"terravox:exposure_ev", text(view.exposure_ev)},
        {"terravox:samples", std::to_string(s.counts.samples)},
        {"terravox:holes", std::to_string(s.counts.holes.size())}};
    if (s.counts.missing > 0)
        out.emplace_back("terravox:missing_tiles", std::to_string(s.counts.missing));
    if (!s.damage.empty())
        out.emplace_back("terravox:damage", std::to_string(s.damage.size()));
    if (!world.crs.empty())
        out.emplace_back("terravox:crs", world.crs);
    if (std::string copyright = find_copyright(world); !copyright.empty())
        out.emplace_back("Copyright", std::move(copyright));
    return out;
}

output::ImageMetadata describe_run(const RenderStatistics& s) {
    const tiles::TraceCounts& t = s.counts.trace;
    return {{"terravox:seconds", std::to_string(s.seconds)},
            {"terravox:rays", list_rays(t).dump()},
            {"terravox:steps_per_ray", std::to_string(per_ray(t, t.steps))},
            {"terravox:rays_spared", std::to_string(t.spared)},
            {"terravox:rays_parked", std::to_string(t.parked)},
            {"terravox:boxes", make_levels(s.blocks).dump()},
            {"terravox:box_hit_rate", std::to_string(hit_rate(s.blocks))},
            {"terravox:box_waits", std::to_string(s.blocks.waits)},
            {"terravox:peak_memory_bytes", std::to_string(s.peak_rss_bytes)}};
}

std::array<float, 16> single(const std::array<double, 16>& m) noexcept {
    std::array<float, 16> out;
    std::transform(m.begin(), m.end(), out.begin(), [](double v) { return static_cast<float>(v); });
    return out;
}

}  // namespace

std::string find_copyright(const voxel::WorldInfo& world) {
    if (world.attribution.find(world.licence) != std::string::npos)
        return world.attribution;
    return world.attribution.empty() ? world.licence : world.attribution + ", " + world.licence;
}

output::PictureInfo picture_info(const shade::View& view, const voxel::WorldInfo& world,
                                 const RenderStatistics& statistics, bool with_run) {
    const auto& output = view.scene.output;
    output::PictureInfo out;
    out.exposure_ev = view.exposure_ev;
    out.tone = output.tone;
    if (output.credit)
        out.credit = world.attribution;
    out.metadata = make_metadata(view, world, statistics);
    out.metadata.emplace_back("terravox:scene", scene::to_toml(scene::what_shows(view.scene)));
    if (!world.crs_wkt.empty())
        out.metadata.emplace_back("terravox:crs_wkt", world.crs_wkt);
    if (with_run)
        for (auto& entry : describe_run(statistics))
            out.metadata.push_back(std::move(entry));
    out.world_to_camera = single(view.camera.world_to_camera());
    if (const auto ndc = view.camera.world_to_ndc())
        out.world_to_ndc = single(*ndc);
    out.layers = output.layers != core::PictureLayers::kBeauty;
    // They all go into the manifest of the squares' matte.
    constexpr std::uint32_t kMaxNames = 10'000;
    if (out.layers)
        for (std::uint32_t i = 0; i < std::min(view.squares.count(), kMaxNames); ++i)
            out.square_names.push_back(view.squares.to_name(i));
    if (const auto transform = view.camera.geotransform(world))
        out.geo = output::GeoPlacement{*transform, world.crs_wkt};
    out.tiff_samples = output.tiff;
    return out;
}

}  // namespace terravox::render
