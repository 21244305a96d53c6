#include <algorithm>
#include <cstdio>
#include <map>
#include <sstream>

#include "common/util/beside_program.hpp"
#include "raytracer/apps/commands/cluster/batch.hpp"
#include "raytracer/core/animate/animation.hpp"
#include "raytracer/core/animate/frame_names.hpp"
#include "raytracer/core/animate/video.hpp"

namespace terravox::cluster {
namespace {

namespace fs = std::filesystem;

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
            before[frame] = time_of(frame);
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
        const Finished done = run_to_end(list);
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
            if (const int task = m_plan.task_of(frame); tasks.empty() || tasks.back() != task)
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

    [[nodiscard]] fs::file_time_type time_of(int frame) const {
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
            if (time_of(frame) > made)
                return false;
        return true;
    }

    [[nodiscard]] util::ExitCode look_at_the_end(
        const std::map<int, fs::file_time_type>& before) const {
        const std::vector<int> missing = still_to_make();
        // A frame with holes is written, but counts as not done.
        const auto with_holes = std::count_if(missing.begin(), missing.end(), [&](int frame) {
            const auto was = before.find(frame);
            return was != before.end() && time_of(frame) != was->second;
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

}  // namespace terravox::cluster
