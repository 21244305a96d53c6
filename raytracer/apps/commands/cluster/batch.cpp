#include "raytracer/apps/commands/cluster/batch.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>

#include "common/thread/stop.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/animate/animation.hpp"
#include "raytracer/core/animate/video.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"
#include "voxelserver/data/pointcloud/formats/files.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::cluster {
Submission::Submission(const SlurmOptions& options, const JobFolder& folder, const Slurm* slurm)
    : m_options(options), m_folder(folder), m_slurm(slurm) {
    std::ifstream in(file());
    for (std::string name, job; in >> name >> job;)
        m_before.push_back(job);
}

void Submission::wait_for_earlier() {
    if (m_slurm == nullptr || m_before.empty())
        return;
    const auto counts = m_slurm->counts(m_before);
    if (!counts)
        throw util::Error(std::string(kBatchAttempt) +
                          "squeue has no answer; without it, it is unknown whether the jobs of " +
                          file().string() + " are at work");
    if (counts->all() == 0)
        return;
    if (!m_options.wait)
        throw util::Error(std::string(kBatchAttempt) + std::to_string(counts->all()) +
                          " tasks of " + file().string() +
                          " are at work; wait for them, or scancel them");
    if (!m_options.quiet)
        std::fprintf(stderr, "slurm: %d tasks of an earlier call are at work\n", counts->all());
    follow(m_before, counts->all());
}

Slurm::JobId Submission::submit(const std::string& name, const std::vector<std::string>& options,
                                int tasks, const std::vector<std::string>& arguments) {
    m_tasks += tasks;
    if (m_slurm == nullptr) {
        if (m_tasks == tasks)
            std::printf("cd %s\n", util::shell_word(m_folder.path().string()).c_str());
        std::printf("sbatch");
        for (const std::string& option : options)
            std::printf(" %s", option.c_str());
        std::printf(" %s.sbatch", name.c_str());
        for (const std::string& argument : arguments)
            std::printf(" %s", argument.c_str());
        std::printf("\n");
        return name;
    }
    const Slurm::JobId job = m_slurm->submit(m_folder.path(), name + ".sbatch", options, arguments);
    m_jobs.push_back(job);
    m_text += name + " " + job + "\n";
    util::write_file_atomically(file(), m_text);
    if (!m_options.quiet)
        std::fprintf(stderr, "slurm: job %s: %s, %d tasks\n", job.c_str(), name.c_str(), tasks);
    return job;
}

void Submission::follow(const std::vector<Slurm::JobId>& jobs, int tasks) {
    const thread::StopSignals signals(
        thread::StopSignals::Options{{SIGINT, SIGTERM, SIGHUP}, false, {}});
    QueueReporter reporter(tasks, m_options.quiet);
    for (int empty_looks = 0; empty_looks < 2;) {
        const auto counts = m_slurm->counts(jobs);
        if (counts)
            reporter.report(*counts);
        empty_looks = counts && counts->all() == 0 ? empty_looks + 1 : 0;
        const std::chrono::seconds period(m_options.poll_s);
        if (empty_looks < 2 && thread::wait_for_stop(signals.token(), period)) {
            const std::string wrong = m_slurm->cancel(jobs);
            throw util::Error(std::string(kBatchAttempt) + "interrupted by a signal; " +
                              (wrong.empty() ? "all tasks are cancelled; the same command continues"
                                             : "cancel the tasks: " + wrong));
        }
    }
}

namespace fs = std::filesystem;

Batch::Batch(const SlurmOptions& options, ForwardedArguments passed)
    : m_options(options),
      m_passed(std::move(passed)),
      m_folder(options,
               fs::path(m_passed.animation.empty() ? m_passed.outputs.front() : m_passed.animation)
                   .stem()
                   .string()) {
    if (!options.dry_run)
        m_slurm.emplace();
    if (options.needs.cpus > 0 && !m_passed.base_scene().processing.threads)
        m_passed.words.insert(m_passed.words.end(),
                              {"--threads", std::to_string(options.needs.cpus)});
    find_squares();
}

int Batch::array_limit() const {
    constexpr int kAsSlurmComes = 1001;
    return m_slurm ? m_slurm->array_limit() : kAsSlurmComes;
}

