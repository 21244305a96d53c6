#include "voxelserver/serve/http/shared_origins.hpp"

#include <algorithm>

#include "common/util/error.hpp"

namespace terravox::http {
namespace {

constexpr std::string_view kAny = "*";

// As browsers write an origin: lower case, no path, no default port is added.
bool is_origin(std::string_view text) noexcept {
    constexpr std::size_t kMax_bytes = 300;
    if (text.size() > kMax_bytes)
        return false;
    for (const std::string_view scheme : {"https://", "http://"})
        if (text.starts_with(scheme)) {
            const std::string_view host = text.substr(scheme.size());
            const auto fits = [](char c) {
                return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.' ||
                       c == ':' || c == '[' || c == ']';
            };
            return !host.empty() && std::all_of(host.begin(), host.end(), fits);
        }
    return false;
}

}  // namespace

SharedOrigins::SharedOrigins(std::vector<std::string> origins) : m_origins(std::move(origins)) {
    for (const std::string& origin : m_origins)
        if (!is_origin(origin) && (origin != kAny || m_origins.size() > 1))
            throw util::UsageError("share the archive with pages of '" + origin +
                                   "'; allowed: origins such as https://example.org, in lower "
                                   "case, without a path; or * alone");
}

bool SharedOrigins::is_any() const noexcept {
    return m_origins.size() == 1 && m_origins.front() == kAny;
}

bool SharedOrigins::allow(std::string_view origin) const noexcept {
    if (origin.empty())
        return false;
    return is_any() || std::find(m_origins.begin(), m_origins.end(), origin) != m_origins.end();
}

void SharedOrigins::add_headers(const Request& request, Response& reply) const {
    if (m_origins.empty())
        return;
    const std::string origin = request.header("Origin");
    // Caches must not give the reply for one page, or for no page, to another one.
    if (!is_any())
        reply.add("Vary", "Origin");
    if (!is_any() && !allow(origin))
        return;
    reply.add("Access-Control-Allow-Origin", is_any() ? kAny : std::string_view(origin));
    reply.add("Access-Control-Expose-Headers", "Accept-Ranges, Content-Range, ETag, Retry-After");
}

}  // namespace terravox::http
