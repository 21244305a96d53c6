#include "voxelserver/make/worlds/remote/failed_try.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>

#include "common/util/json_text.hpp"

namespace terravox::remote {

std::optional<FailureKind> failure_kind_of(long status) noexcept {
    switch (status) {
        case 429:
        case 502:
        case 503:
        case 504: return FailureKind::kBusy;
        case 500: return FailureKind::kFailed;
        default: return std::nullopt;
    }
}

std::string problem_of(const HttpReply& reply) {
    std::string reason = "no reason given";
    const std::string_view text(reinterpret_cast<const char*>(reply.body.data()),
                                std::min<std::size_t>(reply.body.size(), 2000));
    const auto json = util::parse_json(text);
    if (json.is_object() && json.contains("detail") && json["detail"].is_string())
        reason = json["detail"].get<std::string>();
    std::replace_if(
        reason.begin(), reason.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
    // A token is never sent just because an address was named: the message explains what to do.
    constexpr long kUnauthorized = 401;
    if (reply.status == kUnauthorized && !reply.showed_token)
        reason +=
            "; no token was sent: allowed: one that is bound to this origin "
            "(TERRAVOX_SERVER_ORIGIN; of a worker: server_origin)";
    return "HTTP status " + std::to_string(reply.status) + ", " + reason;
}

double chance() {
    thread_local std::minstd_rand random(std::random_device{}());
    return std::uniform_real_distribution<double>(0, 1)(random);
}

}  // namespace terravox::remote