Command Batch::command(const std::string& name) const {
    Command out{m_folder.place().program.string()};
    const std::vector<std::string> beginning = words_of_command(name);
    out.insert(out.end(), beginning.begin(), beginning.end());
    out.insert(out.end(), m_passed.words.begin(), m_passed.words.end());
    return out;
}

std::string Batch::submit_tasks(Submission& submission, const std::string& name,
                                const std::vector<int>& tasks) const {
    std::vector<std::string> wait = submit_bake(submission);
    std::string all;
    for (const ArrayPiece& piece : array_pieces(tasks, array_limit())) {
        std::vector<std::string> options{"--array=" + array_text(piece.indices) + "%" +
                                         std::to_string(m_options.nodes)};
        options.insert(options.end(), wait.begin(), wait.end());
        const Slurm::JobId job = submission.submit(
            name, options, static_cast<int>(piece.indices.size()), {std::to_string(piece.offset)});
        all += ":" + job;
        wait = {"--dependency=afterany:" + job};  // one array after another: --nodes applies to all
    }
    return all;
}

/// LiDAR squares are prepared once, into a cache folder that all nodes share; other worlds need no
/// preparation.
void Batch::find_squares() {
    const worlds::WorldKind& kind = worlds::find_kind(m_passed.world.inputs.front());
    if (!kind.has_squares || m_passed.world.cache == "none")
        return;
    if (m_passed.world.cache.empty()) {
        m_passed.world.cache = (m_folder.path() / "cache").string();
        m_passed.words.insert(m_passed.words.end(), {"--cache", m_passed.world.cache});
    }
    if (!m_options.bake)
        return;
    constexpr int kTasksOfNode = 4;
    m_bake_tasks = m_options.nodes * kTasksOfNode;
    if (&kind == &worlds::kLidarKind)
        m_bake_tasks =
            std::min(m_bake_tasks,
                     static_cast<int>(pointcloud::expand_point_files({m_passed.world.inputs.begin(),
                                                                      m_passed.world.inputs.end()})
                                          .size()));
}

/// @return an option of sbatch that lets a job wait for the squares; none when there is nothing to
/// prepare
std::vector<std::string> Batch::submit_bake(Submission& submission) const {
    if (m_bake_tasks == 0)
        return {};
    const int tasks = std::min(m_bake_tasks, array_limit());
    m_folder.write_script("bake.sbatch",
                          bake_script(m_folder.place(), m_passed.command, m_passed.words, tasks));
    // afterany: squares that could not be prepared are reported by the frames that need them.
    return {"--dependency=afterany:" + submission.submit("bake",
                                                         {"--array=0-" + std::to_string(tasks - 1) +
                                                          "%" + std::to_string(m_options.nodes)},
                                                         tasks)};
}

util::ExitCode run_batch(const SlurmOptions& options, const std::vector<std::string>& words) {
    if (options.parts > 0) {
        const std::string& command = options.analyse.empty() ? "render" : options.analyse;
        ForwardedArguments passed = ForwardedArguments::read(command, words);
        for (const char* own : {"--part", "--resume", "--listen", "--worker", "--json"})
            if (passed.has(own))
                throw util::UsageError(std::string("cluster slurm --parts: ") + own +
                                       " among the arguments of " + command +
                                       "; allowed: without it, each part "
                                       "renders by itself");
        return run_parts(options, std::move(passed));
    }
    ForwardedArguments passed = ForwardedArguments::read("animate", words);
    for (const char* own : {"--first", "--last", "--every", "--again", "--list"})
        if (passed.has(own))
            throw util::UsageError(
                std::string("cluster slurm --batch: ") + own +
                " among the arguments of animate; allowed: --frames of cluster slurm, "
                "before the animation");
    return run_frames(options, std::move(passed));
}

namespace {

/// Frames of an animation.
class FrameBatch : Batch {
public:
    FrameBatch(const SlurmOptions& options, ForwardedArguments passed)
        : Batch(options, std::move(passed)), m_names(m_passed.outputs.front()) {}

