#include "raytracer/farm/cluster/tasks.hpp"

#include <algorithm>
#include <filesystem>

#include "common/util/folders.hpp"
#include "raytracer/core/animate/video.hpp"
#include "raytracer/farm/cluster/engines.hpp"

namespace terravox::cluster {

Command extend(Command command, const Command& more) {
    command.insert(command.end(), more.begin(), more.end());
    return command;
}

int usual_per_task(int frames, int nodes) noexcept {
    constexpr int kTasksOfNode = 8;
    const int tasks = std::max(1, nodes) * kTasksOfNode;
    return std::max(1, (frames + tasks - 1) / tasks);
}

ArrayJob array_of_frames(const FrameJob& job, const Engine& engine) {
    const animate::FrameNames names(job.pattern);
    const auto [first, last] = job.plan.frames;
    const Command range{"--first", std::to_string(first), "--last", std::to_string(last)};
    ArrayJob out{.name = job.name,
                 .tasks_name = "frames",
                 .join_name = "merge",
                 .tasks = job.plan.tasks(),
                 .task = fill("scripts/frames.sh", {{"command", job.animate},
                                                    {"first", first},
                                                    {"last", last},
                                                    {"per_task", job.plan.per_task},
                                                    {"task", engine.number()}}),
                 .join = {},
                 .joins_little = job.video.empty()};
    // One %d or %0Nd, which bash's printf interprets in the same way.
    const std::size_t at = job.pattern.find('%');
    const std::size_t end = job.pattern.find('d', at) + 1;
    out.join =
        fill("scripts/look.sh",
             {{"first", first},
              {"last", last},
              {"number", Value::plain(job.pattern.substr(at, end - at))},
              {"before", job.pattern.substr(0, at)},
              {"after", job.pattern.substr(end)},
              {"waits", engine.waits()},
              {"command",
               extend(job.animate, job.video.empty() ? range : Command{"--video", job.video})}});
    if (!engine.runs_here)
        return out;
    Command list = extend(extend(job.animate, {"--list"}), range);
    list.front() = util::beside_program("terravox-raytracer").string();
    out.to_do = fill("slurm/to_do.sh", {{"command", list},
                                        {"work", std::filesystem::current_path().string()},
                                        {"first", first},
                                        {"count", job.plan.frames.count()},
                                        {"per_task", job.plan.per_task},
                                        {"video", job.video},
                                        {"ledger", names.ledger().string()}});
    return out;
}

ArrayJob array_of_parts(const PartJob& job, const Engine& engine) {
    return {
        .name = {},
        .tasks_name = "parts",
        .join_name = "merge",
        .tasks = job.count,
        .task = fill("scripts/parts.sh",
                     {{"command", job.render}, {"parts", job.count}, {"task", engine.number()}}),
        .join = fill("scripts/merge.sh", {{"program", job.render.front()},
                                          {"outputs", job.files},
                                          {"parts", job.count},
                                          {"tiles", job.parts + ".part-"}})};
}

}  // namespace terravox::cluster
