#include "raytracer/farm/cluster/engines.hpp"

#include <algorithm>
#include <numeric>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/text.hpp"

namespace terravox::cluster {
namespace {

constexpr const char* kPlain =
    "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_-:.,";
constexpr const char* kLabel = "0123456789abcdefghijklmnopqrstuvwxyz-";
constexpr int kPodTries = 3;  ///< of a pod that fails; also in its templates

/// What a worker keeps of the memory of its task: a quarter is for everything except boxes, the
/// program, tiles, and threads.
int worker_memory_mib(int task_mib) noexcept {
    return std::max(1, task_mib / 4 * 3);
}

std::vector<std::string> sbatch_lines(const Needs& needs) {
    std::vector<std::string> out{needs.cpus > 0 ? "--cpus-per-task=" + std::to_string(needs.cpus)
                                                : "--exclusive"};
    if (needs.memory_mib > 0)
        out.push_back("--mem=" + std::to_string(needs.memory_mib) + "M");
    else if (needs.cpus == 0)
        out.emplace_back("--mem=0");
    if (!needs.partition.empty())
        out.push_back("--partition=" + needs.partition);
    if (!needs.time.empty())
        out.push_back("--time=" + needs.time);
    out.insert(out.end(), needs.extra.begin(), needs.extra.end());
    return out;
}

ArrayFiles make_slurm(const ArrayJob& job, const Place& place) {
    std::vector<int> tasks(static_cast<std::size_t>(job.tasks));
    std::iota(tasks.begin(), tasks.end(), 0);
    std::vector<std::string> arrays;
    for (const ArrayPiece& piece : array_pieces(tasks, kEngines[kSlurm].array_limit))
        arrays.push_back(array_text(piece.indices) + "%" + std::to_string(place.nodes) + " " +
                         std::to_string(piece.offset));
    return {fill("slurm/submit.sh", {{"folder", place.folder.string()},
                                     {"arrays", Value::plain_list(arrays)},
                                     {"tasks_name", job.tasks_name},
                                     {"join_name", job.join_name}}),
            {{job.tasks_name + ".sbatch",
              slurm_script(place, job.tasks_name, SlurmJob::kArray, job.task)},
             {job.join_name + ".sbatch",
              slurm_script(place, job.join_name, SlurmJob::kOne, job.join)}}};
}

/// What OpenJD and pods run.
std::string run_script(const std::vector<std::string>& work, const std::string& body) {
    return fill("scripts/run.sh", {{"work", work}, {"body", Value::plain(body)}});
}

/// A name as the format writes them: "Frames".
std::string title(std::string name) {
    if (!name.empty() && name.front() >= 'a' && name.front() <= 'z')
        name.front() = static_cast<char>(name.front() - 'a' + 'A');
    return name;
}

ArrayFiles make_openjd(const ArrayJob& job, const Place& place) {
    const auto script = [&](const std::string& body) {
        std::string out = run_script({place.work.string()}, body);
        // A word between double braces would be taken for a variable of the scheduler, and the
        // format has no way to escape it.
        if (out.find("{{") != std::string::npos || out.find("}}") != std::string::npos)
            throw util::UsageError(
                "cluster openjd: an argument holds {{ or }}; allowed: arguments without them, "
                "which Open Job Description takes for its own");
        return out;
    };
    std::string amounts;
    const auto ask = [&](const char* name, int least) {
        if (least > 0)
            amounts += std::string(amounts.empty() ? "" : ", ") + "{\"name\": \"amount.worker." +
                       name + "\", \"min\": " + std::to_string(least) + "}";
    };
    ask("vcpu", job.cpus);
    ask("memory", job.memory_mib);
    std::vector<std::string> needs;
    if (!amounts.empty())
        needs.push_back(amounts);
    const std::string tasks = title(job.tasks_name);
    const std::string join = title(job.join_name);
    const std::string last = job.tasks > 1 ? "-" + std::to_string(job.tasks - 1) : "";
    return {fill("openjd/array.json", {{"name", job.name},
                                       {"tasks_name", tasks},
                                       {"tasks_file", tasks + ".sh"},
                                       {"tasks_script", script(job.task.text(kEngines[kOpenJd]))},
                                       {"range", "0" + last},
                                       {"join_name", join},
                                       {"join_file", join + ".sh"},
                                       {"join_script", script(job.join.text(kEngines[kOpenJd]))},
                                       {"needs", Value::plain_list(needs)}}),
            {}};
}

/// Kubernetes replaces $(NAME) in arguments; $$ is a dollar.
Command escape_dollars(Command words) {
    for (std::string& word : words)
        for (std::size_t at = 0; (at = word.find('$', at)) != std::string::npos; at += 2)
            word.insert(at, 1, '$');
    return words;
}

/// A part of what is called `name`.
struct Pod {
    std::string part;
    Command command;
    int cpus = 0;
    int memory_mib = 0;
    bool has_token = false;
    std::vector<std::string> ports = {};
};

Value make_pod(const std::string& name, const Pod& pod, const PodPlace& place) {
    std::vector<std::string> secret;
    if (pod.has_token)
        secret.push_back(name + "-token");
    return Value::plain(
        fill("kubernetes/pod.json", {{"name", name},
                                     {"part", pod.part},
                                     {"image", place.image},
                                     {"command", escape_dollars(pod.command)},
                                     {"mount", place.mount},
                                     {"cache", place.mount + "/.cache"},
                                     {"secret", secret},
                                     {"cpu", std::to_string(pod.cpus)},
                                     {"memory", std::to_string(pod.memory_mib) + "Mi"},
                                     {"port", Value::plain_list(pod.ports)},
                                     {"claim", place.claim}}));
}

ArrayFiles make_kubernetes(const ArrayJob& job, const Place& place) {
    place.pods.check(job.name);
    const auto bash = [&](const std::string& body) {
        return Command{"/bin/bash", "-c", run_script({}, body), "terravox"};
    };
    const Pod task{job.tasks_name, bash(job.task.text(kEngines[kKubernetes])), job.cpus,
                   job.memory_mib};
    const Pod join{job.join_name, bash(job.join.text(kEngines[kKubernetes])), job.join_cpus,
                   job.join_memory_mib};
    return {fill("kubernetes/array.json", {{"name", job.name},
                                           {"tasks_name", job.name + "-" + job.tasks_name},
                                           {"tasks_part", job.tasks_name},
                                           {"tasks", job.tasks},
                                           {"at_once", std::min(job.tasks, place.nodes)},
                                           {"tasks_pod", make_pod(job.name, task, place.pods)},
                                           {"join_name", job.name + "-" + job.join_name},
                                           {"join_part", job.join_name},
                                           {"join_pod", make_pod(job.name, join, place.pods)}}),
            {}};
}

}  // namespace

const std::array<Engine, 3> kEngines{
    // The limit is that of Slurm as it comes. Where one array is not enough, each gets the number
    // of its first task.
    Engine{"slurm", "$((${1:-0} + SLURM_ARRAY_TASK_ID))", 1001, true, true, make_slurm},
    Engine{"openjd", "$1", 0, true, false, make_openjd},
    Engine{"kubernetes", "$JOB_COMPLETION_INDEX", 0, false, false, make_kubernetes},
};

std::string Body::text(const Engine& engine) const {
    Values all = values;
    if (is_numbered)
        all.emplace("task", Value::plain(engine.task));
    if (!wait_word.empty())
        all.emplace("waits", engine.orders_jobs ? std::vector<std::string>{}
                                                : std::vector<std::string>{wait_word});
    return fill("scripts/" + script + ".sh", all);
}

void Needs::check() const {
    const auto refuse = [](const std::string& flag, const std::string& value, const char* allowed) {
        throw util::UsageError("cluster: " + flag + " " + value + "; allowed: " + allowed);
    };
    const auto plain = [](const std::string& text) {
        return text.find_first_not_of(kPlain) == std::string::npos;
    };
    if (!plain(partition))
        refuse("--partition", partition, "letters, digits, _ - : . ,");
    if (!plain(time))
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
               text.find_first_not_of(kLabel) == std::string::npos;
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

std::string slurm_script(const Place& place, const std::string& name, SlurmJob job,
                         const Body& body) {
    const bool is_array = job == SlurmJob::kArray;
    return fill("slurm/job.sbatch",
                {{"name", Value::plain(name)},
                 {"log", Value::plain(is_array ? "%A_%a" : "%j")},
                 {"requeue", job == SlurmJob::kOnce ? "--no-requeue" : "--requeue"},
                 {"needs", Value::plain_list(sbatch_lines(place.needs))},
                 {"work", place.work.string()},
                 {"body", Value::plain(body.text(kEngines[kSlurm]))}});
}

std::string kubernetes_pool(const std::string& name, const Command& render, const Place& place) {
    place.pods.check(name);
    const std::string port = "7879";
    const int cpus = place.needs.cpus;
    const int memory_mib = place.needs.memory_mib;
    Pod coordinator{"coordinator", render, cpus, memory_mib, true, {port}};
    coordinator.command.insert(coordinator.command.end(), {"--listen", ":" + port});
    // They end with the picture (--once).
    const Pod worker{
        "worker",
        {render.front(), "worker", "--once", "--join", name + "-coordinator:" + port, "--threads",
         std::to_string(cpus), "--memory-mib", std::to_string(worker_memory_mib(memory_mib))},
        cpus,
        memory_mib,
        true};
    return fill("kubernetes/pool.json",
                {{"name", name},
                 {"coordinator", name + "-coordinator"},
                 {"port", Value::plain(port)},
                 {"coordinator_pod", make_pod(name, coordinator, place.pods)},
                 {"worker", name + "-worker"},
                 {"nodes", place.nodes},
                 {"retries", kPodTries * place.nodes},
                 {"worker_pod", make_pod(name, worker, place.pods)}});
}

Body worker_body(const std::string& program, const Needs& needs, const std::string& token_file,
                 const std::string& address, const std::string& address_file) {
    // When the picture is complete, or its coordinator has gone for good, the node is released
    // automatically.
    Command command{program, "worker", "--once", "--idle-s", "600", "--token-file", token_file};
    if (needs.cpus > 0)
        command.insert(command.end(), {"--threads", std::to_string(needs.cpus)});
    if (needs.memory_mib > 0)
        command.insert(command.end(),
                       {"--memory-mib", std::to_string(worker_memory_mib(needs.memory_mib))});
    if (address.empty())
        return {"worker", {{"command", command}, {"address_file", address_file}}};
    command.insert(command.end(), {"--join", address});
    return command_body(command,
                        "A worker for one picture: it lends its node to the coordinator until the "
                        "array is cancelled.");
}

}  // namespace terravox::cluster
