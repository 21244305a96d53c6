#include "raytracer/apps/commands/cluster/cluster_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "common/util/atomic_file.hpp"
#include "common/voxel/analysis.hpp"
#include "raytracer/apps/commands/cluster/forwarded_arguments.hpp"
#include "raytracer/core/animate/animation.hpp"
#include "raytracer/core/animate/video.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;
using namespace cluster;

struct Arguments {
    Place place;
    PoolJob pool{.name = "terravox", .render = {}};
    fs::path program;     ///< empty: the engine's usual one
    std::string analyse;  ///< kind of an analysis; empty: a picture
    bool dry_run = false;
    // Independent tasks:
    bool batch = false;
    bool bake = true;
    std::string frames;       ///< "A-B"; empty: all
    int frames_per_task = 0;  ///< 0: usual_per_task
    int parts = 0;            ///< 0: none
    // Of `bake`:
    std::string bake_for = "render";
    std::string bake_part = "1/1";
};

/// The words after the options of the cluster, which end at the first word that is no option.
std::vector<std::string> list_words(const CLI::App& command) {
    std::vector<std::string> out = command.remaining();
    if (!out.empty() && out.front() == "--")
        out.erase(out.begin());
    return out;
}

/// Refuses those of the options that are given.
/// @param reason "without --batch; allowed: with it"
void refuse_options(const CLI::App& command, const std::vector<std::string>& names,
                    const std::string& reason) {
    for (const std::string& name : names)
        if (command.count(name) > 0)
            throw util::UsageError("cluster " + command.get_name() + ": " + name + " " + reason);
}

/// One picture or analysis by workers.
ForwardedArguments read_picture(const Arguments& args, const std::vector<std::string>& words) {
    return ForwardedArguments::read(args.analyse.empty() ? "render" : args.analyse, words);
}

std::optional<int> find_cpus(const Arguments& args) {
    const int cpus = args.place.needs.cpus;
    return cpus > 0 ? std::optional(cpus) : std::nullopt;
}

/// @throws UsageError
ArrayJob make_frames(const Arguments& args, const Engine& engine, ForwardedArguments passed) {
    FrameJob job{
        .name = args.pool.name, .animate = {}, .pattern = passed.outputs.front(), .frames = {}};
    job.video = passed.video;
    // With --frames the animation need not exist on a machine that is none of the cluster.
    const bool reads_animation = engine.runs_here || args.frames.empty();
    const util::IntRange all{0,
                             (reads_animation ? animate::Animation::read(passed.animation).frames()
                                              : animate::Animation::kMaxFrames) -
                                 1};
    job.frames =
        args.frames.empty() ? all : util::parse_range("cluster: --frames", args.frames, all);
    if (!job.video.empty() && !args.frames.empty())
        throw util::UsageError(
            "cluster: --frames with --video; allowed: all frames, which a video is made of");
    if (!job.video.empty() && engine.runs_here)
        animate::check_video(job.video, animate::FrameNames(job.pattern));
    job.per_task = args.frames_per_task > 0 ? args.frames_per_task
                                            : usual_per_task(job.frames.count(), args.place.nodes);
    passed.take({"--video"});
    job.animate = passed.with_program(engine.find_program(args.program));
    return array_of_frames(job, engine);
}

ForwardedArguments read_frames(const std::vector<std::string>& words) {
    ForwardedArguments out = ForwardedArguments::read("animate", words);
    out.refuse({"--first", "--last", "--every", "--again", "--list"},
               "--frames of cluster, before the animation");
    return out;
}

/// Checks what is rendered in parts, and gives them an output of their own: files of tiles in the
/// job's folder, not next to the picture.
ArrayJob make_parts(const Arguments& args, ForwardedArguments passed) {
    const std::string picture = passed.outputs.front();
    const std::string output = args.place.folder / "parts" / fs::path(picture).filename();
    Command files = passed.take({"-o", "--output"});
    if (passed.command != "render")  // made of the whole raster
        files = extend(passed.take({"--report", "--map", "--objects", "--polygons"}), files);
    if (const auto read =
            ForwardedArguments::read(passed.command, extend(passed.words, {"-o", picture}));
        read.outputs.size() != 1 || read.world.inputs != passed.world.inputs)
        throw util::UsageError(
            "cluster slurm --parts: the pictures cannot be distinguished from the other "
            "arguments; allowed: -o NAME for each, as words of their own");
    scene::Scene scene = passed.base_scene();
    // Checkpoints have no coarse passes, whatever the scene specifies.
    scene.quality.coarse_step = 1;
    farm::check_can_checkpoint(scene);
    passed.add({"-o", output});
    const Engine& slurm = kEngines[kSlurm];
    return array_of_parts(passed.with_program(slurm.find_program(args.program)), output, args.parts,
                          files, slurm);
}

