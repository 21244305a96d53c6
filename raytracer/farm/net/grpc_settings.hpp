#pragma once

#include <grpcpp/server_builder.h>
#include <grpcpp/support/channel_arguments.h>

#include <chrono>
#include <string>

namespace terravox::net {

inline constexpr const char* kJoinMethod = "/terravox.farm.Farm/Join";
inline constexpr const char* kAcceptedKey =
    "terravox-farm";  ///< in what the listener's end says first: without it the call was not taken

/// How a dead peer is found: a ping after this much silence, whose answer may take this long.
/// TERRAVOX_FARM_TEST=1 in the environment shortens both.
struct Keepalive {
    std::chrono::milliseconds silence{10'000}, answer{5'000};
    [[nodiscard]] static Keepalive of_environment();
};

/// After so long without a byte taken a peer is stuck, whatever it answers to pings.
/// TERRAVOX_FARM_TEST=1 shortens it, too.
[[nodiscard]] std::chrono::milliseconds max_stalled_of_environment();

[[nodiscard]] grpc::ChannelArguments channel_arguments(const Keepalive& keepalive);
void set_up(grpc::ServerBuilder& builder, const Keepalive& keepalive,
            std::chrono::milliseconds handshake);

/// Once in a process, whoever needs gRPC first. It stays: gRPC, which would end with its last
/// object, waits for its threads then, up to ten seconds. It writes to standard error by itself, a
/// line for each stranger with a bad certificate; from now on to the log, as details.
void begin_grpc();

/// "ipv6:%5B::1%5D:51234" as "[::1]:51234", as Endpoint::text() says it.
[[nodiscard]] std::string readable_peer(const std::string& of_grpc);

}  // namespace terravox::net
