#include "voxelserver/http/router.hpp"

#include <spdlog/spdlog.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/util/version.hpp"
#include "common/voxel/box_codec.hpp"
#include "common/voxel/world_json.hpp"
#include "voxelserver/http/index_page.hpp"

namespace terravox::http {
namespace {

using nlohmann::json;
using voxel::kBoxSizeY;

std::string to_text(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace) + "\n"; }

Response json_reply(const json& value) {
    Response out = reply(200, "application/json", to_text(value));
    out.headers.push_back({"Cache-Control", "no-store"});
    return out;
}

std::string hash_etag(const std::string& text) {
    char hex[24];
    std::snprintf(hex, sizeof hex, "\"%016llx\"", static_cast<unsigned long long>(XXH64(text.data(), text.size(), 0)));
    return hex;
}

// Kept by a client, but asked for again with If-None-Match each time: the server may have other data tomorrow.
void add_validators(Response& out, const std::string& etag) {
    out.headers.push_back({"ETag", etag});
    out.headers.push_back({"Cache-Control", "no-cache"});
}

Response bare(int status, const std::string& etag) {
    Response out;
    out.status = status;
    add_validators(out, etag);
    return out;
}

std::vector<std::string_view> split(std::string_view path) {
    std::vector<std::string_view> parts;
    if (path.empty() || path.front() != '/') return parts;
    path.remove_prefix(1);
    for (;;) {
        const std::size_t end = path.find('/');
        parts.push_back(path.substr(0, end));
        if (end == std::string_view::npos) return parts;
        path.remove_prefix(end + 1);
    }
}

Route route_of(const std::vector<std::string_view>& parts) {
    const auto is = [&](std::size_t i, std::string_view word) { return i < parts.size() && parts[i] == word; };
    if (parts.size() == 1 && is(0, "")) return Route::kIndex;
    if (parts.size() == 1 && is(0, "healthz")) return Route::kHealth;
    if (!is(0, "v2")) return Route::kUnknown;
    if (parts.size() == 2 && is(1, "world")) return Route::kWorld;
    if (parts.size() == 2 && is(1, "stats")) return Route::kStats;
    if (parts.size() == 6 && is(1, "boxes")) return Route::kBoxes;
    if (parts.size() == 5 && is(1, "columns")) return Route::kColumns;
    return Route::kUnknown;
}

// Only the one usual way to write a number counts, so that a box has one address (no +1, -0, 007).
std::optional<std::int32_t> parse_int32(std::string_view text) {
    std::int32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || std::to_string(value) != text) return std::nullopt;
    return value;
}

template <std::size_t N>
std::optional<std::array<std::int32_t, N>> parse_numbers(const std::vector<std::string_view>& parts) {
    std::array<std::int32_t, N> out{};
    for (std::size_t i = 0; i < N; ++i) {
        const auto number = parse_int32(parts[i + 2]);
        if (!number) return std::nullopt;
        out[i] = *number;
    }
    return out;
}

Response not_numbers(const Request& request) {
    return problem(400, "read the address " + std::string(request.path) + ": not whole numbers from -2147483648 to 2147483647, such as -12");
}

}  // namespace

Router::Router(voxel::World& world, util::StageTimes& times, const BoxRepliesOptions& options)
    : m_world(world),
      m_times(times),
      m_boxes(world, times, options),
      m_world_json(voxel::world_to_json(world.info())),
      m_world_etag(hash_etag(m_world_json)) {}

Response Router::handle(const Request& request) {
    const Parts parts = split(request.path);
    const Route route = route_of(parts);
    Response out = answer(route, parts, request);
    // A body that is not read must not be taken for the next request.
    if (body_claim(request) != BodyClaim::kNone) out.close = true;
    out.head_only = request.method == "HEAD";
    m_counts.add(route, out.status);
    return out;
}

Response Router::answer(Route route, const Parts& parts, const Request& request) {
    try {
        return dispatch(route, parts, request);
    } catch (const Busy& e) {
        Response out = problem(503, e.what());
        out.headers.push_back({"Retry-After", "1"});
        return out;
    } catch (const std::bad_alloc&) {
        spdlog::error("{} {}: out of memory", request.method, request.path);
        return problem(500, "out of memory");
    } catch (const std::exception& e) {
        spdlog::error("{} {}: {}", request.method, request.path, e.what());
        return problem(500, e.what());
    } catch (...) {
        spdlog::error("{} {}: unknown error", request.method, request.path);
        return problem(500, "unknown error");
    }
}