    util::ExitCode run() {
        plan();
        Submission submission(m_options, m_folder, slurm());
        submission.wait_for_earlier();
        const std::vector<int> missing = still_to_make();
        if (!m_options.quiet)
            std::fprintf(stderr, "%zu of %d frames are to be made\n", missing.size(),
                         m_plan.frames.count());
        if (missing.empty() && video_is_made())
            return util::ExitCode::kDone;
        std::map<int, fs::file_time_type> before;
        for (const int frame : missing)
            before[frame] = find_time(frame);
        submit(submission, missing);
        if (m_options.dry_run || !m_options.wait)
            return util::ExitCode::kDone;
        submission.follow();
        return look_at_the_end(before);
    }

private:
    void plan() {
        const animate::Animation animation = animate::Animation::read(m_passed.animation);
        const util::IntRange all{0, animation.frames() - 1};
        m_plan.frames = m_options.frames.empty()
                            ? all
                            : util::parse_range("cluster slurm: --frames", m_options.frames, all);
        m_plan.per_task = m_options.frames_per_task > 0
                              ? m_options.frames_per_task
                              : usual_per_task(m_plan.frames.count(), m_options.nodes);
        if (m_passed.video.empty())
            return;
        if (!(m_plan.frames == all))
            throw util::UsageError("cluster slurm: --frames " + m_options.frames +
                                   " with --video; allowed: all frames, which a video is made of");
        animate::check_video(m_passed.video, m_names);
        m_passed.take({"--video"});
    }

    /// Determined by `animate` itself, which knows what a frame depends on.
    [[nodiscard]] std::vector<int> still_to_make() const {
        Command list = command("animate");
        list.front() = util::beside_program("terravox-raytracer").string();
        list.insert(list.end(), {"--list", "--first", std::to_string(m_plan.frames.first), "--last",
                                 std::to_string(m_plan.frames.last)});
        const util::Finished done = util::run_to_end(list);
        if (done.status != 0) {
            std::string reason = done.reason();
            if (reason.starts_with("terravox: "))
                reason.erase(0, 10);
            if (done.status == static_cast<int>(util::ExitCode::kUsage))
                throw util::UsageError(reason);
            throw util::Error(reason);
        }
        std::vector<int> out;
        std::istringstream in(done.out);
        for (int frame = 0; in >> frame;)
            out.push_back(frame);
        return out;
    }

    void submit(Submission& submission, const std::vector<int>& missing) {
        std::vector<int> tasks;
        for (const int frame : missing)
            if (const int task = m_plan.find_task(frame); tasks.empty() || tasks.back() != task)
                tasks.push_back(task);
        m_folder.write_script("frames.sbatch",
                              frames_script(m_folder.place(), command("animate"), m_plan));
        Command video;
        if (!m_passed.video.empty()) {
            video = command("animate");
            video.insert(video.end(), {"--video", m_passed.video});
        }
        m_folder.write_script(
            "merge.sbatch",
            merge_frames_script(m_folder.place(), m_names.pattern(), m_plan.frames, video));

        std::vector<std::string> merge;
        if (!tasks.empty()) {
            const std::string all = submit_tasks(submission, "frames", tasks);
            merge = {"--dependency=afterok" + all, "--kill-on-invalid-dep=yes"};
        }
        m_merge = submission.submit("merge", merge, 1);
    }

    [[nodiscard]] fs::file_time_type find_time(int frame) const {
        std::error_code failed;
        const auto time = fs::last_write_time(m_names.of(frame), failed);
        return failed ? fs::file_time_type::min() : time;
    }

    /// Whether the video is up to date with the frames, or none is wanted.
    [[nodiscard]] bool video_is_made() const {
        if (m_passed.video.empty())
            return true;
        std::error_code failed;
        const auto made = fs::last_write_time(m_passed.video, failed);
        if (failed)
            return false;
        for (int frame = m_plan.frames.first; frame <= m_plan.frames.last; ++frame)
            if (find_time(frame) > made)
                return false;
        return true;
    }