/// LiDAR squares are prepared once, into a cache folder that all nodes share; other worlds need no
/// preparation.
/// @param passed gets that folder
/// @return how many tasks prepare them
int count_bakers(const Arguments& args, ForwardedArguments& passed) {
    const worlds::WorldKind& kind = worlds::find_kind(passed.world.inputs.front());
    if (!kind.has_squares || passed.world.cache == "none")
        return 0;
    if (passed.world.cache.empty())
        passed.add({"--cache", (args.place.folder / "cache").string()});
    constexpr int kMost = 1000;  // numbers of one array
    return args.bake ? std::min(kMost, args.place.nodes) : 0;
}

/// Chooses the folder of a job.
/// @param file picture or animation: its name is the folder's if none was given
void choose_folder(Arguments& args, const std::string& file) {
    fs::path& folder = args.place.folder;
    if (folder.empty())
        folder = fs::path("jobs") / fs::path(file).stem();
    folder = fs::absolute(folder).lexically_normal();
    // Slurm reads % and \\ in the folder of a job as a pattern for the names of logs, and then
    // finds no logs/.
    if (folder.string().find_first_of("%\\") != std::string::npos)
        throw util::UsageError(
            "cluster: the job's folder " + folder.string() +
            "; allowed: a path without % and \\, which Slurm takes for patterns (--folder)");
    args.place.work = fs::current_path();
    args.place.needs.check();
}

JobFiles make_slurm_batch(Arguments& args, const std::vector<std::string>& words) {
    const Engine& engine = kEngines[kSlurm];
    ForwardedArguments passed = args.parts > 0 ? read_picture(args, words) : read_frames(words);
    if (args.parts > 0)
        passed.refuse({"--part", "--resume", "--listen", "--worker", "--json"},
                      "without it, each part renders by itself");
    choose_folder(args, args.parts > 0 ? passed.outputs.front() : passed.animation);
    passed.add_threads(find_cpus(args), engine);
    const int bakers = count_bakers(args, passed);
    ArrayJob job = args.parts > 0 ? make_parts(args, passed) : make_frames(args, engine, passed);
    job.bakers = bakers;
    if (bakers > 0)
        job.bake = fill("scripts/bake.sh", {{"words", passed.words},
                                            {"program", engine.find_program(args.program)},
                                            {"kind", passed.command},
                                            {"tasks", bakers},
                                            {"task", engine.number()}});
    return engine.make_array(job, args.place);
}

JobFiles make_slurm_pool(Arguments& args, const std::vector<std::string>& words) {
    const Engine& engine = kEngines[kSlurm];
    ForwardedArguments passed = read_picture(args, words);
    passed.refuse({"--listen", "--token-file", "--tls-ca", "--tls-cert", "--tls-key"},
                  "without it, each run has a token of its own; --port and --address of cluster "
                  "slurm say where it listens");
    choose_folder(args, passed.outputs.front());
    PoolJob& job = args.pool;
    // The submitting machine does not render unless its user requests it.
    const auto threads =
        passed.add_threads(job.has_coordinator_job ? find_cpus(args) : std::optional(0), engine);
    job.renders = job.has_coordinator_job || threads.value_or(0) > 0;
    job.render = passed.with_program(engine.find_program(args.program));
    return engine.make_pool(job, args.place);
}

util::ExitCode run_slurm(Arguments& args, const CLI::App& command) {
    const std::vector<std::string> words = list_words(command);
    if (args.batch)
        refuse_options(command, {"--coordinator", "--port", "--address"},
                       "with --batch; allowed: without it");
    else
        refuse_options(command,
                       {"--parts", "--frames", "--frames-per-task", "--no-bake", "--no-wait"},
                       "without --batch; allowed: with it");
    if (args.parts > 0)
        refuse_options(command, {"--frames", "--frames-per-task"},
                       "with --parts; allowed: one of them");
    else if (args.batch)
        refuse_options(command, {"--analyse"}, "and --batch without --parts; allowed: with it");
    const JobFiles made = args.batch ? make_slurm_batch(args, words) : make_slurm_pool(args, words);
    const fs::path& folder = args.place.folder;
    made.write_scripts(folder);
    const std::string submit = (folder / "submit.sh").string();
    util::write_file_atomically(submit, made.start);
    if (args.dry_run) {
        std::printf("bash %s\n", util::shell_word(submit).c_str());
        return util::ExitCode::kDone;
    }
    ::execl("/bin/bash", "bash", submit.c_str(), nullptr);
    throw util::Error("run {}: cannot start /bin/bash: {}", submit, std::strerror(errno));
}

