#include "voxelserver/serve/http/route_answers.hpp"

#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "common/voxel/analysis.hpp"
#include "voxelserver/serve/http/file_reply.hpp"
#include "voxelserver/serve/jobs/job_queue.hpp"

namespace terravox::http {
namespace {

using nlohmann::json;

constexpr const char* kOff =
    "this server makes no analyses; its operator turns them on by the option --jobs";

std::string_view to_word(jobs::JobState state) {
    switch (state) {
        case jobs::JobState::kWaiting: return "waiting";
        case jobs::JobState::kRunning: return "running";
        case jobs::JobState::kDone: return "done";
        case jobs::JobState::kFailed: return "failed";
    }
    return {};
}

json to_json(const jobs::JobStatus& job) {
    json out = {{"id", job.id},
                {"kind", job.kind},
                {"state", to_word(job.state)},
                {"progress", job.progress}};
    if (job.state == jobs::JobState::kWaiting)
        out["before"] = job.before;
    if (job.state == jobs::JobState::kFailed || !job.message.empty())
        out["message"] = without_folders(job.message);
    if (job.state == jobs::JobState::kDone) {
        out["holes"] = job.has_holes;
        out["bytes"] = job.bytes;
        out["result"] = "v2/jobs/" + job.id + "/result.tif";
    }
    return out;
}

std::string text_of_json(const json& value) {
    return value.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

Response no_such_job() {
    return problem(404, "no such job; it was deleted, or is older than finished jobs are kept");
}

Response submit(jobs::JobQueue& queue, const Service& service, const RouteRequest& call) {
    jobs::JobRequest request;
    try {
        request = jobs::read_job_request(call.request.body, service.world.info(), queue.limits());
    } catch (const util::UsageError& e) {
        return problem(400, e.what());
    }
    const auto id = queue.submit(std::move(request));
    if (!id)
        return problem(503, "too many jobs wait, or the server has no room for a result")
            .add("Retry-After", "30");
    jobs::JobStatus status;
    status.id = *id;
    if (const auto now = queue.status(*id))
        status = *now;
    Response out = reply(201, "application/json", text_of_json(to_json(status)));
    return out.add("Location", "jobs/" + *id).add("Cache-Control", "no-store");
}

}  // namespace

nlohmann::json jobs_json(jobs::JobQueue* queue) {
    if (queue == nullptr)
        return {};
    const jobs::JobCounts counts = queue->counts();
    const jobs::JobLimits& limits = queue->limits();
    json analyses = json::array();
    for (const voxel::AnalysisTerms& terms : voxel::kAnalyses) {
        if (terms.help.empty())
            continue;
        analyses.push_back({{"kind", terms.name},
                            {"title", terms.title},
                            {"surface", terms.reads("analysis.surface")},
                            {"days", terms.reads("sun.date")},
                            {"observers", terms.reads("analysis.target_m")}});
    }
    return {{"kinds", voxel::list_analyses()}, {"analyses", analyses},
            {"max_cells", limits.max_cells},   {"max_minutes", limits.max_minutes},
            {"waiting", counts.waiting},       {"running", counts.running}};
}

Response answer_jobs(Service& service, const RouteRequest& call) {
    if (service.jobs == nullptr)
        return problem(404, kOff);
    if (call.request.method == "POST")
        return submit(*service.jobs, service, call);
    return json_reply(text_of_json(jobs_json(service.jobs)), call.request);
}

Response answer_job(Service& service, const RouteRequest& call) {
    if (service.jobs == nullptr)
        return problem(404, kOff);
    const std::string id(call.parts.part[2]);
    if (call.request.method == "DELETE") {
        if (!service.jobs->remove(id))
            return no_such_job();
        Response out;
        out.status = 204;
        return out;
    }
    const auto status = service.jobs->status(id);
    return status ? json_reply(text_of_json(to_json(*status)), call.request) : no_such_job();
}

Response answer_job_result(Service& service, const RouteRequest& call) {
    if (service.jobs == nullptr)
        return problem(404, kOff);
    const std::string id(call.parts.part[2]);
    const auto file = service.jobs->result(id);
    if (!file)
        return service.jobs->status(id) ? problem(404, "the job is not done") : no_such_job();
    // A job has one result, which never changes.
    const std::string etag = "\"" + id + "\"";
    const std::optional<OpenFile> opened = open_file(*file, false);
    if (!opened)
        return no_such_job();
    Response out = file_reply(call.request, *opened, etag, "image/tiff");
    if (out.file)
        out.add("Content-Disposition", "attachment; filename=\"terravox.tif\"");
    return out;
}

}  // namespace terravox::http
