#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "common/util/shell_words.hpp"
#include "raytracer/farm/cluster/manifests.hpp"

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

}  // namespace terravox::cluster
