#include "voxelserver/serve/http/router.hpp"

#include "common/util/stage_times.hpp"
#include "voxelserver/serve/http/error_reply.hpp"

namespace terravox::http {
namespace {

// An unread body must not be parsed as the next request.
bool leaves_body_unread(const Request& request) {
    const BodyClaim claim = body_claim(request);
    return claim.kind == BodyClaim::Kind::kMalformed || claim.bytes != request.body.size();
}

}  // namespace

Router::Router(Service service, std::string token, sockets::HttpNames names, SharedOrigins origins)
    : m_origins(std::move(origins)),
      m_check(std::move(token), std::move(names), m_origins),
      m_dispatcher(std::move(service), m_counts) {}

std::optional<Response> Router::refusal(const Request& request) {
    const RouteFacts& route = match_route(request.path).facts;
    std::optional<Response> out = m_check.refusal(route, request);
    if (!out)
        return out;
    m_counts.add(route.route, out->status, 0);
    return fit_to(route, request, std::move(*out));
}

Response Router::handle(const Request& request) {
    const util::Stopwatch clock;
    const RouteMatch match = match_route(request.path);
    Response out = fit_to(match.facts, request, answer(match, request));
    m_counts.add(match.facts.route, out.status, clock.seconds());
    return out;
}

Response Router::answer(const RouteMatch& match, const Request& request) {
    try {
        if (auto refused = m_check.refusal(match.facts, request))
            return std::move(*refused);
        return m_dispatcher.run(match.facts.route,
                                {request, match.parts, m_check.has_token(request)});
    } catch (...) {
        return reply_to_current_exception(request);
    }
}

Response Router::fit_to(const RouteFacts& route, const Request& request, Response out) const {
    if (leaves_body_unread(request))
        out.close = true;
    out.head_only = request.method == "HEAD";
    if (route.shared)
        m_origins.add_headers(request, out);
    return out;
}

}  // namespace terravox::http