/// Prints a job for frames of an animation.
util::ExitCode print_frames(Arguments& args, const Engine& engine,
                            const std::vector<std::string>& words) {
    args.place.work = fs::current_path();
    ForwardedArguments passed = read_frames(words);
    passed.add_threads(find_cpus(args), engine);
    const ArrayJob job = make_frames(args, engine, passed);
    std::fputs(engine.make_array(job, args.place).start.c_str(), stdout);
    return util::ExitCode::kDone;
}

util::ExitCode run_kubernetes(Arguments& args, const CLI::App& command) {
    const Engine& engine = kEngines[kKubernetes];
    // A pod without resource requests is the first to be evicted.
    Needs& needs = args.place.needs;
    if (needs.cpus == 0)
        needs.cpus = 4;
    if (needs.memory_mib == 0)
        needs.memory_mib = 8192;
    if (args.batch) {
        refuse_options(command, {"--analyse"}, "with --batch; allowed: without it, by workers");
        return print_frames(args, engine, list_words(command));
    }
    refuse_options(command, {"--frames", "--frames-per-task"}, "without --batch; allowed: with it");
    ForwardedArguments passed = read_picture(args, list_words(command));
    passed.refuse({"--listen"}, "without it, the service has a port of its own");
    passed.add_threads(needs.cpus, engine);
    args.pool.render = passed.with_program(engine.find_program(args.program));
    std::fputs(engine.make_pool(args.pool, args.place).start.c_str(), stdout);
    return util::ExitCode::kDone;
}

/// @param name of the subcommand
/// @param footer which arguments follow its own
CLI::App& add_subcommand(CLI::App& cluster, const char* name, const char* about,
                         const char* footer) {
    CLI::App* const command = cluster.add_subcommand(name, about);
    command->prefix_command();
    command->footer(footer);
    return *command;
}

/// @param usual_program help for --program: which one is the default
void add_needs(CLI::App& command, Arguments& args, const std::string& usual_program) {
    command.add_option("--nodes", args.place.nodes, "number of nodes that run at the same time")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command
        .add_option("--cpus-per-node", args.place.needs.cpus,
                    "processors of each; default: all of the machine")
        ->check(CLI::Range(1, 1024));
    command
        .add_option("--memory-mib", args.place.needs.memory_mib,
                    "memory of each, MiB; default: all of the machine, or what the cluster gives")
        ->check(CLI::Range(256, 1 << 24));
    command.add_option("--program", args.program,
                       "terravox-raytracer, where the machines find it; default: " + usual_program);
}

void add_frames(CLI::App& command, Arguments& args) {
    command.add_option("--frames", args.frames,
                       "A-B, inclusive; as in animate the first frame is 0; default: all");
    command
        .add_option("--frames-per-task", args.frames_per_task,
                    "should take half a minute or more; default: about 8 tasks for each machine")
        ->check(CLI::Range(1, 1'000'000));
}

void add_analyse(CLI::App& command, Arguments& args) {
    command
        .add_option("--analyse", args.analyse,
                    "an analysis instead of a picture: its kind; the arguments that follow are "
                    "those of `terravox analyse KIND`")
        ->check(CLI::IsMember(voxel::list_analyses()));
}

const CLI::App* add_slurm(CLI::App& cluster, Arguments& args) {
    CLI::App& command = add_subcommand(
        cluster, "slurm",
        "Render on a Slurm cluster: one picture or analysis by workers, or many frames (--batch), "
        "or parts of a picture or analysis (--batch --parts)",
        "Then the arguments of `terravox render`, which begin with the world; with --batch those "
        "of `terravox animate`, which begin with the animation; with --analyse KIND those of "
        "`terravox analyse KIND`.\n"
        "The job's folder, the program and all paths must be the same on all nodes.");
    Place& place = args.place;
    add_analyse(command, args);
    add_needs(command, args, "this one");
    add_sbatch_options(command, place.needs);
    command.add_option("--folder", place.folder,
                       "for scripts and logs; default: jobs/NAME of the picture or animation");
    command.add_option("--poll", place.poll_s, "seconds between queries of the queue")
        ->check(CLI::Range(1, 3600))
        ->capture_default_str();
    command.add_flag("--dry-run", args.dry_run, "write the scripts, and say how to submit them");
    command.add_flag("--cluster-quiet", place.quiet, "say nothing of jobs and queue but errors");
    command.option_defaults()->group("One picture by workers");
    command
        .add_option_function<std::string>(
            "--coordinator",
            [&args](const std::string& where) { args.pool.has_coordinator_job = where == "job"; },
            "here: a process of this machine; job: of a node")
        ->check(CLI::IsMember({"here", "job"}))
        ->type_name("here|job");
    command.add_option("--address", args.pool.address,
                       "address at which nodes reach the coordinator; default: its host name");
    command.add_option("--port", args.pool.port, "of the coordinator; default: a free one")
        ->check(CLI::Range(1, 65535));
    command.option_defaults()->group("Independent tasks");
    command.add_flag("--batch", args.batch, "frames of an animation: only those that are not done");
    command
        .add_option("--parts", args.parts,
                    "with --batch: one picture or analysis in so many parts, joined at the end")
        ->check(CLI::Range(2, 65536));
    command.add_flag_callback(
        "--no-bake", [&args] { args.bake = false; }, "do not prepare LiDAR squares first");
    command.add_flag_callback(
        "--no-wait", [&args] { args.place.waits = false; }, "submit and return");
    add_frames(command, args);
    return &command;
}

