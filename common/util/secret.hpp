#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace terravox::util {

/// Names of environment variables that hold tokens. Each has one purpose: the secret of one
/// component must not reach another. This one is shared by a coordinator and its workers; proved,
/// never sent.
inline constexpr const char* kFarmTokenVariable = "TERRAVOX_FARM_TOKEN";
/// The token of a voxel server; its clients send it.
inline constexpr const char* kServerTokenVariable = "TERRAVOX_SERVER_TOKEN";

/// Makes a token of 32 characters from 160 random bits of the system.
/// @throws Error when the system has no random numbers
[[nodiscard]] std::string make_token();

/// Judges a token, of a farm or of a voxel server. Whoever hears a farm's token proved, or reaches
/// a server, may try others, so it has to be one that nobody thinks of: 32 to 512 characters, which
/// are letters, digits or -._~+/= (so that a header can carry it: b64token of RFC 6750), at least
/// 10 of them different, with both letters and digits among them. Tokens of make_token() and of
/// `openssl rand -hex 16` are.
/// @param attempt begins the message: "read the token file /etc/token"
/// @throws UsageError, which does not show the token
void check_token(std::string_view token, const std::string& attempt);

/// A credential that systemd has handed to this service (LoadCredential=).
/// @return its file; empty: there is none of that name
[[nodiscard]] std::filesystem::path find_credential(const std::string& name);

/// The token from the file, else from the variable, else ""; trailing white space is removed.
/// @param file empty: no file is configured
/// @param variable kFarmTokenVariable or kServerTokenVariable
/// @throws UsageError as check_token(), or when the environment has TERRAVOX_TOKEN, formerly the
/// single name of both tokens; Error for a file that cannot be read, is longer than 4096 bytes, or
/// that users other than its owner may read or change
[[nodiscard]] std::string find_token(const std::filesystem::path& file, const char* variable);

}  // namespace terravox::util
