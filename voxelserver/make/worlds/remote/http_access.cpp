#include "voxelserver/make/worlds/remote/http_access.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/secret.hpp"

namespace terravox::remote {
namespace {

constexpr const char* kOriginVariable = "TERRAVOX_SERVER_ORIGIN";

bool contains(const std::vector<HttpOrigin>& origins, const HttpOrigin& origin) {
    return std::find(origins.begin(), origins.end(), origin) != origins.end();
}

/// Whether clear text sent there stays on this machine. A name that suggests so is checked again
/// when the connection is made.
bool is_loopback(const HttpOrigin& origin) {
    const auto range = range_of_number(origin);
    return range ? *range == AddressRange::kLoopback : origin.host == "localhost";
}

}  // namespace

BoundToken::BoundToken(HttpOrigin origin, std::string text)
    : m_origin(std::move(origin)), m_text(std::move(text)) {
    if (!m_origin.tls && !is_loopback(m_origin))
        throw util::UsageError(
            "bind a token to " + m_origin.text() +
            ": it would go over the network in clear text; allowed: https, or http to localhost");
}

AddressRanges HttpAccess::ranges(const HttpOrigin& origin) const {
    AddressRanges out = kAnyRange;
    if (limits) {
        if (contains(limits->private_origins, origin))
            out = {AddressRange::kPublic, AddressRange::kPrivate, AddressRange::kLoopback};
        else if (contains(limits->origins, origin))
            out = {AddressRange::kPublic};
        else
            out = {};
    }
    // "localhost" may resolve to another machine after all.
    const bool in_clear_text = token && token->origin() == origin && !origin.tls;
    if (in_clear_text)
        out = out.holds(AddressRange::kLoopback) ? AddressRanges{AddressRange::kLoopback}
                                                 : AddressRanges{};
    return out;
}

const char* HttpAccess::allowed() const noexcept {
    return limits ? "origins of allow_origins that lead to public addresses, and of "
                    "allow_private_origins"
                  : "addresses of loopback, since a token goes there in clear text";
}

HttpAccess access_of_environment() {
    HttpAccess out;
    std::string token = util::find_token({}, util::kServerTokenVariable);
    const char* origin = std::getenv(kOriginVariable);
    if (origin == nullptr || *origin == '\0')
        return out;
    const std::string attempt =
        std::string("read the environment variable ") + kOriginVariable + ": ";
    if (token.empty())
        throw util::UsageError(attempt + util::kServerTokenVariable +
                               " is not set; allowed: both, or neither");
    try {
        out.token.emplace(HttpOrigin::parse(origin), std::move(token));
    } catch (const util::UsageError& e) {
        throw util::UsageError(attempt + e.what());
    }
    return out;
}

}  // namespace terravox::remote