const CLI::App* add_openjd(CLI::App& cluster, Arguments& args) {
    CLI::App& command = add_subcommand(
        cluster, "openjd",
        "Write a job template of Open Job Description for the frames of an animation to standard "
        "output",
        "Then the arguments of `terravox animate`, which begin with the animation. `openjd run "
        "job.json` runs it on this machine.\n"
        "Relative paths begin in the folder that this is called in, which all machines share.");
    add_needs(command, args, "that of the PATH");
    add_frames(command, args);
    command.add_option("--name", args.pool.name, "of the job")->capture_default_str();
    return &command;
}

const CLI::App* add_kubernetes(CLI::App& cluster, Arguments& args) {
    CLI::App& command = add_subcommand(
        cluster, "kubernetes",
        "Write manifests for Kubernetes to standard output: one picture or analysis by workers, or "
        "many frames (--batch)",
        "Then the arguments of `terravox render`, or with --batch those of `terravox animate`, or "
        "with --analyse KIND those of `terravox analyse KIND`; their paths are those in the pods.\n"
        "Workers know each other by the Secret NAME-token, key `token`: config/cluster/README.md.");
    add_analyse(command, args);
    add_needs(command, args, "that of the PATH");
    add_frames(command, args);
    command.add_option("--name", args.pool.name, "of what is made")->capture_default_str();
    add_pod_options(command, args.place.pods);
    for (const char* name : {"--image", "--claim"})
        command.get_option(name)->required();
    command.add_flag("--batch", args.batch, "frames of an animation");
    return &command;
}

const CLI::App* add_bake(CLI::App& cluster, Arguments& args) {
    CLI::App& command = add_subcommand(
        cluster, "bake",
        "Prepare LiDAR squares into a cache folder that machines share (--cache among the "
        "arguments)",
        "Then the arguments of `terravox render`, `terravox animate` or `terravox analyse KIND`. "
        "`cluster slurm --batch` calls this by itself.");
    std::vector<std::string> bakers = {"render", "animate"};
    const std::vector<std::string> analyses = voxel::list_analyses();
    bakers.insert(bakers.end(), analyses.begin(), analyses.end());
    command.add_option("--for", args.bake_for, "whose arguments follow")
        ->check(CLI::IsMember(bakers))
        ->capture_default_str();
    command.add_option("--part", args.bake_part, "I/N: every N-th square from the I-th on")
        ->capture_default_str();
    return &command;
}

}  // namespace

void add_sbatch_options(CLI::App& command, Needs& needs) {
    command.add_option("--partition", needs.partition, "of Slurm; default: its own");
    command.add_option("--time", needs.time, "limit of each job, as sbatch takes it: 4:00:00");
    command
        .add_option(
            "--sbatch", needs.extra,
            "further options for sbatch: \"--account=film --qos=low\"; may be given several times")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
}

void add_pod_options(CLI::App& command, PodPlace& pods) {
    command.add_option("--image", pods.image, "container image of pods, with terravox-raytracer");
    command.add_option("--claim", pods.claim,
                       "persistent volume claim of pods, with data and results (ReadWriteMany)");
    command
        .add_option("--mount", pods.mount,
                    "where it is in the pods; relative paths begin there, so that all data must be "
                    "named by such")
        ->capture_default_str();
}

std::function<util::ExitCode()> add_cluster_command(CLI::App& app) {
    auto args = std::make_shared<Arguments>();
    args->place.waits = true;
    CLI::App* group = app.add_subcommand(
        "cluster",
        "Render on many machines through a scheduler: Slurm, Open Job Description, Kubernetes");
    group->require_subcommand(1);
    const CLI::App *slurm = add_slurm(*group, *args), *openjd = add_openjd(*group, *args),
                   *kubernetes = add_kubernetes(*group, *args), *bake = add_bake(*group, *args);
    return [=] {
        if (slurm->parsed())
            return run_slurm(*args, *slurm);
        if (openjd->parsed())
            return print_frames(*args, kEngines[kOpenJd], list_words(*openjd));
        if (kubernetes->parsed())
            return run_kubernetes(*args, *kubernetes);
        return prepare_squares(args->bake_for, args->bake_part, list_words(*bake));
    };
}

}  // namespace terravox::commands
