#include "raytracer/farm/cluster/tasks.hpp"

#include <algorithm>

#include "common/util/text.hpp"
#include "raytracer/core/animate/video.hpp"
#include "raytracer/farm/cluster/manifests.hpp"

namespace terravox::cluster {

int usual_per_task(int frames, int nodes) noexcept {
    constexpr int kTasksOfNode = 8;
    const int tasks = std::max(1, nodes) * kTasksOfNode;
    return std::max(1, (frames + tasks - 1) / tasks);
}

std::string array_text(const std::vector<int>& sorted) {
    std::string out;
    for (std::size_t i = 0; i < sorted.size();) {
        std::size_t end = i + 1;
        while (end < sorted.size() && sorted[end] == sorted[end - 1] + 1)
            ++end;
        out += (out.empty() ? "" : ",") + std::to_string(sorted[i]);
        if (end - i > 1)
            out += "-" + std::to_string(sorted[end - 1]);
        i = end;
    }
    return out;
}

std::vector<ArrayPiece> array_pieces(const std::vector<int>& tasks, int limit) {
    std::vector<ArrayPiece> out;
    for (const int task : tasks) {
        const int offset = task / limit * limit;
        if (out.empty() || out.back().offset != offset)
            out.push_back({offset, {}});
        out.back().indices.push_back(task - offset);
    }
    return out;
}

std::string frames_body(const Command& command, const TaskPlan& plan, const std::string& task) {
    const std::string per = std::to_string(plan.per_task);
    const std::string last = std::to_string(plan.frames.last);
    return util::shell_array("command", command) + "task=" + task + "\nfirst=$((" +
           std::to_string(plan.frames.first) + " + task * " + per + "))\n" + "last=$((first + " +
           per +
           " - 1))\n"
           "((last <= " +
           last + ")) || last=" + last +
           "\n"
           "exec \"${command[@]}\" --first \"$first\" --last \"$last\"\n";
}

std::string merge_frames_body(const std::string& pattern, util::IntRange frames,
                              const Command& command) {
    // One %d or %0Nd, which bash's printf interprets in the same way.
    (void)animate::FrameNames(pattern);
    const std::size_t at = pattern.find('%');
    const std::size_t end = pattern.find('d', at) + 1;
    const std::string look =
        "missing=0\n"
        "for ((frame = " +
        std::to_string(frames.first) + "; frame <= " + std::to_string(frames.last) +
        "; ++frame)); do\n"
        "    printf -v number '" +
        pattern.substr(at, end - at) +
        "' \"$frame\"\n"
        "    picture=" +
        util::shell_word(pattern.substr(0, at)) + "$number" +
        util::shell_word(pattern.substr(end)) +
        "\n"
        "    [[ -s $picture ]] && continue\n"
        "    printf 'missing: %s\\n' \"$picture\" >&2\n"
        "    missing=$((missing + 1))\n"
        "done\n"
        "if ((missing > 0)); then\n"
        "    printf 'terravox: join the frames: %s are missing\\n' \"$missing\" >&2\n"
        "    exit 1\n"
        "fi\n";
    if (command.empty())
        return look + "echo 'all frames are there'\n";
    return look + util::shell_array("command", command) + "exec \"${command[@]}\"\n";
}

ArrayJob array_of_frames(const FrameJob& job) {
    Command video;
    if (!job.video.empty()) {
        video = job.animate;
        video.insert(video.end(), {"--video", job.video});
    }
    ArrayJob out;
    out.name = job.name;
    out.tasks_name = "frames";
    out.join_name = "merge";
    out.work = job.work;
    out.tasks = job.plan.tasks();
    out.task_body = [command = job.animate, plan = job.plan](const std::string& task) {
        return frames_body(command, plan, task);
    };
    out.join_body = merge_frames_body(job.pattern, job.plan.frames, video);
    out.waiting_join_body = "until (\n" + merge_frames_body(job.pattern, job.plan.frames, {}) +
                            ") 2>/dev/null; do sleep 30; done\n";
    if (!video.empty())
        out.waiting_join_body += util::shell_array("command", video) + "exec \"${command[@]}\"\n";
    out.cpus = job.cpus;
    out.memory_mib = job.memory_mib;
    out.join_cpus = video.empty() ? 1 : job.cpus;
    constexpr int kLook_mib = 256;
    out.join_memory_mib = video.empty() ? kLook_mib : job.memory_mib;
    return out;
}

}  // namespace terravox::cluster
