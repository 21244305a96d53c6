#include <algorithm>
#include <filesystem>

#include "raytracer/apps/commands/cluster/cluster_command.hpp"
#include "raytracer/apps/commands/cluster/forwarded_arguments.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::cluster {
namespace {

namespace fs = std::filesystem;

/// LiDAR squares are prepared once, into a cache folder that all nodes share; other worlds need no
/// preparation.
/// @param passed gets that folder
/// @return how many tasks prepare them
int find_squares(const SlurmOptions& options, const JobFolder& folder, ForwardedArguments& passed) {
    const worlds::WorldKind& kind = worlds::find_kind(passed.world.inputs.front());
    if (!kind.has_squares || passed.world.cache == "none")
        return 0;
    if (passed.world.cache.empty()) {
        passed.world.cache = (folder.path() / "cache").string();
        passed.add({"--cache", passed.world.cache});
    }
    if (!options.bake)
        return 0;
    constexpr int kTasksOfNode = 4;
    const int tasks = options.nodes * kTasksOfNode;
    if (&kind != &worlds::kLidarKind)
        return tasks;
    const auto files =
        pointcloud::expand_point_files({passed.world.inputs.begin(), passed.world.inputs.end()});
    return std::min(tasks, static_cast<int>(files.size()));
}

/// Checks what is rendered in parts, and gives them an output of their own.
/// @return arguments of `terravox merge` that join them
Command split_into_parts(const JobFolder& folder, ForwardedArguments& passed) {
    const std::vector<std::string> outputs = passed.outputs;
    passed.take({"-o", "--output"});
    Command joining = passed.take_of_whole_raster();
    for (const std::string& output : outputs)
        joining.insert(joining.end(), {"-o", output});
    Command again = passed.words;
    again.insert(again.end(), {"-o", outputs.front()});
    if (const ForwardedArguments read = ForwardedArguments::read(passed.command, again);
        read.outputs.size() != 1 || read.world.inputs != passed.world.inputs)
        throw util::UsageError(
            "cluster slurm --parts: the pictures cannot be distinguished from the other "
            "arguments; allowed: -o NAME for each, as words of their own");
    scene::Scene scene = passed.base_scene();
    // Checkpoints have no coarse passes, whatever the scene specifies.
    scene.quality.coarse_step = 1;
    farm::check_can_checkpoint(scene);
    // The parts' files of tiles are in the job's folder, not next to the picture.
    passed.outputs = {(folder.path() / "parts" / fs::path(outputs.front()).filename()).string()};
    passed.add({"-o", passed.outputs.front()});
    return joining;
}

std::string find_stem(const std::string& file) {
    return fs::path(file).stem().string();
}

}  // namespace

util::ExitCode run_slurm_pool(const SlurmOptions& options, const std::vector<std::string>& words) {
    const auto render =
        ForwardedArguments::read(options.analyse.empty() ? "render" : options.analyse, words);
    render.refuse({"--listen", "--token-file", "--tls-ca", "--tls-cert", "--tls-key"},
                  "cluster slurm",
                  "without it, each run has a token of its own; --port and --address of cluster "
                  "slurm say where it listens");
    const JobFolder folder(options, find_stem(render.outputs.front()));
    return run_pool(options, folder, render, render.base_scene().processing.threads);
}

util::ExitCode run_slurm_batch(const SlurmOptions& options, const std::vector<std::string>& words) {
    const bool in_parts = options.parts > 0;
    const std::string picture = options.analyse.empty() ? "render" : options.analyse;
    ForwardedArguments passed = ForwardedArguments::read(in_parts ? picture : "animate", words);
    if (in_parts)
        passed.refuse({"--part", "--resume", "--listen", "--worker", "--json"},
                      "cluster slurm --parts", "without it, each part renders by itself");
    else
        passed.refuse({"--first", "--last", "--every", "--again", "--list"},
                      "cluster slurm --batch", "--frames of cluster slurm, before the animation");
    const JobFolder folder(options,
                           find_stem(in_parts ? passed.outputs.front() : passed.animation));
    Batch batch(options, folder);
    if (options.needs.cpus > 0 && !passed.base_scene().processing.threads)
        passed.add({"--threads", std::to_string(options.needs.cpus)});
    batch.set_bake_tasks(find_squares(options, folder, passed));
    if (!in_parts)
        return batch.run_frames(passed);
    const Command joining = split_into_parts(folder, passed);
    return batch.run_parts(passed, joining);
}

}  // namespace terravox::cluster
