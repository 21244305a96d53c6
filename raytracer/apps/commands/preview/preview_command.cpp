#include "raytracer/apps/commands/preview/preview_command.hpp"

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/thread/parallel.hpp"
#include "common/thread/stop.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/command_line.hpp"
#include "common/util/log.hpp"
#include "common/util/process_memory.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/run_arguments.hpp"
#include "raytracer/apps/preview/app/app.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::commands {
namespace {

struct Arguments {
    WorldArguments world;
    RenderPoolArguments render_pool;
    std::string save_scene = "preview-scene.toml";
    std::string report;
    std::string size = "1280x720";
    bool light = false;
    double ui_scale = 0;
};

/// What renders the preview: the window's thread, and the given threads and workers; by default as
/// many threads as there are other cores.
render::RenderPoolOptions preview_render_pool(const Arguments& args, const scene::Scene& scene) {
    RenderPoolArguments asked = args.render_pool;
    asked.green = true;
    render::RenderPoolOptions out = asked.options(scene);
    out.green = out.changes = true;
    if (!scene.processing.threads)
        out.threads = std::max(thread::thread_count(0) - 1, 0);
    // None are needed until a worker is added; a lack of them is reported then.
    if (!out.farm.any())
        out.farm.credentials = args.render_pool.credentials.find().value_or(net::Credentials());
    return out;
}

nlohmann::json make_report(const preview::App& app) {
    nlohmann::json out = app.times().report();
    out["pictures"] = app.pictures();
    out["holes"] = app.holes();
    out["memory_bytes"] = util::resident_bytes();
    return out;
}

util::ExitCode run(const Arguments& args) {
    util::set_up_log(args.world.log_level);
    scene::Scene scene = args.world.scene();
    choose_plane(scene);
    const preview::AppOptions options{
        preview_render_pool(args, scene),
        render::RenderPoolOptions{
            thread::thread_count(scene.processing.threads.value_or(0)), false, {}, {}, false},
        args.save_scene, args.light, std::make_shared<preview::LogTail>()};
    spdlog::default_logger()->sinks().push_back(options.log);
    for (const std::string& input : args.world.inputs)
        (void)worlds::find_kind(input);  // before a window opens in vain
    if (!args.report.empty())
        util::check_writable(args.report);
    scene::Scene window_size;
    scene::set_field(window_size, "output.size", args.size);
    preview::Window window(window_size.output.size_px[0], window_size.output.size_px[1], "Terravox",
                           args.ui_scale);
    window.set_light(args.light);
    const thread::StopSignals signals;
    const std::stop_token quit = signals.token();
    preview::Session session(window, args.world.picture_options(scene), scene, options);
    while (window.open() && !quit.stop_requested())
        session.frame();
    const preview::App* const app = session.app();
    if (!args.report.empty() && app != nullptr)
        util::write_file_atomically(args.report, make_report(*app).dump(2) + "\n");
    const std::size_t holes = app != nullptr ? app->holes() : 0;
    window.hide();  // work in progress may take a while to end
    session.close();
    // Opening a world of files cannot be interrupted, and its result is no longer needed.
    if (session.is_opening()) {
        util::log_info("left before the world was open");
        spdlog::shutdown();
        std::_Exit(static_cast<int>(util::ExitCode::kDone));
    }
    if (!session.failure().empty())
        return util::ExitCode::kFailed;
    return holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

}  // namespace

std::function<util::ExitCode()> add_preview_options(CLI::App& app) {
    auto args = std::make_shared<Arguments>();
    add_world_arguments(app, args->world);
    add_render_pool_arguments(app, args->render_pool);
    app.add_option("--save-scene", args->save_scene, "where the scene is saved at first (Ctrl+S)")
        ->capture_default_str();
    app.add_option("--window", args->size,
                   "size of the window, WIDTHxHEIGHT; output.size is that of the final picture")
        ->capture_default_str();
    app.add_option("--report", args->report,
                   "write frame times and counts to this file at the end (JSON)");
    app.add_flag("--light", args->light, "light panels instead of dark ones");
    app.add_option("--ui-scale", args->ui_scale,
                   "size of text and handles, 0.5 to 4; default: as the monitor says")
        ->check(CLI::Range(0.5, 4.0));
    util::list_first(app,
                     {"--ortho", "--crs", "--voxel", "--scene", "--save-scene", "--look", "--date",
                      "--sun-time-h", "--window", "--light", "--ui-scale", "--threads"});
    return [args] { return run(*args); };
}

}  // namespace terravox::commands
