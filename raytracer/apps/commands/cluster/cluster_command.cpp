#include "raytracer/apps/commands/cluster/cluster_command.hpp"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "common/voxel/analysis.hpp"
#include "raytracer/apps/commands/cluster/forwarded_arguments.hpp"
#include "raytracer/core/animate/animation.hpp"
#include "raytracer/core/animate/video.hpp"
#include "raytracer/farm/cluster/engines.hpp"

namespace terravox::commands {
namespace {

using namespace cluster;

struct Arguments {
    SlurmOptions slurm;
    PodPlace pods;
    std::string name = "terravox";
    std::string bake_for = "render";
    std::string bake_part = "1/1";

    /// Where machines that are not this one's cluster find it.
    [[nodiscard]] std::string program() const {
        return slurm.program.empty() ? "terravox-raytracer" : slurm.program.string();
    }
};

/// The words after the options of the cluster, which end at the first word that is no option.
std::vector<std::string> list_words(const CLI::App& command) {
    std::vector<std::string> out = command.remaining();
    if (!out.empty() && out.front() == "--")
        out.erase(out.begin());
    return out;
}

void add_needs(CLI::App& command, Arguments& args) {
    command.add_option("--nodes", args.slurm.nodes, "number of nodes that run at the same time")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command
        .add_option("--cpus-per-node", args.slurm.needs.cpus,
                    "processors of each; default: all of the machine")
        ->check(CLI::Range(1, 1024));
    command
        .add_option("--memory-mib", args.slurm.needs.memory_mib,
                    "memory of each, MiB; default: all of the machine, or what the cluster gives")
        ->check(CLI::Range(256, 1 << 24));
    command.add_option("--program", args.slurm.program,
                       "terravox-raytracer, where the machines find it; default: this one");
}

void add_frames(CLI::App& command, Arguments& args) {
    command.add_option("--frames", args.slurm.frames,
                       "A-B, inclusive; as in animate the first frame is 0; default: all");
    command
        .add_option("--frames-per-task", args.slurm.frames_per_task,
                    "should take half a minute or more; default: about 8 tasks for each machine")
        ->check(CLI::Range(1, 1'000'000));
}

/// @throws UsageError
FrameJob frame_job(const Arguments& args, const std::vector<std::string>& words) {
    ForwardedArguments passed = ForwardedArguments::read("animate", words);
    passed.refuse({"--first", "--last", "--every", "--again", "--list"}, "cluster",
                  "--frames of cluster, before the animation");
    FrameJob job;
    job.name = args.name;
    job.pattern = passed.outputs.front();
    job.video = passed.video;
    (void)animate::FrameNames(job.pattern);
    const util::IntRange all{0, animate::Animation::kMaxFrames - 1};
    // With --frames the animation need not exist on this machine.
    job.plan.frames =
        args.slurm.frames.empty()
            ? util::IntRange{0, animate::Animation::read(passed.animation).frames() - 1}
            : util::parse_range("cluster: --frames", args.slurm.frames, all);
    if (!job.video.empty() && !args.slurm.frames.empty())
        throw util::UsageError(
            "cluster: --frames with --video; allowed: all frames, which a video is made of");
    job.plan.per_task = args.slurm.frames_per_task > 0
                            ? args.slurm.frames_per_task
                            : usual_per_task(job.plan.frames.count(), args.slurm.nodes);
    passed.take({"--video"});
    if (args.slurm.needs.cpus > 0 && !passed.has("--threads"))
        passed.add({"--threads", std::to_string(args.slurm.needs.cpus)});
    job.animate = passed.with_program(args.program());
    job.cpus = args.slurm.needs.cpus;
    job.memory_mib = args.slurm.needs.memory_mib;
    return job;
}

/// Options of the jobs that sbatch submits.
void add_slurm_jobs(CLI::App& command, Arguments& args) {
    command.add_option("--partition", args.slurm.needs.partition,
                       "of the cluster; default: its own");
    command.add_option("--time", args.slurm.needs.time,
                       "limit of each job, as sbatch takes it: 4:00:00");
    command
        .add_option(
            "--sbatch", args.slurm.needs.extra,
            "further options for sbatch: \"--account=film --qos=low\"; may be given several times")
        ->expected(1)
        ->take_all()
        ->allow_extra_args(false);
    command.add_option("--folder", args.slurm.folder,
                       "for scripts and logs; default: jobs/NAME of the picture or animation");
    command.add_option("--poll", args.slurm.poll_s, "seconds between queries of the queue")
        ->check(CLI::Range(1, 3600))
        ->capture_default_str();
    command.add_flag("--dry-run", args.slurm.dry_run,
                     "write the scripts and say what would be submitted");
    command.add_flag("--cluster-quiet", args.slurm.quiet,
                     "say nothing of jobs and queue but errors");
}

/// Options for one picture by a coordinator and workers.
void add_slurm_pool(CLI::App& command, Arguments& args) {
    command.option_defaults()->group("One picture by workers");
    command
        .add_option_function<std::string>(
            "--coordinator",
            [&args](const std::string& where) { args.slurm.coordinator_in_job = where == "job"; },
            "here: a process of this machine; job: of a node")
        ->check(CLI::IsMember({"here", "job"}))
        ->type_name("here|job");
    command.add_option("--address", args.slurm.address,
                       "address at which nodes reach the coordinator; default: its host name");
    command.add_option("--port", args.slurm.port, "of the coordinator; default: a free one")
        ->check(CLI::Range(1, 65535));
}

void add_analyse(CLI::App& command, Arguments& args) {
    command
        .add_option("--analyse", args.slurm.analyse,
                    "an analysis instead of a picture: its kind; the arguments that follow are "
                    "those of `terravox analyse KIND`")
        ->check(CLI::IsMember(voxel::list_analyses()));
}

/// Options for independent tasks: frames of an animation, or parts of a picture.
void add_slurm_batch(CLI::App& command, Arguments& args) {
    command.option_defaults()->group("Independent tasks");
    command.add_flag("--batch", args.slurm.batch,
                     "frames of an animation: only those that are not done");
    command
        .add_option("--parts", args.slurm.parts,
                    "with --batch: one picture or analysis in so many parts, joined at the end")
        ->check(CLI::Range(2, 65536));
    command.add_flag_callback(
        "--no-bake", [&args] { args.slurm.bake = false; }, "do not prepare LiDAR squares first");
    command.add_flag_callback(
        "--no-wait", [&args] { args.slurm.wait = false; }, "submit and return");
    add_frames(command, args);
}

CLI::App* add_slurm(CLI::App& cluster, Arguments& args) {
    CLI::App* command =
        cluster.add_subcommand("slurm",
                               "Render on a Slurm cluster: one picture or analysis by workers, or "
                               "many frames (--batch), or parts of a picture or analysis (--batch "
                               "--parts)");
    command->prefix_command();
    command->footer(
        "Then the arguments of `terravox render`, which begin with the world; with --batch those "
        "of `terravox animate`, which begin with the animation; with --analyse KIND those of "
        "`terravox analyse KIND`.\n"
        "The job's folder, the program and all paths must be the same on all nodes.");
    add_analyse(*command, args);
    add_needs(*command, args);
    add_slurm_jobs(*command, args);
    add_slurm_pool(*command, args);
    add_slurm_batch(*command, args);
    return command;
}

util::ExitCode run_slurm(const Arguments& args, const std::vector<std::string>& words) {
    const SlurmOptions& o = args.slurm;
    if (!o.batch &&
        (o.parts > 0 || !o.frames.empty() || o.frames_per_task > 0 || !o.bake || !o.wait))
        throw util::UsageError(
            "cluster slurm: --parts, --frames, --frames-per-task, --no-bake or --no-wait without "
            "--batch; allowed: with it");
    if (o.batch && (o.coordinator_in_job || o.port > 0 || !o.address.empty()))
        throw util::UsageError(
            "cluster slurm: --coordinator, --port or --address with --batch; allowed: without it");
    if (o.parts > 0 && (!o.frames.empty() || o.frames_per_task > 0))
        throw util::UsageError(
            "cluster slurm: --parts with --frames or --frames-per-task; allowed: one of them");
    if (!o.analyse.empty() && o.batch && o.parts == 0)
        throw util::UsageError(
            "cluster slurm: --analyse and --batch without --parts; allowed: with it");
    return o.batch ? run_slurm_batch(o, words) : run_slurm_pool(o, words);
}

CLI::App* add_openjd(CLI::App& cluster, Arguments& args) {
    CLI::App* command = cluster.add_subcommand("openjd",
                                               "Write a job template of Open Job Description for "
                                               "the frames of an animation to standard output");
    command->prefix_command();
    command->footer(
        "Then the arguments of `terravox animate`, which begin with the animation. `openjd run "
        "job.json` runs it on this machine.\n"
        "Relative paths begin in the folder that this is called in, which all machines share.");
    add_needs(*command, args);
    add_frames(*command, args);
    command->add_option("--name", args.name, "of the job")->capture_default_str();
    return command;
}

util::ExitCode print_frames(const Arguments& args, const Engine& engine,
                            const std::vector<std::string>& words) {
    Place place;
    place.pods = args.pods;
    // Tasks of OpenJD start in a folder of their session.
    place.work = std::filesystem::current_path();
    place.nodes = args.slurm.nodes;
    const ArrayJob frames = array_of_frames(frame_job(args, words));
    std::fputs(engine.make_array(frames, place).start.c_str(), stdout);
    return util::ExitCode::kDone;
}

CLI::App* add_kubernetes(CLI::App& cluster, Arguments& args) {
    CLI::App* command = cluster.add_subcommand("kubernetes",
                                               "Write manifests for Kubernetes to standard output: "
                                               "one picture or analysis by workers, or many frames "
                                               "(--batch)");
    command->prefix_command();
    command->footer(
        "Then the arguments of `terravox render`, or with --batch those of `terravox animate`, or "
        "with --analyse KIND those of `terravox analyse KIND`; their paths are those in the pods.\n"
        "Workers know each other by the Secret NAME-token, key `token`: config/cluster/README.md.");
    add_analyse(*command, args);
    add_needs(*command, args);
    add_frames(*command, args);
    command->add_option("--name", args.name, "of what is made")->capture_default_str();
    command->add_option("--image", args.pods.image, "container image with terravox-raytracer")
        ->required();
    command
        ->add_option("--claim", args.pods.claim,
                     "persistent volume claim with worlds and pictures (ReadWriteMany)")
        ->required();
    command
        ->add_option("--mount", args.pods.mount,
                     "where it is in the pods; relative paths begin there")
        ->capture_default_str();
    command->add_flag("--batch", args.slurm.batch, "frames of an animation");
    return command;
}

util::ExitCode run_kubernetes(Arguments args, const std::vector<std::string>& words) {
    // A pod without resource requests is the first to be evicted.
    if (args.slurm.needs.cpus == 0)
        args.slurm.needs.cpus = 4;
    if (args.slurm.needs.memory_mib == 0)
        args.slurm.needs.memory_mib = 8192;
    if (!args.slurm.analyse.empty() && args.slurm.batch)
        throw util::UsageError(
            "cluster kubernetes: --analyse with --batch; allowed: without it, by workers");
    if (args.slurm.batch)
        return print_frames(args, kEngines[kKubernetes], words);
    if (!args.slurm.frames.empty() || args.slurm.frames_per_task > 0)
        throw util::UsageError(
            "cluster kubernetes: --frames or --frames-per-task without --batch; allowed: with it");
    auto passed =
        ForwardedArguments::read(args.slurm.analyse.empty() ? "render" : args.slurm.analyse, words);
    passed.refuse({"--listen"}, "cluster kubernetes",
                  "without it, the service has a port of its own");
    if (!passed.has("--threads"))
        passed.add({"--threads", std::to_string(args.slurm.needs.cpus)});
    Place place;
    place.pods = args.pods;
    place.needs = args.slurm.needs;
    place.nodes = args.slurm.nodes;
    std::fputs(kubernetes_pool(args.name, passed.with_program(args.program()), place).c_str(),
               stdout);
    return util::ExitCode::kDone;
}

CLI::App* add_bake(CLI::App& cluster, Arguments& args) {
    CLI::App* command = cluster.add_subcommand("bake",
                                               "Prepare LiDAR squares into a cache folder that "
                                               "machines share (--cache among the arguments)");
    command->prefix_command();
    command->footer(
        "Then the arguments of `terravox render`, `terravox animate` or `terravox analyse KIND`. "
        "`cluster slurm --batch` "
        "calls this by itself.");
    std::vector<std::string> bakers = {"render", "animate"};
    const std::vector<std::string> analyses = voxel::list_analyses();
    bakers.insert(bakers.end(), analyses.begin(), analyses.end());
    command->add_option("--for", args.bake_for, "whose arguments follow")
        ->check(CLI::IsMember(bakers))
        ->capture_default_str();
    command->add_option("--part", args.bake_part, "I/N: every N-th square from the I-th on")
        ->capture_default_str();
    return command;
}

}  // namespace

std::function<util::ExitCode()> add_cluster_command(CLI::App& app) {
    auto args = std::make_shared<Arguments>();
    CLI::App* group = app.add_subcommand(
        "cluster",
        "Render on many machines through a scheduler: Slurm, Open Job Description, Kubernetes");
    group->require_subcommand(1);
    const CLI::App *slurm = add_slurm(*group, *args), *openjd = add_openjd(*group, *args),
                   *kubernetes = add_kubernetes(*group, *args), *bake = add_bake(*group, *args);
    return [=] {
        if (slurm->parsed())
            return run_slurm(*args, list_words(*slurm));
        if (openjd->parsed())
            return print_frames(*args, kEngines[kOpenJd], list_words(*openjd));
        if (kubernetes->parsed())
            return run_kubernetes(*args, list_words(*kubernetes));
        return prepare_squares(args->bake_for, args->bake_part, list_words(*bake));
    };
}

}  // namespace terravox::commands
