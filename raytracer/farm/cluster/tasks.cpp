#include "raytracer/farm/cluster/tasks.hpp"

#include <algorithm>

#include "raytracer/core/animate/video.hpp"

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

Body command_body(const Command& command, const std::string& about) {
    return {"command", {{"about", Value::plain(about)}, {"command", command}}};
}

Body frames_body(const Command& command, const TaskPlan& plan) {
    return {"frames",
            {{"command", command},
             {"first", plan.frames.first},
             {"last", plan.frames.last},
             {"per_task", plan.per_task}},
            true};
}

Body merge_frames_body(const std::string& pattern, util::IntRange frames, const Command& command) {
    // One %d or %0Nd, which bash's printf interprets in the same way.
    (void)animate::FrameNames(pattern);
    const std::size_t at = pattern.find('%');
    const std::size_t end = pattern.find('d', at) + 1;
    std::string then = "echo 'all frames are there'";
    if (!command.empty())
        then = fill("scripts/command.sh", command_body(command, "Makes the video.").values);
    return {.script = "look",
            .values = {{"first", frames.first},
                       {"last", frames.last},
                       {"number", Value::plain(pattern.substr(at, end - at))},
                       {"before", pattern.substr(0, at)},
                       {"after", pattern.substr(end)},
                       {"then", Value::plain(then)}},
            .wait_word = "30"};
}

ArrayJob array_of_frames(const FrameJob& job) {
    Command video;
    if (!job.video.empty()) {
        video = job.animate;
        video.insert(video.end(), {"--video", job.video});
    }
    constexpr int kLook_mib = 256;
    return {.name = job.name,
            .tasks_name = "frames",
            .join_name = "merge",
            .tasks = job.plan.tasks(),
            .task = frames_body(job.animate, job.plan),
            .join = merge_frames_body(job.pattern, job.plan.frames, video),
            .cpus = job.cpus,
            .memory_mib = job.memory_mib,
            .join_cpus = video.empty() ? 1 : job.cpus,
            .join_memory_mib = video.empty() ? kLook_mib : job.memory_mib};
}

}  // namespace terravox::cluster
