#include "raytracer/farm/cluster/engines.hpp"

#include <algorithm>
#include <string_view>
#include <system_error>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/animate/video.hpp"

namespace terravox::cluster {

Command extend(Command command, const Command& more) {
    command.insert(command.end(), more.begin(), more.end());
    return command;
}

namespace {

/// What a worker keeps of the memory of its task: a quarter is for everything except boxes, the
/// program, tiles, and threads.
int worker_memory_mib(int task_mib) noexcept {
    return task_mib / 4 * 3;
}

/// How Slurm runs a script.
enum class SlurmJob {
    kArray,  ///< for each number
    kOne,
    kOnce,  ///< one job, which is not requeued when its node fails
};

/// A script for sbatch that can be read, changed, and submitted by hand from its folder. Of several
/// arrays, argument 1 is the number of the first task.
std::pair<std::string, std::string> make_script(const Place& place, const std::string& name,
                                                SlurmJob job, const std::string& body) {
    const Needs& needs = place.needs;
    std::vector<std::string> whole;
    if (needs.cpus == 0)
        whole.emplace_back("--exclusive");
    if (needs.cpus == 0 && needs.memory_mib == 0)
        whole.emplace_back("--mem=0");
    return {name + ".sbatch",
            fill("slurm/job.sbatch",
                 {{"name", Value::plain(name)},
                  {"log", Value::plain(job == SlurmJob::kArray ? "%A_%a" : "%j")},
                  {"requeue", job == SlurmJob::kOnce ? "--no-requeue" : "--requeue"},
                  {"whole", Value::plain_list(whole)},
                  {"cpus", Value::if_positive(needs.cpus)},
                  {"memory", Value::if_positive(needs.memory_mib)},
                  {"partition", Value::plain_if_any(needs.partition)},
                  {"time", Value::plain_if_any(needs.time)},
                  {"further", Value::plain_list(needs.extra)},
                  {"work", place.work.string()},
                  {"body", Value::plain(body)}})};
}

std::string make_submit(const Place& place, const std::string& body) {
    return fill("slurm/submit.sh", {{"folder", place.folder.string()},
                                    {"quiet", place.quiet ? 1 : 0},
                                    {"poll_s", place.poll_s},
                                    {"body", Value::plain(body)}});
}

JobFiles make_slurm_array(const ArrayJob& job, const Place& place) {
    const std::string submits = fill(
        "slurm/array.sh",
        {{"folder", place.folder.string()},
         {"wait", place.waits ? 1 : 0},
         {"quiet", place.quiet ? 1 : 0},
         {"tasks", job.tasks},
         {"to_do", Value::plain_if_any(job.to_do)},
         {"last_baker", Value::plain_if_any(job.bakers > 0 ? std::to_string(job.bakers - 1) : "")},
         {"at_once", place.nodes},
         {"tasks_name", job.tasks_name},
         {"join_name", job.join_name}});
    JobFiles out{make_submit(place, submits)};
    out.scripts = {make_script(place, job.tasks_name, SlurmJob::kArray, job.task),
                   make_script(place, job.join_name, SlurmJob::kOne, job.join)};
    if (job.bakers > 0)
        out.scripts.push_back(make_script(place, "bake", SlurmJob::kArray, job.bake));
    return out;
}

JobFiles make_slurm_pool(const PoolJob& job, const Place& place) {
    const std::string folder = place.folder.string();
    const Value host = job.address.empty() ? Value::plain("\"$HOSTNAME\"") : Value(job.address);
    const std::string coordinator =
        fill("scripts/coordinator.sh",
             {{"command", job.render}, {"folder", folder}, {"port", job.port}, {"host", host}});
    const std::string worker =
        fill("scripts/worker.sh",
             {{"program", job.render.front()},
              {"folder", folder},
              {"cpus", Value::if_positive(place.needs.cpus)},
              {"memory_mib", Value::if_positive(worker_memory_mib(place.needs.memory_mib))}});
    const std::string submits =
        fill("slurm/pool.sh", {{"program", util::beside_program("terravox-raytracer").string()},
                               {"here", job.has_coordinator_job ? 0 : 1},
                               {"renders", job.renders ? 1 : 0},
                               {"folder", folder},
                               {"last", place.nodes - 1}});
    return {make_submit(place, submits),
            {make_script(place, "coordinator", SlurmJob::kOnce, coordinator),
             make_script(place, "worker", SlurmJob::kArray, worker)}};
}

/// What OpenJD and pods run.
std::string make_run(const std::vector<std::string>& work, const std::string& body) {
    return fill("scripts/run.sh", {{"work", work}, {"body", Value::plain(body)}});
}

JobFiles make_openjd_array(const ArrayJob& job, const Place& place) {
    const auto script = [&](const std::string& body) {
        std::string out = make_run({place.work.string()}, body);
        // A word between double braces would be taken for a variable of the scheduler, and the
        // format has no way to escape it.
        if (out.find("{{") != std::string::npos || out.find("}}") != std::string::npos)
            throw util::UsageError(
                "cluster openjd: an argument holds {{ or }}; allowed: arguments without them, "
                "which Open Job Description takes for its own");
        return out;
    };
    std::string amounts;
    for (const auto& [name, least] :
         {std::pair("vcpu", place.needs.cpus), std::pair("memory", place.needs.memory_mib)})
        if (least > 0)
            amounts += std::string(amounts.empty() ? "" : ", ") + "{\"name\": \"amount.worker." +
                       name + "\", \"min\": " + std::to_string(least) + "}";
    const std::string last = job.tasks > 1 ? "-" + std::to_string(job.tasks - 1) : "";
    return {fill("openjd/array.json", {{"name", job.name},
                                       {"tasks_name", job.tasks_name},
                                       {"tasks_script", script(job.task)},
                                       {"range", "0" + last},
                                       {"join_name", job.join_name},
                                       {"join_script", script(job.join)},
                                       {"needs", Value::plain_if_any(amounts)}})};
}

/// A part of a job: its pods.
struct Pod {
    std::string part;
    Command command;
    Needs needs;
    bool has_token = false;
    std::string port = {};
};

Value make_pod(const std::string& name, Pod pod, const PodPlace& place) {
    // Kubernetes replaces $(NAME) in arguments; $$ is a dollar.
    for (std::string& word : pod.command)
        for (std::size_t at = 0; (at = word.find('$', at)) != std::string::npos; at += 2)
            word.insert(at, 1, '$');
    return Value::plain(fill("kubernetes/pod.json",
                             {{"name", Value::plain(name)},
                              {"part", Value::plain(pod.part)},
                              {"image", place.image},
                              {"command", pod.command},
                              {"mount", place.mount},
                              {"cache", place.mount + "/.cache"},
                              {"secret", Value::plain_if_any(pod.has_token ? name + "-token" : "")},
                              {"cpu", std::to_string(pod.needs.cpus)},
                              {"memory", std::to_string(pod.needs.memory_mib) + "Mi"},
                              {"port", Value::plain_if_any(pod.port)},
                              {"claim", place.claim}}));
}

JobFiles make_kubernetes_array(const ArrayJob& job, const Place& place) {
    place.pods.check(job.name);
    const auto pod = [&](const std::string& part, const std::string& body, const Needs& needs) {
        const Command bash{"/bin/bash", "-c", make_run({}, body), "terravox"};
        return make_pod(job.name, {part, bash, needs}, place.pods);
    };
    constexpr int kLittle_mib = 256;
    const Needs join_needs = job.joins_little ? Needs{1, kLittle_mib} : place.needs;
    return {
        fill("kubernetes/array.json", {{"name", Value::plain(job.name)},
                                       {"tasks_name", Value::plain(job.tasks_name)},
                                       {"tasks", job.tasks},
                                       {"at_once", std::min(job.tasks, place.nodes)},
                                       {"tasks_pod", pod(job.tasks_name, job.task, place.needs)},
                                       {"join_name", Value::plain(job.join_name)},
                                       {"join_pod", pod(job.join_name, job.join, join_needs)}})};
}

/// A Job with the coordinator, a Service in front of it, and a Job of workers, which end with it; a
/// List in JSON, for kubectl. The token is taken from the Secret NAME-token, key `token`, which is
/// not written here.
JobFiles make_kubernetes_pool(const PoolJob& job, const Place& place) {
    place.pods.check(job.name);
    constexpr int kPodTries = 3;  // of a pod that fails; also in its templates
    const std::string port = "7879";
    const Pod coordinator{"coordinator", extend(job.render, {"--listen", ":" + port}), place.needs,
                          true, port};
    const Pod worker{
        "worker",
        {job.render.front(), "worker", "--once", "--join", job.name + "-coordinator:" + port,
         "--threads", std::to_string(place.needs.cpus), "--memory-mib",
         std::to_string(worker_memory_mib(place.needs.memory_mib))},
        place.needs,
        true};
    return {fill("kubernetes/pool.json",
                 {{"name", Value::plain(job.name)},
                  {"port", Value::plain(port)},
                  {"coordinator_pod", make_pod(job.name, coordinator, place.pods)},
                  {"nodes", place.nodes},
                  {"retries", kPodTries * place.nodes},
                  {"worker_pod", make_pod(job.name, worker, place.pods)}})};
}

}  // namespace

const std::array<Engine, 3> kEngines{
    // Where one array is not enough, each gets the number of its first task.
    Engine{"$((${1:-0} + SLURM_ARRAY_TASK_ID))", true, true, make_slurm_array, make_slurm_pool},
    Engine{"$1", true, false, make_openjd_array, nullptr},
    Engine{"$JOB_COMPLETION_INDEX", false, false, make_kubernetes_array, make_kubernetes_pool},
};

std::string Engine::find_program(const std::filesystem::path& given) const {
    if (!runs_here)
        return given.empty() ? "terravox-raytracer" : given.string();
    return (given.empty() ? util::beside_program("terravox-raytracer")
                          : std::filesystem::absolute(given))
        .string();
}

void JobFiles::write_scripts(const std::filesystem::path& folder) const {
    if (scripts.empty())
        return;
    std::error_code failed;
    std::filesystem::create_directories(folder / "logs", failed);
    if (failed)
        throw util::Error("make the folder {}: {}", (folder / "logs").string(), failed.message());
    for (const auto& [name, text] : scripts)
        util::write_file_atomically(folder / name, text);
}

void Needs::check() const {
    const auto refuse = [](const std::string& flag, const std::string& value, const char* allowed) {
        throw util::UsageError("cluster: " + flag + " " + value + "; allowed: " + allowed);
    };
    const auto is_plain = [](const std::string& text) {
        return text.find_first_not_of(
                   "0123456789abcdefghijklmnopqrstuvwxyz"
                   "ABCDEFGHIJKLMNOPQRSTUVWXYZ_-:.,") == std::string::npos;
    };
    if (!is_plain(partition))
        refuse("--partition", partition, "letters, digits, _ - : . ,");
    if (!is_plain(time))
        refuse("--time", time, "as sbatch takes it, such as 4:00:00");
    for (const std::string& line : extra)
        if (!line.starts_with('-') || std::any_of(line.begin(), line.end(), [](char c) {
                return static_cast<unsigned char>(c) < 0x20;
            }))
            refuse("--sbatch", util::comment_text(line),
                   "options of sbatch on one line, such as \"--account=film --qos=low\"");
}

void PodPlace::check(const std::string& name) const {
    const auto refuse = [](const std::string& what, const char* allowed) {
        throw util::UsageError("cluster kubernetes: " + what + "; allowed: " + allowed);
    };
    const auto is_label = [](const std::string& text, std::size_t max) {
        return !text.empty() && text.size() <= max && text.front() != '-' && text.back() != '-' &&
               text.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyz-") == std::string::npos;
    };
    constexpr std::size_t kMaxName = 40;  // 63 with what is added
    if (!is_label(name, kMaxName))
        refuse("--name " + util::comment_text(name),
               "up to 40 of a-z, 0-9 and -, with a letter or digit at both ends");
    if (!is_label(claim, 63))
        refuse("--claim " + util::comment_text(claim), "the name of a persistent volume claim");
    if (image.empty())
        refuse("--image is missing", "the name of a container image with terravox-raytracer");
    if (!mount.starts_with('/'))
        refuse("--mount " + util::comment_text(mount), "an absolute path");
}

int usual_per_task(int frames, int nodes) noexcept {
    constexpr int kTasksOfNode = 8;
    const int tasks = std::max(1, nodes) * kTasksOfNode;
    return std::max(1, (frames + tasks - 1) / tasks);
}

ArrayJob array_of_frames(const FrameJob& job, const Engine& engine) {
    const animate::FrameNames names(job.pattern);
    const auto [first, last] = job.frames;
    const Command range{"--first", std::to_string(first), "--last", std::to_string(last)};
    ArrayJob out{.name = job.name,
                 .tasks_name = "frames",
                 .join_name = "merge",
                 .tasks = job.tasks(),
                 .task = fill("scripts/frames.sh", {{"command", job.animate},
                                                    {"first", first},
                                                    {"last", last},
                                                    {"per_task", job.per_task},
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
                                        {"count", job.frames.count()},
                                        {"per_task", job.per_task},
                                        {"video", job.video},
                                        {"ledger", names.ledger().string()}});
    return out;
}

ArrayJob array_of_parts(const Command& render, const std::string& output, int count,
                        const Command& files, const Engine& engine) {
    return {.name = {},
            .tasks_name = "parts",
            .join_name = "merge",
            .tasks = count,
            .task = fill("scripts/parts.sh",
                         {{"command", render}, {"parts", count}, {"task", engine.number()}}),
            .join = fill("scripts/merge.sh", {{"program", render.front()},
                                              {"outputs", files},
                                              {"parts", count},
                                              {"tiles", output + ".part-"}})};
}

}  // namespace terravox::cluster
