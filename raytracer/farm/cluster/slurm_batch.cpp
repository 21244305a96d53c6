#include <signal.h>

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
#include "raytracer/farm/cluster/slurm_run.hpp"

namespace terravox::cluster {
namespace {

namespace fs = std::filesystem;

bool is_option(const std::string& word, const std::string& name) {
    return word == name || word.starts_with(name + "=") ||
           (name.size() == 2 && word.starts_with(name));
}

util::Error batch_error(const std::string& what) {
    return util::Error("run the batch: " + what);
}

/// The frames of an animation, and which of them are there.
class Frames {
public:
    Frames(const SlurmOptions& options, JobCommand& command)
        : m_command(command), m_names(command.outputs.front()) {
        const animate::Animation animation = animate::Animation::read(command.animation);
        const util::IntRange all{0, animation.frames() - 1};
        plan.frames = options.frames.empty()
                          ? all
                          : util::parse_range("cluster slurm: --frames", options.frames, all);
        plan.per_task = options.frames_per_task > 0
                            ? options.frames_per_task
                            : usual_per_task(plan.frames.count(), options.nodes);
        if (command.video.empty())
            return;
        if (!(plan.frames == all))
            throw util::UsageError("cluster slurm: --frames " + options.frames +
                                   " with --video; allowed: all frames, which a video is made of");
        animate::check_video(command.video, m_names);
        command.take({"--video"});
    }

    /// Determined by `animate` itself, which knows what a frame depends on.
    [[nodiscard]] std::vector<int> still_to_make() const {
        Command list = m_command.with_program(util::beside_program("terravox-raytracer").string());
        list.insert(list.end(), {"--list", "--first", std::to_string(plan.frames.first), "--last",
                                 std::to_string(plan.frames.last)});
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

    [[nodiscard]] fs::file_time_type find_time(int frame) const {
        std::error_code failed;
        const auto time = fs::last_write_time(m_names.of(frame), failed);
        return failed ? fs::file_time_type::min() : time;
    }

    /// Whether the video is up to date with the frames, or none is wanted.
    [[nodiscard]] bool video_is_made() const {
        if (m_command.video.empty())
            return true;
        std::error_code failed;
        const auto made = fs::last_write_time(m_command.video, failed);
        if (failed)
            return false;
        for (int frame = plan.frames.first; frame <= plan.frames.last; ++frame)
            if (find_time(frame) > made)
                return false;
        return true;
    }

    TaskPlan plan;

private:
    const JobCommand& m_command;
    const animate::FrameNames m_names;
};

}  // namespace

Command JobCommand::beginning() const {
    if (command == "render" || command == "animate")
        return {command};
    return {"analyse", command};
}

Command JobCommand::with_program(const std::string& program) const {
    Command out = beginning();
    out.insert(out.begin(), program);
    out.insert(out.end(), words.begin(), words.end());
    return out;
}

void JobCommand::take(const std::vector<std::string>& names) {
    for (auto it = words.begin(); it != words.end();) {
        const auto name = std::find_if(names.begin(), names.end(),
                                       [&](const std::string& n) { return is_option(*it, n); });
        if (name == names.end())
            ++it;
        else
            it = words.erase(it, std::min(words.end(), it + (*it == *name ? 2 : 1)));
    }
}

bool JobCommand::has(const std::string& name) const {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& word) { return is_option(word, name); });
}

Batch::Batch(const SlurmOptions& options, const JobFolder& folder)
    : m_options(options), m_folder(folder) {
    if (!options.dry_run)
        m_slurm.emplace();
    std::ifstream in(file());
    for (std::string name, job; in >> name >> job;)
        m_before.push_back(job);
}

/// Waits for jobs of an earlier call that have not ended.
void Batch::wait_for_earlier() const {
    if (!m_slurm || m_before.empty())
        return;
    const auto counts = m_slurm->counts(m_before);
    if (!counts)
        throw batch_error("squeue has no answer; without it, it is unknown whether the jobs of " +
                          file().string() + " are at work");
    if (counts->all() == 0)
        return;
    if (!m_options.wait)
        throw batch_error(std::to_string(counts->all()) + " tasks of " + file().string() +
                          " are at work; wait for them, or scancel them");
    if (!m_options.quiet)
        std::fprintf(stderr, "slurm: %d tasks of an earlier call are at work\n", counts->all());
    follow(m_before, counts->all());
}

