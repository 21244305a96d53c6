#include "voxelserver/http/routes.hpp"

namespace terravox::http {
namespace {

constexpr std::size_t kBatchBytes = std::size_t{256} << 10;

constexpr std::array<RouteFacts, kRouteCount> kRoutes = {{
    {Route::kPage, "/", false, true},
    {Route::kPageFile, "/page/{name}", false, true},
    {Route::kView, "/view", false, true},
    {Route::kViewPage, "/view/", false, true},
    {Route::kViewPlace, "/view/place.json"},
    {Route::kViewAppearance, "/view/appearance.bin", false, true},
    {Route::kViewFile, "/view/viewer/{file}", false, true},
    {Route::kHealth, "/healthz", false, true},
    {Route::kWorld, "/v2/world"},
    {Route::kBox, "/v2/boxes/{level}/{bx}/{by}/{bz}"},
    {Route::kBatch, "/v2/boxes", true, false, kBatchBytes},
    {Route::kColumn, "/v2/columns/{level}/{bx}/{bz}"},
    {Route::kSquares, "/v2/squares"},
    {Route::kCached, "/v2/cached/{level}"},
    {Route::kStats, "/v2/stats"},
    {Route::kMetrics, "/metrics"},
    {Route::kOpenApi, "/openapi.json"},
    {Route::kMapTile, "/map/{z}/{x}/{y}.png"},
    {Route::kGkotBox, "/gkot/box"},
    {Route::kGkotOrigin, "/gkot/origin.json"},
    {Route::kUnknown, "unknown"},
    {Route::kRefused, "refused", false, true},
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

std::span<const RouteFacts> routes() noexcept {
    return kRoutes;
}

const RouteFacts& facts_of(Route route) noexcept {
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

Route route_of(const PathParts& parts) noexcept {
    for (const RouteFacts& r : kRoutes)
        if (fits(r.path, parts))
            return r.route;
    return Route::kUnknown;
}

RouteMatch match_route(std::string_view path) noexcept {
    const auto parts = split_path(path);
    if (!parts)
        return {facts_of(Route::kUnknown), {}};
    return {facts_of(route_of(*parts)), *parts};
}

}  // namespace terravox::http
