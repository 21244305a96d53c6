#include "raytracer/render/render_command.hpp"

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include <csignal>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/util/cache_dir.hpp"
#include "common/thread/parallel.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/log.hpp"
#include "common/util/version.hpp"
#include "raytracer/render/render.hpp"
#include "raytracer/render/world_arguments.hpp"
#include "raytracer/scene/scene_io.hpp"
#include "raytracer/sched/thread_processor.hpp"
#include "raytracer/world/block_manager.hpp"
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

struct Outcome {
    RenderCounts counts;
    double seconds = 0;
    std::size_t holes = 0;
    int threads = 1;
};

nlohmann::json report_of(const Outcome& o, const util::StageTimes& times, const View& view) {
    nlohmann::json stages = nlohmann::json::array();
    for (const auto& s : times.stages()) stages.push_back({{"name", s.name}, {"seconds", s.seconds}, {"count", s.count}});
    return {{"software", std::string("terravox ") + kVersion}, {"seconds", o.seconds}, {"threads", o.threads}, {"stages", stages},
            {"rays", o.counts.rays}, {"steps", o.counts.steps}, {"tiles", o.counts.tiles}, {"holes", o.holes}, {"size", view.scene.output.size_px}};
}

void print_times(const Outcome& o, const util::StageTimes& times) {
    // Stages that run on several threads sum up to more than the clock shows.
    std::printf("\n%-22s %9s %7s\n", "stage", "seconds", "times");
    for (const auto& s : times.stages()) std::printf("%-22s %9.3f %7llu\n", s.name.c_str(), s.seconds, static_cast<unsigned long long>(s.count));
    std::printf("%-22s %9.3f\n", "whole (clock)", o.seconds);
    std::printf("%.2f million rays, %.1f steps a ray, %d threads\n", static_cast<double>(o.counts.rays) / 1e6,
                static_cast<double>(o.counts.steps) / static_cast<double>(std::max<std::uint64_t>(o.counts.rays, 1)), o.threads);
}

ExitCode run(const Arguments& args) {
    util::set_up_log(args.quiet ? "error" : args.world.log_level);
    const auto start = std::chrono::steady_clock::now();
    const Scene scene = args.world.scene();
    // Refuse what cannot be written before any work is done.
    if (args.outputs.empty()) throw UsageError("render: no picture named; give -o FILE.png or FILE.exr");
    for (const std::string& output : args.outputs) check_image_target(output);
    if (!args.report.empty()) util::check_writable(args.report);
    if (!args.save_scene.empty()) util::write_file_atomically(args.save_scene, to_toml(scene));
    std::signal(SIGINT, [](int) { g_stop = true; });
    std::signal(SIGTERM, [](int) { g_stop = true; });

    util::StageTimes times;
    Outcome outcome;
    outcome.threads = thread::thread_count(scene.processing.threads);
    const auto world = open_world(args.world.inputs, args.world.orthophoto_paths(), scene, times, util::cache_dir(args.world.cache));
    BlockManager blocks(*world, static_cast<std::size_t>(scene.processing.memory_mib) << 20);
    const View view = make_view(scene, blocks);
    {
        const util::StageTimes::Clock timed(times, "boxes (clock)");
        blocks.prefetch(scene.quality.level, world->info().bounds, outcome.threads, g_stop);
    }
    Film film(scene.output.size_px[0], scene.output.size_px[1]);
    {
        const util::StageTimes::Clock timed(times, "ray tracing (clock)");
        ThreadProcessor processor(view, blocks, outcome.threads);
        outcome.counts = render_film({view, processor, outcome.threads * 2, args.quiet, &g_stop}, film);
        processor.close();
    }
    outcome.holes = blocks.hole_count();
    {
        const util::StageTimes::Scope timed(times, "write pictures");
        const ImageMetadata metadata = metadata_of(view, world->info(), outcome.holes);
        thread::parallel_for(args.outputs.size(), outcome.threads,
                             [&](std::size_t i) { write_image(film, args.outputs[i], scene.output.exposure_ev, scene.output.tone, metadata); });
    }
    outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!args.report.empty()) util::write_file_atomically(args.report, report_of(outcome, times, view).dump(2) + "\n");
    if (!args.quiet) {
        print_times(outcome, times);
        for (const std::string& output : args.outputs) std::printf("wrote %s\n", output.c_str());
    }
    if (outcome.holes > 0) {
        spdlog::error("the picture has holes: {} boxes could not be had", outcome.holes);
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
