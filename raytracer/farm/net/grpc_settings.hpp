#pragma once

#include <grpcpp/server_builder.h>
#include <grpcpp/support/channel_arguments.h>

#include <chrono>
#include <string>

namespace terravox::net {

inline constexpr const char* kJoinMethod = "/terravox.farm.Farm/Join";
/// Key in the listener's initial metadata: without it the call was not accepted.
inline constexpr const char* kAcceptedKey = "terravox-farm";

/// How a dead peer is detected: a ping after this much silence, whose answer may take this long.
/// TERRAVOX_FARM_TEST=1 in the environment shortens both.
struct Keepalive {
    std::chrono::milliseconds silence{10'000};
    std::chrono::milliseconds answer{5'000};
    [[nodiscard]] static Keepalive of_environment();
};

/// A peer that accepts no byte for this long is stuck, even if it answers pings.
/// TERRAVOX_FARM_TEST=1 shortens this, too.
[[nodiscard]] std::chrono::milliseconds max_stalled_of_environment();

[[nodiscard]] grpc::ChannelArguments channel_arguments(const Keepalive& keepalive);
void set_up(grpc::ServerBuilder& builder, const Keepalive& keepalive,
            std::chrono::milliseconds handshake);

/// Initialises gRPC once per process; to be called before gRPC is used. It stays initialised,
/// because gRPC would otherwise shut down with its last object and wait up to ten seconds for its
/// threads. By itself gRPC writes a line to standard error for each peer with a bad certificate;
/// after this call such lines go to the log, as details.
void begin_grpc();

/// Converts "ipv6:%5B::1%5D:51234" to "[::1]:51234", the form of Endpoint::text().
[[nodiscard]] std::string readable_peer(const std::string& of_grpc);

}  // namespace terravox::net
