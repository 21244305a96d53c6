#include "voxelserver/serve/http/routes.hpp"

namespace terravox::http {
namespace {

constexpr std::size_t kBatchBytes = std::size_t{256} << 10;
constexpr std::size_t kJobBytes = std::size_t{4} << 10;

constexpr std::array<RouteFacts, kRouteCount> kRoutes = {{
    {Route::kPage, "/", Methods::kGet, true},
    {Route::kPageFile, "/page/{name}", Methods::kGet, true},
    {Route::kView, "/view", Methods::kGet, true},
    {Route::kViewPage, "/view/", Methods::kGet, true},
    {Route::kViewPlace, "/view/place.json"},
    {Route::kViewAppearance, "/view/appearance.bin", Methods::kGet, true},
    {Route::kViewFile, "/view/viewer/{file}", Methods::kGet, true},
    {Route::kHealth, "/healthz", Methods::kGet, true},
    {Route::kWorld, "/v2/world"},
    {Route::kBox, "/v2/boxes/{level}/{bx}/{by}/{bz}"},
    {Route::kBatch, "/v2/boxes", Methods::kPost, false, kBatchBytes},
    {Route::kArchive, "/v2/archive.tvx", Methods::kGet, false, 0, true},
    {Route::kColumn, "/v2/columns/{level}/{bx}/{bz}"},
    {Route::kSquares, "/v2/squares"},
    {Route::kCached, "/v2/cached/{level}"},
    {Route::kStats, "/v2/stats"},
    {Route::kMetrics, "/metrics"},
    {Route::kOpenApi, "/openapi.json"},
    {Route::kMapTile, "/map/{z}/{x}/{y}.png"},
    {Route::kGkotBox, "/gkot/box"},
    {Route::kGkotOrigin, "/gkot/origin.json"},
    {Route::kJobs, "/v2/jobs", Methods::kGetPost, false, kJobBytes},
    {Route::kJob, "/v2/jobs/{id}", Methods::kGetDelete},
    {Route::kJobResult, "/v2/jobs/{id}/result.tif"},
    {Route::kUnknown, "unknown"},
    {Route::kRefused, "refused", Methods::kGet, true},
}};

constexpr bool in_order() {
    for (std::size_t i = 0; i < kRouteCount; ++i)
        if (static_cast<std::size_t>(kRoutes[i].route) != i)
            return false;
    return true;
}
static_assert(in_order());

// "{y}.png" matches anything that ends in ".png".
bool part_fits(std::string_view pattern, std::string_view part) noexcept {
    if (pattern.empty() || pattern.front() != '{')
        return pattern == part;
    const std::string_view tail = pattern.substr(pattern.find('}') + 1);
    return part.size() >= tail.size() && part.substr(part.size() - tail.size()) == tail;
}

bool fits(std::string_view pattern, const PathParts& parts) noexcept {
    const auto wanted = split_path(pattern);
    if (!wanted || wanted->count != parts.count)
        return false;
    for (std::size_t i = 0; i < parts.count; ++i)
        if (!part_fits(wanted->part[i], parts.part[i]))
            return false;
    return true;
}

}  // namespace

std::string_view to_text(Methods methods) noexcept {
    switch (methods) {
        case Methods::kGet: return "GET, HEAD";
        case Methods::kPost: return "POST";
        case Methods::kGetPost: return "GET, HEAD, POST";
        case Methods::kGetDelete: return "GET, HEAD, DELETE";
    }
    return {};
}

bool is_allowed(Methods methods, std::string_view method) noexcept {
    switch (methods) {
        case Methods::kPost: return method == "POST";
        case Methods::kGetPost:
            if (method == "POST")
                return true;
            break;
        case Methods::kGetDelete:
            if (method == "DELETE")
                return true;
            break;
        case Methods::kGet: break;
    }
    return method == "GET" || method == "HEAD";
}

std::span<const RouteFacts> routes() noexcept {
    return kRoutes;
}

const RouteFacts& collect_facts(Route route) noexcept {
    return kRoutes[static_cast<std::size_t>(route)];
}

std::optional<PathParts> split_path(std::string_view path) noexcept {
    if (path.empty() || path.front() != '/')
        return std::nullopt;
    path.remove_prefix(1);
    PathParts out;
    for (;;) {
        if (out.count == out.part.size())
            return std::nullopt;
        const std::size_t end = path.find('/');
        out.part[out.count++] = path.substr(0, end);
        if (end == std::string_view::npos)
            return out;
        path.remove_prefix(end + 1);
    }
}

Route find_route(const PathParts& parts) noexcept {
    for (const RouteFacts& r : kRoutes)
        if (fits(r.path, parts))
            return r.route;
    return Route::kUnknown;
}

RouteMatch match_route(std::string_view path) noexcept {
    const auto parts = split_path(path);
    if (!parts)
        return {collect_facts(Route::kUnknown), {}};
    return {collect_facts(find_route(*parts)), *parts};
}

}  // namespace terravox::http