Response Router::dispatch(Route route, const Parts& parts, const Request& request) {
    const bool readable = request.method == "GET" || request.method == "HEAD";
    const BodyClaim claim = body_claim(request);
    if (claim == BodyClaim::kMalformed) return problem(400, "read the request: a Transfer-Encoding or a malformed Content-Length; allowed: no body");
    if (readable && claim == BodyClaim::kSome) return problem(413, "read the request: it has a body; allowed: none");
    if (route != Route::kUnknown && !readable) {
        Response out = problem(405, "method " + std::string(request.method) + "; allowed: GET, HEAD");
        out.headers.push_back({"Allow", "GET, HEAD"});
        return out;
    }
    switch (route) {
        case Route::kIndex: {
            Response out = reply(200, "text/html; charset=utf-8", index_page(m_world.info()));
            out.headers.push_back({"Content-Security-Policy", "default-src 'none'; style-src 'unsafe-inline'"});
            return out;
        }
        case Route::kHealth: return reply(200, "text/plain; charset=utf-8", "ok\n");
        case Route::kWorld: return world(request);
        case Route::kBoxes: return box(parts, request);
        case Route::kColumns: return column(parts, request);
        case Route::kStats: return stats();
        case Route::kUnknown:
        case Route::kRefused: break;
    }
    return problem(404, "nothing at " + std::string(request.path) + "; / lists what there is");
}

Response Router::no_such_level(int level) const {
    return problem(404, "level " + std::to_string(level) + "; allowed: 0 to " + std::to_string(m_world.info().levels - 1));
}

Response Router::world(const Request& request) const {
    if (etag_matches(request.header("If-None-Match"), m_world_etag)) return bare(304, m_world_etag);
    Response out = reply(200, "application/json", m_world_json);
    add_validators(out, m_world_etag);
    return out;
}

Response Router::box(const Parts& parts, const Request& request) {
    const auto numbers = parse_numbers<4>(parts);
    if (!numbers) return not_numbers(request);
    const auto [level, bx, by, bz] = *numbers;
    if (level < 0 || level >= m_world.info().levels) return no_such_level(level);
    const auto made = m_boxes.get({level, bx, by, bz});
    if (etag_matches(request.header("If-None-Match"), made->etag)) return bare(304, made->etag);
    Response out = bare(made->frame ? 200 : 204, made->etag);
    if (made->frame) out.headers.push_back({"Content-Type", voxel::kBoxMediaType});
    out.body = made->frame;
    return out;
}

Response Router::column(const Parts& parts, const Request& request) {
    const auto numbers = parse_numbers<3>(parts);
    if (!numbers) return not_numbers(request);
    const auto [level, bx, bz] = *numbers;
    if (level < 0 || level >= m_world.info().levels) return no_such_level(level);
    const voxel::ColumnExtent extent = m_world.column(level, bx, bz);
    std::int64_t min_y = 0, max_y = 0;
    if (!extent.empty()) {
        const auto& bounds = m_world.info().bounds;
        const std::int64_t side = std::int64_t{kBoxSizeY} << level;
        min_y = std::max<std::int64_t>(extent.by_begin * side, bounds.min[1]);
        max_y = std::min<std::int64_t>(extent.by_end * side, bounds.max[1]);
    }
    return json_reply({{"by_begin", extent.by_begin}, {"by_end", extent.by_end}, {"min_y", min_y}, {"max_y", max_y}});
}

Response Router::stats() const {
    json stages = json::array();
    for (const auto& s : m_times.stages()) stages.push_back({{"name", s.name}, {"seconds", s.seconds}, {"count", s.count}});
    json requests = json::object();
    const auto counts = m_counts.counts();
    for (std::size_t route = 0; route < kRouteCount; ++route)
        for (const auto& [status, count] : counts[route]) requests[route_name(static_cast<Route>(route))][std::to_string(status)] = count;
    const auto c = m_boxes.stats();
    const json cache = {{"hits", c.hits},   {"misses", c.misses},   {"waits", c.waits}, {"evictions", c.evictions},
                        {"bytes", c.bytes}, {"entries", c.entries}, {"limit_bytes", m_boxes.limit_bytes()}};
    return json_reply({{"version", kVersion},
                       {"uptime_s", std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count()},
                       {"stages", stages},
                       {"cache", cache},
                       {"requests", requests}});
}

}  // namespace terravox::http
