#include "voxelserver/http/router.hpp"

#include <spdlog/spdlog.h>
#include <xxhash.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/util/stage_times.hpp"
#include "common/voxel/unreachable_error.hpp"
#include "common/voxel/world_json.hpp"
#include "voxelserver/http/batch_route.hpp"
#include "voxelserver/http/box_routes.hpp"
#include "voxelserver/http/gkot_routes.hpp"
#include "voxelserver/http/map_route.hpp"
#include "voxelserver/http/page_routes.hpp"
#include "voxelserver/http/state_routes.hpp"
#include "voxelserver/map/map_tiles.hpp"

namespace terravox::http {
namespace {

// The world as the format has it, and where its map is.
std::string world_text(const voxel::WorldInfo& info) {
    auto json = nlohmann::json::parse(voxel::world_to_json(info));
    json["map"] = {{"tile_px", map::kTilePx}, {"zooms", {0, info.levels - 1}}};
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

// As long for every token: the time must not tell how much of it was right.
bool same_secret(std::string_view given, std::string_view wanted) noexcept {
    unsigned difference = given.size() == wanted.size() ? 0 : 1;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        difference |= static_cast<unsigned char>(wanted[i]) ^
                      static_cast<unsigned char>(given.empty() ? 0 : given[i % given.size()]);
    return difference == 0;
}

// Two machines on the way of a request must not read it differently. Ref: RFC 9112, 3.2 and 5.1.
std::string fault_of(const Request& request) {
    const auto is_token = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
    };
    for (const Header& h : request.headers)
        if (h.name.empty() || !std::all_of(h.name.begin(), h.name.end(), is_token))
            return "a header's name is no token";
    const auto hosts = std::count_if(request.headers.begin(), request.headers.end(),
                                     [](const Header& h) { return same_word(h.name, "Host"); });
    if (hosts > 1)
        return std::to_string(hosts) + " headers Host; allowed: one";
    return {};
}

Response not_allowed(const RouteFacts& route, const Request& request) {
    const std::string allowed = route.post ? "POST" : "GET, HEAD";
    return problem(405, "method " + std::string(request.method) + "; allowed: " + allowed)
        .add("Allow", allowed);
}

}  // namespace

Router::Router(Service service, std::string token, sockets::HttpNames names)
    : m_service(std::move(service)),
      m_token(std::move(token)),
      m_names(std::move(names)),
      m_world_json(world_text(m_service.world.info())),
      m_world_etag(etag_of(XXH64(m_world_json.data(), m_world_json.size(), 0), "w")) {}

std::optional<Response> Router::refusal(const Request& request) {
    const auto split = split_path(request.path);
    const RouteFacts& route = facts_of(split ? route_of(*split) : Route::kUnknown);
    std::optional<Response> out = refuse_head(route, request);
    if (!out)
        return out;
    if (body_claim(request).kind != BodyClaim::Kind::kNone)
        out->close = true;
    out->head_only = request.method == "HEAD";
    m_counts.add(route.route, out->status, 0);
    return out;
}

Response Router::handle(const Request& request) {
    const util::Stopwatch clock;
    const auto split = split_path(request.path);
    const PathParts parts = split.value_or(PathParts{});
    const RouteFacts& route = facts_of(split ? route_of(parts) : Route::kUnknown);
    Response out = answer(route, request, parts);
    // A body that was not read must not be taken for the next request.
    if (const BodyClaim claim = body_claim(request);
        claim.kind == BodyClaim::Kind::kMalformed || claim.bytes != request.body.size())
        out.close = true;
    out.head_only = request.method == "HEAD";
    m_counts.add(route.route, out.status, clock.seconds());
    return out;
}

Response Router::answer(const RouteFacts& route, const Request& request, const PathParts& parts) {
    try {
        if (auto refused = refuse_head(route, request))
            return std::move(*refused);
        return dispatch(route.route, {request, parts, has_token(request)});
    } catch (const boxes::OverloadedError& e) {
        return problem(503, e.what()).add("Retry-After", "1");
    } catch (const voxel::UnreachableError& e) {
        // Its address is the business of the person who started the server.
        spdlog::error("{} {}: {}", request.method, request.path, e.what());
        return problem(502, kUnreachable).add("Retry-After", "5");
    } catch (const std::bad_alloc&) {
        spdlog::error("{} {}: out of memory", request.method, request.path);
        return problem(500, "out of memory");
    } catch (const std::exception& e) {
        spdlog::error("{} {}: {}", request.method, request.path, e.what());
        return problem(500, without_folders(e.what()));
    } catch (...) {
        spdlog::error("{} {}: unknown error", request.method, request.path);
        return problem(500, "unknown error");
    }
}

bool Router::has_token(const Request& request) const {
    const std::string given = request.header("Authorization");
    constexpr std::string_view kScheme = "Bearer ";
    return !m_token.empty() && given.size() > kScheme.size() &&
           same_word(std::string_view(given).substr(0, kScheme.size()), kScheme) &&
           same_secret(std::string_view(given).substr(kScheme.size()), m_token);
}

std::optional<Response> Router::refuse_head(const RouteFacts& route, const Request& request) const {
    using Kind = BodyClaim::Kind;
    const auto and_close = [](Response out) {
        out.close = true;
        return out;
    };
    if (const std::string wrong = fault_of(request); !wrong.empty())
        return and_close(problem(400, "read the request: " + wrong));
    const std::string host = request.header("Host");
    // HTTP/1.0 may leave it out; browsers never do.
    if (request.has_header("Host") && !m_names.allow(host))
        return and_close(problem(421, "read the request: the host '" + host +
                                          "' is no name of this server; allowed: localhost, a "
                                          "numeric address, or a name given by --public-name"));
    if (sockets::from_another_origin(
            {host, request.header("Origin"), request.header("Sec-Fetch-Site"),
             request.header("Sec-Fetch-Mode"), request.header("Sec-Fetch-Dest")}))
        return and_close(problem(403,
                                 "read the request: a web page of another origin makes it; "
                                 "allowed: the server's own page, and programs"));
    const bool readable = request.method == "GET" || request.method == "HEAD";
    const BodyClaim claim = body_claim(request);
    if (claim.kind == Kind::kMalformed)
        return problem(400,
                       "read the request: a Transfer-Encoding, two Content-Lengths, or one that is "
                       "no number; allowed: none, or one number");
    const std::size_t most = route.post && request.method == "POST" ? route.max_body_bytes : 0;
    if (claim.bytes > most)
        return problem(
            413, "read the request: a body of " + std::to_string(claim.bytes) +
                     " bytes; allowed: " + (most > 0 ? "up to " + std::to_string(most) : "none"));
    if (!route.open && !m_token.empty() && !has_token(request))
        return problem(401, "the request has no valid token; allowed: Authorization: Bearer TOKEN")
            .add("WWW-Authenticate", "Bearer");
    if (route.route == Route::kUnknown)
        return problem(
            404, "nothing at " + std::string(request.path) + "; /openapi.json lists what there is");
    if (route.post ? request.method != "POST" : !readable)
        return not_allowed(route, request);
    // A body that comes nevertheless must not be taken for the next request.
    if (route.post && claim.kind == Kind::kNone)
        return and_close(problem(411, "read the request: no Content-Length, or 0; allowed: 1 to " +
                                          std::to_string(most)));
    return std::nullopt;
}

// The state is for everybody who watches; the reason names files.
Response Router::health(const RouteRequest& asked) const {
    const Health now = m_service.health();
    if (now.state == Health::State::kFailed)
        return problem(503,
                       asked.has_token
                           ? "failed: " + without_folders(now.reason)
                           : "failed: only kept boxes can be served; the server's log says why")
            .add("Retry-After", "60");
    return reply(200, "text/plain; charset=utf-8",
                 now.state == Health::State::kOpening ? "opening\n" : "ok\n")
        .add("Cache-Control", "no-store");
}

Response Router::dispatch(Route route, const RouteRequest& asked) {
    const std::string wanted = asked.request.header(kEditionHeader);
    if (!wanted.empty() && wanted != m_service.edition)
        return problem(412,
                       "the world is of another edition than the request wants; allowed: that of "
                       "/v2/world, or no header " +
                           std::string(kEditionHeader));
    const auto uptime_s = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
    };
    switch (route) {
        case Route::kPage:
        case Route::kPageFile: return answer_page(asked);
        case Route::kOpenApi: return answer_open_api(asked);
        case Route::kHealth: return health(asked);
        case Route::kWorld: return world(asked.request);
        case Route::kBox: return answer_box(m_service, asked);
        case Route::kBatch: return answer_batch(m_service, asked);
        case Route::kColumn: return answer_column(m_service, asked);
        case Route::kSquares:
            return json_reply(squares_json(m_service.squares(), m_service.world.info()),
                              asked.request);
        case Route::kCached: return answer_cached(m_service, asked);
        case Route::kStats: return answer_stats(m_service, asked, m_counts, uptime_s());
        case Route::kMetrics: return answer_metrics(m_service, m_counts, uptime_s());
        case Route::kMapTile: return answer_map_tile(m_service, asked);
        case Route::kGkotBox: return answer_gkot_box(m_service, asked);
        case Route::kGkotOrigin: return answer_gkot_origin(m_service, asked);
        case Route::kUnknown:
        case Route::kRefused: break;
    }
    return problem(404, "nothing there");
}

Response Router::world(const Request& request) const {
    if (etag_matches(request.header("If-None-Match"), m_world_etag))
        return not_modified(m_world_etag);
    Response out = reply(200, "application/json", m_world_json);
    add_validators(out, m_world_etag);
    if (!m_service.edition.empty())
        out.add(kEditionHeader, m_service.edition);
    return out;
}

}  // namespace terravox::http