    [[nodiscard]] util::ExitCode look_at_the_end(
        const std::map<int, fs::file_time_type>& before) const {
        const std::vector<int> missing = still_to_make();
        // A frame with holes is written, but counts as not done.
        const auto with_holes = std::count_if(missing.begin(), missing.end(), [&](int frame) {
            const auto was = before.find(frame);
            return was != before.end() && find_time(frame) != was->second;
        });
        if (static_cast<std::size_t>(with_holes) != missing.size())
            throw util::Error(
                kBatchAttempt +
                std::to_string(missing.size() - static_cast<std::size_t>(with_holes)) +
                " frames were not made, the first is " + std::to_string(missing.front()) +
                "; see " + logs() + "; the same command makes what is missing");
        if (with_holes > 0) {
            std::fprintf(stderr, "terravox: %td frames have holes; see %s\n", with_holes,
                         logs().c_str());
            return util::ExitCode::kHoles;
        }
        if (const auto code = slurm()->exit_code(m_merge); code && *code != 0)
            throw util::Error(
                kBatchAttempt +
                std::string("all frames are there, but the job after them failed; see ") + logs() +
                "/merge-" + m_merge + ".txt");
        if (!m_passed.video.empty() && !fs::exists(m_passed.video))
            throw util::Error(kBatchAttempt + std::string("there is no ") + m_passed.video +
                              "; see " + logs());
        if (!m_options.quiet)
            std::fprintf(stderr, "all %d frames are done\n", m_plan.frames.count());
        return util::ExitCode::kDone;
    }

    const animate::FrameNames m_names;
    TaskPlan m_plan;
    Slurm::JobId m_merge;
};

}  // namespace

util::ExitCode run_frames(const SlurmOptions& options, ForwardedArguments passed) {
    return FrameBatch(options, std::move(passed)).run();
}

namespace {

/// Parts of one picture.
class PartBatch : Batch {
public:
    PartBatch(const SlurmOptions& options, ForwardedArguments passed)
        : Batch(options, std::move(passed)) {}

    util::ExitCode run() {
        const std::vector<std::string> outputs = m_passed.outputs;
        m_passed.take({"-o", "--output"});
        Command joining = m_passed.take_of_whole_raster();
        for (const std::string& output : outputs)
            joining.insert(joining.end(), {"-o", output});
        auto again = m_passed.words;
        again.insert(again.end(), {"-o", outputs.front()});
        if (const ForwardedArguments read = ForwardedArguments::read(m_passed.command, again);
            read.outputs.size() != 1 || read.world.inputs != m_passed.world.inputs)
            throw util::UsageError(
                "cluster slurm --parts: the pictures cannot be distinguished from the other "
                "arguments; "
                "allowed: -o NAME for each, as words of their own");
        scene::Scene scene = m_passed.base_scene();
        // Checkpoints have no coarse passes, whatever the scene specifies.
        scene.quality.coarse_step = 1;
        farm::check_can_checkpoint(scene);
        // The parts' files of tiles are in the job's folder, not next to the picture.
        const fs::path picture = m_folder.path() / "parts" / fs::path(outputs.front()).filename();
        m_passed.words.insert(m_passed.words.end(), {"-o", picture.string()});
        Submission submission(m_options, m_folder, slurm());
        submission.wait_for_earlier();
        m_folder.write_script(
            "parts.sbatch",
            parts_script(m_folder.place(), command(m_passed.command), m_options.parts));
        m_folder.write_script("merge.sbatch", merge_parts_script(m_folder.place(), joining,
                                                                 m_options.parts, picture));

        std::vector<int> tasks(static_cast<std::size_t>(m_options.parts));
        std::iota(tasks.begin(), tasks.end(), 0);
        const std::string all = submit_tasks(submission, "parts", tasks);
        // afterany: merging itself detects missing tiles, and a part with holes is no failure.
        const Slurm::JobId merging = submission.submit("merge", {"--dependency=afterany" + all}, 1);
        if (m_options.dry_run || !m_options.wait)
            return util::ExitCode::kDone;
        submission.follow();
        const auto code = slurm()->exit_code(merging);
        if (!code)
            throw util::Error(
                kBatchAttempt +
                std::string("Slurm no longer reports how the parts were joined; see ") + logs() +
                "/merge-" + merging + ".txt");
        if (*code == static_cast<int>(util::ExitCode::kHoles))
            return util::ExitCode::kHoles;
        if (*code != 0)
            throw util::Error(kBatchAttempt + std::string("the parts were not joined; see ") +
                              logs() + "; the same command continues");
        return util::ExitCode::kDone;
    }
};

}  // namespace

util::ExitCode run_parts(const SlurmOptions& options, ForwardedArguments passed) {
    return PartBatch(options, std::move(passed)).run();
}

}  // namespace terravox::cluster
