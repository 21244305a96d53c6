#include "raytracer/render/render_command.hpp"

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include <csignal>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/util/cache_dir.hpp"
#include "common/thread/parallel.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/log.hpp"
#include "raytracer/render/statistics.hpp"
#include "raytracer/render/world_arguments.hpp"
#include "raytracer/scene/scene_io.hpp"
#include "raytracer/sched/thread_processor.hpp"
#include "raytracer/world/open_world.hpp"

namespace terravox {
namespace {

struct Arguments {
    WorldArguments world;
    std::vector<std::string> outputs;
    std::string save_scene, report;
    bool quiet = false;
};

std::atomic<bool> g_stop{false};

ExitCode run(const Arguments& args) {
    util::set_up_log(args.quiet ? "error" : args.world.log_level);
    const auto start = std::chrono::steady_clock::now();
    const Scene scene = args.world.scene();
    // Refuse what cannot be written before any work is done.
    if (args.outputs.empty()) throw UsageError("render: no picture named; give -o FILE.png or FILE.exr");
    for (const std::string& output : args.outputs) check_image_target(output);
    if (!args.report.empty()) util::check_writable(args.report);
    if (!args.save_scene.empty()) util::write_file_atomically(args.save_scene, to_toml(scene));

    util::StageTimes times;
    RenderStatistics statistics;
    statistics.threads = thread::thread_count(scene.processing.threads);
    const auto world = open_world(args.world.inputs, args.world.orthophoto_paths(), scene, times, util::cache_dir(args.world.cache));
    BlockManager blocks(*world, static_cast<std::size_t>(scene.processing.memory_mib) << 20, loaders_for(args.world.inputs, statistics.threads));
    const View view = make_view(scene, blocks);
    foresee_boxes(view, blocks);
    // Before this, a signal just ends the program: nothing is half done, and a world may take minutes to open.
    std::signal(SIGINT, [](int) { g_stop = true; });
    std::signal(SIGTERM, [](int) { g_stop = true; });
    Film film(scene.output.size_px[0], scene.output.size_px[1], view.wants_layers());
    {
        const util::StageTimes::Clock timed(times, "ray tracing (clock)");
        ThreadProcessor processor(view, blocks, statistics.threads);
        statistics.counts = render_film({view, processor, ThreadProcessor::tiles_in_flight(statistics.threads), args.quiet, &g_stop, start}, film);
        processor.close();
    }
    statistics.blocks = blocks.stats();
    statistics.limit_bytes = blocks.limit_bytes();
    statistics.peak_rss_bytes = peak_rss_bytes();
    const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    statistics.seconds = seconds();
    {
        const util::StageTimes::Scope timed(times, "write pictures");
        const ImageMetadata plain = metadata_of(view, world->info(), statistics.counts.holes.size()), taken = metadata_of(statistics);
        thread::parallel_for(args.outputs.size(), statistics.threads, [&](std::size_t i) {
            ImageMetadata metadata = plain;
            if (args.outputs[i].ends_with(".exr")) metadata.insert(metadata.end(), taken.begin(), taken.end());
            write_image(film, args.outputs[i], scene.output.exposure_ev, scene.output.tone, metadata);
        });
    }
    statistics.seconds = seconds();
    if (!args.report.empty()) util::write_file_atomically(args.report, report_of(statistics, times, view).dump(2) + "\n");
    if (!args.quiet) {
        print_statistics(statistics, times);
        for (const std::string& output : args.outputs) std::printf("wrote %s\n", output.c_str());
    }
    if (!statistics.counts.holes.empty()) {
        spdlog::error("the picture has holes: {} boxes could not be had", statistics.counts.holes.size());
        return ExitCode::kHoles;
    }
    return ExitCode::kDone;
}

}  // namespace

std::function<ExitCode()> add_render_command(CLI::App& app) {
    auto args = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand("render", "Render a world to PNG, JPEG, EXR or TIFF files");
    add_world_arguments(*command, args->world);
    command->add_option("-o,--output", args->outputs, "picture to write: .png .jpg (8-bit), .exr .tif (float); may be given several times")
        ->required()->expected(1)->take_all();
    command->add_option("--save-scene", args->save_scene, "write the scene with all flags applied to this file");
    command->add_option("--report", args->report, "write times and counts to this file (JSON)");
    command->add_flag("-q,--quiet", args->quiet, "say nothing but errors");
    return [args] { return run(*args); };
}

}  // namespace terravox
