#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace terravox::http {

/// The route of a request.
enum class Route {
    kPage,
    kPageFile,
    kView,
    kViewPage,
    kViewPlace,
    kViewAppearance,
    kViewFile,
    kHealth,
    kWorld,
    kBox,
    kBatch,
    kArchive,
    kColumn,
    kSquares,
    kCached,
    kStats,
    kMetrics,
    kOpenApi,
    kMapTile,
    kGkotBox,
    kGkotOrigin,
    kJobs,
    kJob,
    kJobResult,
    kUnknown,  ///< no such path
    kRefused   ///< not a valid request: malformed, too large, too late
};
inline constexpr std::size_t kRouteCount = static_cast<std::size_t>(Route::kRefused) + 1;

/// What may be done with a path.
enum class Methods {
    kGet,  ///< GET and HEAD
    kPost,
    kGetPost,    ///< GET, HEAD and POST
    kGetDelete,  ///< GET, HEAD and DELETE
};
/// The methods as the header Allow has them.
[[nodiscard]] std::string_view to_text(Methods methods) noexcept;
[[nodiscard]] bool is_allowed(Methods methods, std::string_view method) noexcept;

/// Description of one route.
struct RouteFacts {
    Route route = Route::kUnknown;
    /// The path with {names} for its variables; also the name of the route in statistics and in
    /// docs/openapi.json.
    std::string_view path;
    Methods methods = Methods::kGet;
    bool open = false;               ///< requires no token
    std::size_t max_body_bytes = 0;  ///< of POST
    bool shared = false;  ///< pages of origins that the operator names may read it (SharedOrigins)
};
[[nodiscard]] std::span<const RouteFacts> routes() noexcept;
[[nodiscard]] const RouteFacts& collect_facts(Route route) noexcept;

/// The parts of a path between its slashes.
struct PathParts {
    std::array<std::string_view, 6> part;
    std::size_t count = 0;
};
/// @return nullopt for a path that does not begin with a slash, or has more parts than any route
[[nodiscard]] std::optional<PathParts> split_path(std::string_view path) noexcept;
[[nodiscard]] Route find_route(const PathParts& parts) noexcept;

/// The route of a request, and the parts of its path, which are views into it.
struct RouteMatch {
    const RouteFacts& facts;
    PathParts parts;
};
/// @param path as sent
/// @return kUnknown for a path that matches no route; without parts when the path cannot be split
[[nodiscard]] RouteMatch match_route(std::string_view path) noexcept;

}  // namespace terravox::http
