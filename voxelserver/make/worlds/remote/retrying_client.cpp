#include "voxelserver/make/worlds/remote/retrying_client.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>

#include "common/util/json_text.hpp"
#include "common/util/log.hpp"
#include "common/voxel/world.hpp"

namespace terravox::remote {

std::optional<FailureKind> to_failure_kind(long status) noexcept {
    switch (status) {
        case 429:
        case 502:
        case 503:
        case 504: return FailureKind::kBusy;
        case 500: return FailureKind::kFailed;
        default: return std::nullopt;
    }
}

std::string find_problem(const HttpReply& reply) {
    std::string reason = "no reason given";
    const std::string_view text(reinterpret_cast<const char*>(reply.body.data()),
                                std::min<std::size_t>(reply.body.size(), 2000));
    const auto json = util::parse_json(text);
    if (json.is_object() && json.contains("detail") && json["detail"].is_string())
        reason = json["detail"].get<std::string>();
    std::replace_if(
        reason.begin(), reason.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
    if (!reply.redirected_to.empty())
        reason += ", from " + reply.redirected_to + ", where the address redirects to";
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

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kMaxStalled{
    120'000};                      // a cold square may take a while before the first byte
constexpr int kGivenUpInRow = 16;  // then the server counts as unreachable, until a reply comes
constexpr int kHopelessShare = 20;

}  // namespace

bool RetryingClient::is_reachable() const noexcept {
    return m_given_up.load(std::memory_order_relaxed) < kGivenUpInRow;
}

RetryingClient::Request RetryingClient::begin(Milliseconds timeout) const {
    const bool hope = is_reachable();
    if (!hope)
        timeout = std::max(timeout / kHopelessShare, std::min(timeout, milliseconds{1000}));
    const auto stalled =
        std::chrono::ceil<std::chrono::seconds>(std::min(timeout / 2, kMaxStalled));
    return {timeout, std::max(stalled, std::chrono::seconds{1}),
            Retry(m_client.now(), timeout, hope)};
}

HttpLimits RetryingClient::limits(const Request& request, std::size_t max_bytes) const {
    return {request.retry.time_left(m_client.now()), request.stalled, max_bytes};
}

void RetryingClient::check(const std::string& url, const HttpReply& reply, bool on_condition) {
    if (reply.status == 200 || reply.status == 204 || reply.status == 206)
        return;
    if (on_condition && (reply.status == 412 || reply.status == 416))
        return;
    const std::string what = "fetch " + url + ": " + find_problem(reply);
    if (const auto kind = to_failure_kind(reply.status))
        throw FailedTry(*kind, what, reply.retry_after);
    on_reply();
    if (reply.status == 412)
        throw voxel::ChangedError(what + "; start again");
    throw util::Error(what);
}

void RetryingClient::wait_or_give_up(const std::string& url, Request& request,
                                     const FailedTry& failed) {
    const auto wait =
        request.retry.wait_after(failed.kind, m_client.now(), failed.retry_after, chance());
    if (!wait)
        give_up(failed, request);
    util::log_debug("{}; trying again in {} ms", failed.what(), wait->count());
    m_client.wait(url, *wait);
}

void RetryingClient::give_up(const FailedTry& failed, const Request& request) {
    // A 500 comes from a server that is alive.
    if (failed.kind == FailureKind::kFailed)
        on_reply();
    else
        m_given_up.fetch_add(1, std::memory_order_relaxed);
    const int tries = request.retry.tries();
    throw util::Error("{}; given up after {}{}, timeout {} s", failed.what(), tries,
                      tries == 1 ? " try" : " tries",
                      std::chrono::ceil<std::chrono::seconds>(request.timeout).count());
}

}  // namespace terravox::remote
