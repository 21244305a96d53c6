#pragma once

#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>
#include <string>
#include <string_view>

#include "raytracer/farm/net/endpoint.hpp"

namespace terravox::net {

/// DNS name in each certificate: a peer with a certificate of this CA belongs to the farm.
inline constexpr std::string_view kFarmName = "terravox-farm";

/// The contents of the three files.
struct Pem {
    std::string ca;
    std::string certificate;
    std::string key;
};

/// @throws UsageError for both kinds, or neither, or only some of the three files, or a token that
/// is none (util::check_token)
void check(const Credentials& credentials);

/// Reads a PEM file.
/// @param what kind of file it is, for messages
/// @throws Error for a file that cannot be read, or is larger than 1 MiB
[[nodiscard]] std::string text_of_pem(const std::filesystem::path& path, const char* what);

/// Reads the files and checks that a peer with the same CA would accept them.
/// @throws Error for a file that cannot be read or is not PEM, or a key of another certificate;
/// RefusedError for a certificate that has expired, is of another CA, does not carry kFarmName or
/// names no role
[[nodiscard]] Pem read_pem(const Credentials& credentials);

[[nodiscard]] std::shared_ptr<grpc::ChannelCredentials> to_dial(const Pem& pem);
[[nodiscard]] std::shared_ptr<grpc::ServerCredentials> to_listen(const Pem& pem);

}  // namespace terravox::net
