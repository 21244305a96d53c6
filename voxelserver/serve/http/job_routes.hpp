#pragma once

#include <nlohmann/json_fwd.hpp>

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// Limits of jobs, and how many there are, as a JSON object; null where the server makes none.
[[nodiscard]] nlohmann::json jobs_json(jobs::JobQueue* queue);

/// GET /v2/jobs: 200 JSON, the limits of jobs and how many there are; POST: 201 JSON, the state of
/// a new job, with its address in Location; 400, 503. Both 404 where the server makes no analyses.
[[nodiscard]] Response answer_jobs(Service& service, const RouteRequest& call);

/// GET /v2/jobs/{id}: 200 JSON, the state of a job; DELETE: 204, it ends and its files are removed;
/// 404.
[[nodiscard]] Response answer_job(Service& service, const RouteRequest& call);

/// GET /v2/jobs/{id}/result.tif: 200 or 206, the raster of a job that is done; 404, 416.
[[nodiscard]] Response answer_job_result(Service& service, const RouteRequest& call);

}  // namespace terravox::http
