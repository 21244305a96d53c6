#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// Names of environment variables that hold secrets. Each has one purpose: the secret of one
/// component must not reach another. This one is shared by a coordinator and its workers; proved,
/// never sent.
inline constexpr const char* kFarmTokenVariable = "TERRAVOX_FARM_TOKEN";
/// The token of a voxel server; its clients send it.
inline constexpr const char* kServerTokenVariable = "TERRAVOX_SERVER_TOKEN";

/// A secret, and where it was read from, for messages: "read the token file /etc/token".
struct Secret {
    std::string text;  ///< empty when there is none
    std::string attempt;
};

/// The secret from the file, else from the variable, else none; trailing white space is removed.
/// @param file empty: no file is configured
/// @throws UsageError when the environment has TERRAVOX_TOKEN, formerly the single name of both
/// tokens; Error for a file that cannot be read, is longer than 4096 bytes, or that users other
/// than its owner may read or change
[[nodiscard]] Secret find_secret(const std::filesystem::path& file, const char* variable);

/// The token of a voxel server, which its clients send: from the file, else from
/// TERRAVOX_SERVER_TOKEN, else "".
/// @throws as find_secret(); UsageError for one that is not 8 to 512 visible ASCII characters
[[nodiscard]] std::string find_server_token(const std::filesystem::path& file);
/// @throws UsageError for one that is not 8 to 512 visible ASCII characters
void check_server_token(const Secret& token);

}  // namespace terravox::util