/// @param name of the script, without .sbatch
/// @return the job's number; in a dry run its name
Slurm::JobId Batch::submit(const std::string& name, const std::vector<std::string>& options,
                           int tasks, const std::vector<std::string>& arguments) {
    m_tasks += tasks;
    if (!m_slurm) {
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

/// Submits an array that prepares LiDAR squares, and then `name`.sbatch for these tasks, as arrays
/// one after the other.
/// @return job numbers, ":1:2", for --dependency
std::string Batch::submit_tasks(const JobCommand& command, const std::string& name,
                                const std::vector<int>& tasks) {
    const int limit = m_slurm ? m_slurm->array_limit() : kEngines[kSlurm].array_limit;
    const std::string at_once = "%" + std::to_string(m_options.nodes);
    std::vector<std::string> wait;
    if (const int bakers = std::min(m_bake_tasks, limit); bakers > 0) {
        m_folder.write_script("bake", SlurmJob::kArray,
                              {"bake",
                               {{"words", command.words},
                                {"program", m_folder.program()},
                                {"kind", command.command},
                                {"tasks", bakers}}});
        // afterany: squares that could not be prepared are reported by the frames that need them.
        wait = {"--dependency=afterany:" +
                submit("bake", {"--array=0-" + std::to_string(bakers - 1) + at_once}, bakers)};
    }
    std::string all;
    for (const ArrayPiece& piece : array_pieces(tasks, limit)) {
        std::vector<std::string> options{"--array=" + array_text(piece.indices) + at_once};
        options.insert(options.end(), wait.begin(), wait.end());
        const Slurm::JobId job = submit(name, options, static_cast<int>(piece.indices.size()),
                                        {std::to_string(piece.offset)});
        all += ":" + job;
        wait = {"--dependency=afterany:" + job};  // one array after another: --nodes applies to all
    }
    return all;
}

/// Waits until none of the jobs is left in the queue.
/// @throws Error when a signal arrives: all jobs are cancelled
void Batch::follow(const std::vector<Slurm::JobId>& jobs, int tasks) const {
    const thread::StopSignals signals(
        thread::StopSignals::Options{{SIGINT, SIGTERM, SIGHUP}, false, {}});
    QueueWatch watch(*m_slurm, jobs, tasks, m_options.quiet);
    while (watch.look() < 2)
        if (thread::wait_for_stop(signals.token(), std::chrono::seconds(m_options.poll_s))) {
            const std::string wrong = m_slurm->cancel(jobs);
            throw batch_error("interrupted by a signal; " +
                              (wrong.empty() ? "all tasks are cancelled; the same command continues"
                                             : "cancel the tasks: " + wrong));
        }
}

util::ExitCode Batch::run_frames(JobCommand command) {
    const Frames frames(m_options, command);
    wait_for_earlier();
    const std::vector<int> missing = frames.still_to_make();
    if (!m_options.quiet)
        std::fprintf(stderr, "%zu of %d frames are to be made\n", missing.size(),
                     frames.plan.frames.count());
    if (missing.empty() && frames.video_is_made())
        return util::ExitCode::kDone;
    std::map<int, fs::file_time_type> before;
    std::vector<int> tasks;
    for (const int frame : missing) {
        before[frame] = frames.find_time(frame);
        if (const int task = frames.plan.find_task(frame); tasks.empty() || tasks.back() != task)
            tasks.push_back(task);
    }
    const ArrayJob job = array_of_frames({.name = {},
                                          .animate = command.with_program(m_folder.program()),
                                          .pattern = command.outputs.front(),
                                          .plan = frames.plan,
                                          .video = command.video});
    m_folder.write_script("frames", SlurmJob::kArray, job.task);
    m_folder.write_script("merge", SlurmJob::kOne, job.join);
    std::vector<std::string> wait;
    if (!tasks.empty())
        wait = {"--dependency=afterok" + submit_tasks(command, "frames", tasks),
                "--kill-on-invalid-dep=yes"};
    const Slurm::JobId merge = submit("merge", wait, 1);
    if (m_options.dry_run || !m_options.wait)
        return util::ExitCode::kDone;
    follow(m_jobs, m_tasks);

    const std::vector<int> left = frames.still_to_make();
    // A frame with holes is written, but counts as not done.
    const auto with_holes = std::count_if(left.begin(), left.end(), [&](int frame) {
        const auto was = before.find(frame);
        return was != before.end() && frames.find_time(frame) != was->second;
    });
    if (static_cast<std::size_t>(with_holes) != left.size())
        throw batch_error(std::to_string(left.size() - static_cast<std::size_t>(with_holes)) +
                          " frames were not made, the first is " + std::to_string(left.front()) +
                          "; see " + m_folder.logs() + "; the same command makes what is missing");
    if (with_holes > 0) {
        std::fprintf(stderr, "terravox: %td frames have holes; see %s\n", with_holes,
                     m_folder.logs().c_str());
        return util::ExitCode::kHoles;
    }
    if (const auto code = m_slurm->exit_code(merge); code && *code != 0)
        throw batch_error("all frames are there, but the job after them failed; see " +
                          m_folder.logs() + "/merge-" + merge + ".txt");
    if (!command.video.empty() && !fs::exists(command.video))
        throw batch_error("there is no " + command.video + "; see " + m_folder.logs());
    if (!m_options.quiet)
        std::fprintf(stderr, "all %d frames are done\n", frames.plan.frames.count());
    return util::ExitCode::kDone;
}

util::ExitCode Batch::run_parts(const JobCommand& command, const Command& joining) {
    wait_for_earlier();
    const int parts = m_options.parts;
    m_folder.write_script(
        "parts", SlurmJob::kArray,
        {"parts", {{"command", command.with_program(m_folder.program())}, {"parts", parts}}, true});
    m_folder.write_script("merge", SlurmJob::kOne,
                          {"merge",
                           {{"outputs", joining},
                            {"parts", parts},
                            {"tiles", command.outputs.front() + ".part-"},
                            {"program", m_folder.program()}}});
    std::vector<int> tasks(static_cast<std::size_t>(parts));
    std::iota(tasks.begin(), tasks.end(), 0);
    // afterany: merging itself detects missing tiles, and a part with holes is no failure.
    const Slurm::JobId merging =
        submit("merge", {"--dependency=afterany" + submit_tasks(command, "parts", tasks)}, 1);
    if (m_options.dry_run || !m_options.wait)
        return util::ExitCode::kDone;
    follow(m_jobs, m_tasks);
    const auto code = m_slurm->exit_code(merging);
    if (!code)
        throw batch_error("Slurm no longer reports how the parts were joined; see " +
                          m_folder.logs() + "/merge-" + merging + ".txt");
    if (*code == static_cast<int>(util::ExitCode::kHoles))
        return util::ExitCode::kHoles;
    if (*code != 0)
        throw batch_error("the parts were not joined; see " + m_folder.logs() +
                          "; the same command continues");
    return util::ExitCode::kDone;
}

}  // namespace terravox::cluster
