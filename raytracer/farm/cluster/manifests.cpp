#include "raytracer/farm/cluster/manifests.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "common/util/secret.hpp"
#include "common/util/text.hpp"

namespace terravox::cluster {
namespace {

using Json = nlohmann::ordered_json;

/// A name as the format writes them: "Frames".
std::string title(std::string name) {
    if (!name.empty() && name.front() >= 'a' && name.front() <= 'z')
        name.front() = static_cast<char>(name.front() - 'a' + 'A');
    return name;
}

Json step(const std::string& name, const ArrayJob& job, const std::string& body, Json arguments) {
    const std::string script =
        "set -euo pipefail\n" +
        (job.work.empty() ? "" : "cd -- " + util::shell_word(job.work) + "\n") + body;
    // A word between double braces would be taken for a variable of the scheduler, and the format
    // has no way to escape it.
    if (script.find("{{") != std::string::npos || script.find("}}") != std::string::npos)
        throw util::UsageError(
            "cluster openjd: an argument holds {{ or }}; allowed: arguments without them, which "
            "Open Job Description takes for its own");
    arguments.insert(arguments.begin(), "{{Task.File.Run}}");
    Json out{{"name", name}};
    Json& run = out["script"];
    run["actions"]["onRun"] = {
        {"command", "bash"},
        {"args", arguments},
        {"cancelation", {{"mode", "NOTIFY_THEN_TERMINATE"}, {"notifyPeriodInSeconds", 30}}}};
    run["embeddedFiles"] = Json::array(
        {{{"name", "Run"}, {"type", "TEXT"}, {"filename", name + ".sh"}, {"data", script}}});
    Json amounts = Json::array();
    if (job.cpus > 0)
        amounts.push_back({{"name", "amount.worker.vcpu"}, {"min", job.cpus}});
    if (job.memory_mib > 0)
        amounts.push_back({{"name", "amount.worker.memory"}, {"min", job.memory_mib}});
    if (!amounts.empty())
        out["hostRequirements"]["amounts"] = amounts;
    return out;
}

}  // namespace

std::string openjd_array(const ArrayJob& job) {
    const std::string tasks_name = title(job.tasks_name);
    Json tasks = step(tasks_name, job, job.task_body("$1"), Json::array({"{{Task.Param.Task}}"}));
    const int last = job.tasks - 1;
    tasks["parameterSpace"]["taskParameterDefinitions"] =
        Json::array({{{"name", "Task"},
                      {"type", "INT"},
                      {"range", last == 0 ? "0" : "0-" + std::to_string(last)}}});
    Json join = step(title(job.join_name), job, job.join_body, Json::array());
    join["dependencies"] = Json::array({{{"dependsOn", tasks_name}}});
    const Json out{{"specificationVersion", "jobtemplate-2023-09"},
                   {"name", job.name},
                   {"steps", Json::array({tasks, join})}};
    try {
        return out.dump(2) + "\n";
    } catch (const Json::type_error&) {
        throw util::UsageError(
            "cluster openjd: an argument is no UTF-8; allowed: UTF-8, which JSON is written in");
    }
}

namespace {

constexpr int kPort = 7879;
constexpr int kTries = 3;  ///< of a pod that fails

/// Kubernetes replaces $(NAME) in arguments; $$ is a dollar.
std::string argument(const std::string& word) {
    std::string out;
    for (const char c : word)
        out += c == '$' ? "$$" : std::string(1, c);
    return out;
}

Json arguments(const Command& words) {
    Json out = Json::array();
    for (const std::string& word : words)
        out.push_back(argument(word));
    return out;
}

Json bash(const std::string& script) {
    return Json::array({"/bin/bash", "-c", argument("set -euo pipefail\n" + script), "terravox"});
}

Json resources(int cpus, int memory_mib) {
    const Json asked{{"cpu", std::to_string(cpus)}, {"memory", std::to_string(memory_mib) + "Mi"}};
    // Only memory has a limit: a process that waits for its share of a processor is slow, one
    // without memory is killed.
    return {{"requests", asked}, {"limits", {{"memory", asked["memory"]}}}};
}

Json meta(const std::string& name, const std::string& part) {
    return {{"name", name + "-" + part},
            {"labels",
             {{"app.kubernetes.io/name", "terravox"},
              {"app.kubernetes.io/instance", name},
              {"app.kubernetes.io/component", part}}}};
}

Json pod(const std::string& name, const std::string& part, const Json& command, int cpus,
         int memory_mib, const PodPlace& place) {
    Json container{
        {"name", part}, {"image", place.image}, {"command", command}, {"workingDir", place.mount}};
    container["env"] =
        Json::array({{{"name", "HOME"}, {"value", "/tmp"}},
                     {{"name", "XDG_CACHE_HOME"}, {"value", place.mount + "/.cache"}}});
    container["resources"] = resources(cpus, memory_mib);
    container["securityContext"] = {{"allowPrivilegeEscalation", false},
                                    {"readOnlyRootFilesystem", true},
                                    {"capabilities", {{"drop", {"ALL"}}}}};
    container["volumeMounts"] = Json::array(
        {{{"name", "data"}, {"mountPath", place.mount}}, {{"name", "tmp"}, {"mountPath", "/tmp"}}});
    Json spec{{"automountServiceAccountToken", false}, {"terminationGracePeriodSeconds", 60}};
    spec["securityContext"] = {{"runAsNonRoot", true},
                               {"runAsUser", 1000},
                               {"runAsGroup", 1000},
                               {"fsGroup", 1000},
                               {"seccompProfile", {{"type", "RuntimeDefault"}}}};
    spec["containers"] = Json::array({container});
    spec["volumes"] =
        Json::array({{{"name", "data"}, {"persistentVolumeClaim", {{"claimName", place.claim}}}},
                     {{"name", "tmp"}, {"emptyDir", Json::object()}}});
    return {{"metadata", {{"labels", meta(name, part)["labels"]}}}, {"spec", spec}};
}

void give_token(Json& pod_template, const std::string& name) {
    pod_template["spec"]["containers"][0]["env"].push_back(
        {{"name", util::kFarmTokenVariable},
         {"valueFrom", {{"secretKeyRef", {{"name", name + "-token"}, {"key", "token"}}}}}});
}

std::string to_list(const Json& items) {
    try {
        return Json{{"apiVersion", "v1"}, {"kind", "List"}, {"items", items}}.dump(2) + "\n";
    } catch (const Json::type_error&) {
        throw util::UsageError(
            "cluster kubernetes: an argument is no UTF-8; allowed: UTF-8, which JSON is written "
            "in");
    }
}

}  // namespace

void PodPlace::check(const std::string& name) const {
    const auto refuse = [](const std::string& what, const char* allowed) {
        throw util::UsageError("cluster kubernetes: " + what + "; allowed: " + allowed);
    };
    const auto is_label = [](const std::string& text, std::size_t max) {
        return !text.empty() && text.size() <= max && text.front() != '-' && text.back() != '-' &&
               std::all_of(text.begin(), text.end(), [](char c) {
                   return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
               });
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

std::string kubernetes_array(const ArrayJob& job, const PodPlace& place) {
    place.check(job.name);
    Json tasks{
        {"apiVersion", "batch/v1"}, {"kind", "Job"}, {"metadata", meta(job.name, job.tasks_name)}};
    tasks["spec"] = {
        {"completions", job.tasks},
        {"parallelism", std::min(job.tasks, place.nodes)},
        {"completionMode", "Indexed"},
        // Each index has its own retries; a pod that lost its node does not count.
        {"backoffLimitPerIndex", kTries},
        {"podFailurePolicy",
         {{"rules",
           {{{"action", "Ignore"},
             {"onPodConditions", {{{"type", "DisruptionTarget"}, {"status", "True"}}}}}}}}}};
    tasks["spec"]["template"] =
        pod(job.name, job.tasks_name, bash(job.task_body("$JOB_COMPLETION_INDEX")), job.cpus,
            job.memory_mib, place);
    tasks["spec"]["template"]["spec"]["restartPolicy"] = "Never";

    // Jobs cannot be ordered: the join itself waits.
    Json join{
        {"apiVersion", "batch/v1"}, {"kind", "Job"}, {"metadata", meta(job.name, job.join_name)}};
    join["spec"] = {{"completions", 1}, {"backoffLimit", kTries}};
    join["spec"]["template"] = pod(job.name, job.join_name, bash(job.waiting_join_body),
                                   job.join_cpus, job.join_memory_mib, place);
    join["spec"]["template"]["spec"]["restartPolicy"] = "Never";
    return to_list(Json::array({tasks, join}));
}

std::string kubernetes_pool(const std::string& name, const Command& render, int cpus,
                            int memory_mib, const PodPlace& place) {
    place.check(name);
    Json service{
        {"apiVersion", "v1"}, {"kind", "Service"}, {"metadata", meta(name, "coordinator")}};
    service["spec"] = {{"clusterIP", "None"},
                       {"publishNotReadyAddresses", true},
                       {"selector", meta(name, "coordinator")["labels"]},
                       {"ports", {{{"name", "farm"}, {"port", kPort}, {"targetPort", kPort}}}}};

    Command coordinator = render;
    coordinator.insert(coordinator.end(), {"--listen", ":" + std::to_string(kPort)});
    Json job{{"apiVersion", "batch/v1"}, {"kind", "Job"}, {"metadata", meta(name, "coordinator")}};
    job["spec"] = {{"completions", 1}, {"backoffLimit", kTries}};
    job["spec"]["template"] =
        pod(name, "coordinator", arguments(coordinator), cpus, memory_mib, place);
    job["spec"]["template"]["spec"]["restartPolicy"] = "Never";
    job["spec"]["template"]["spec"]["containers"][0]["ports"] =
        Json::array({{{"name", "farm"}, {"containerPort", kPort}}});
    give_token(job["spec"]["template"], name);

    // They end with the picture (--once).
    const Command worker{render.front(),
                         "worker",
                         "--once",
                         "--join",
                         name + "-coordinator:" + std::to_string(kPort),
                         "--threads",
                         std::to_string(cpus),
                         "--memory-mib",
                         std::to_string(std::max(1, memory_mib / 4 * 3))};
    Json workers{{"apiVersion", "batch/v1"}, {"kind", "Job"}, {"metadata", meta(name, "worker")}};
    workers["spec"] = {{"completions", place.nodes},
                       {"parallelism", place.nodes},
                       {"backoffLimit", kTries * place.nodes}};
    workers["spec"]["template"] = pod(name, "worker", arguments(worker), cpus, memory_mib, place);
    workers["spec"]["template"]["spec"]["restartPolicy"] = "Never";
    give_token(workers["spec"]["template"], name);
    return to_list(Json::array({service, job, workers}));
}

}  // namespace terravox::cluster
