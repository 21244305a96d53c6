#include "raytracer/farm/net/grpc_settings.hpp"

#include <grpc/grpc.h>
#include <grpc/support/log.h>

#include <charconv>
#include <cstdlib>
#include <mutex>
#include <string_view>

#include "common/util/log.hpp"
#include "raytracer/farm/net/link.hpp"

namespace terravox::net {
namespace {

/// What both ends have in common.
template <class Set>
void set_common(const Set& set, const Keepalive& keepalive) {
    set(GRPC_ARG_KEEPALIVE_TIME_MS, static_cast<int>(keepalive.silence.count()));
    set(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, static_cast<int>(keepalive.answer.count()));
    set(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
    set(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);  // no limit
}

bool in_test() {
    const char* test = std::getenv("TERRAVOX_FARM_TEST");
    return test != nullptr && std::string_view(test) == "1";
}

void to_log(gpr_log_func_args* said) {
    // The process aborts right after a failed assertion.
    const bool fatal =
        std::string_view(said->message).find("assertion failed") != std::string_view::npos;
    util::log_message(fatal ? util::LogLevel::kCritical : util::LogLevel::kDebug,
                      "gRPC: {} ({}:{})", said->message, said->file, said->line);
}

}  // namespace

Keepalive Keepalive::of_environment() {
    if (in_test())
        return {std::chrono::seconds(2), std::chrono::seconds(2)};
    return {};
}

std::chrono::milliseconds max_stalled_of_environment() {
    return std::chrono::seconds(in_test() ? 2 : 10);
}

grpc::ChannelArguments channel_arguments(const Keepalive& keepalive) {
    grpc::ChannelArguments out;
    set_common([&](const char* name, int value) { out.SetInt(name, value); }, keepalive);
    out.SetMaxReceiveMessageSize(static_cast<int>(kMaxFrame_bytes));
    out.SetMaxSendMessageSize(static_cast<int>(kMaxFrame_bytes));
    // One connection for each link, made once, straight to the peer.
    out.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    out.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
    out.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    out.SetInt(GRPC_ARG_SERVICE_CONFIG_DISABLE_RESOLUTION, 1);
    return out;
}

void set_up(grpc::ServerBuilder& builder, const Keepalive& keepalive,
            std::chrono::milliseconds handshake) {
    set_common([&](const char* name, int value) { builder.AddChannelArgument(name, value); },
               keepalive);
    builder.SetMaxReceiveMessageSize(static_cast<int>(kMaxFrame_bytes));
    builder.SetMaxSendMessageSize(static_cast<int>(kMaxFrame_bytes));
    builder.AddChannelArgument(GRPC_ARG_HTTP2_MAX_PING_STRIKES, 0);
    builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 500);
    // A connection carries one call, and ends with it.
    builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, 1);
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, 3000);
    builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS,
                               static_cast<int>(handshake.count()));
}

void begin_grpc() {
    static std::once_flag once;
    std::call_once(once, [] {
        gpr_set_log_function(&to_log);
        grpc_init();
    });
}

std::string readable_peer(const std::string& of_grpc) {
    std::string out;
    const auto scheme = of_grpc.find(':');
    for (std::size_t i = scheme == std::string::npos ? 0 : scheme + 1; i < of_grpc.size(); ++i) {
        unsigned value = 0;
        if (of_grpc[i] == '%' && i + 2 < of_grpc.size() &&
            std::from_chars(&of_grpc[i + 1], &of_grpc[i + 3], value, 16).ptr == &of_grpc[i + 3]) {
            out += static_cast<char>(value);
            i += 2;
        } else {
            out += of_grpc[i];
        }
    }
    // A scope ("%2" after the address) is meaningful on this machine alone.
    if (const auto scope = out.find('%'), end = out.find(']');
        scope != std::string::npos && end != std::string::npos && scope < end)
        out.erase(scope, end - scope);
    return out;
}

}  // namespace terravox::net
