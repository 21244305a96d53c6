#pragma once

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// GET /healthz: 200 text, whether boxes can be made; 503. The state is public; the reason of a
/// failure may contain file names, and is sent only to clients with the token.
[[nodiscard]] Response answer_health(const Service& service, const RouteRequest& call);

/// GET /v2/cached/{level}: 200 JSON, the boxes of a level that are cached in memory and on disk;
/// 400, 404.
[[nodiscard]] Response answer_cached(Service& service, const RouteRequest& call);

/// GET /v2/stats: 200 JSON.
/// @param counts counts of the router
/// @param uptime_s uptime of the router
[[nodiscard]] Response answer_stats(Service& service, const RouteRequest& call,
                                    const RequestCounts& counts, double uptime_s);

/// GET /metrics: 200, the text format of Prometheus, version 0.0.4. The values are maintained
/// elsewhere and only formatted here.
[[nodiscard]] Response answer_metrics(Service& service, const RequestCounts& counts,
                                      double uptime_s);

}  // namespace terravox::http
