#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// Variables of the environment that hold secrets. Each has one use: what one part is trusted with
/// must not reach another.
inline constexpr const char* kFarmTokenVariable =
    "TERRAVOX_FARM_TOKEN";  ///< a coordinator's and its workers'; proved, never sent
inline constexpr const char* kServerTokenVariable =
    "TERRAVOX_SERVER_TOKEN";  ///< a voxel server's; its clients send it

/// A secret, and how it was come by, for messages: "read the token file /etc/token".
struct Secret {
    std::string text;  ///< empty: there is none
    std::string attempt;
};

/// The secret of the file, else of the variable, else none; white space after it does not count.
/// @param file empty: none named
/// @throws UsageError when the environment has TERRAVOX_TOKEN, once the one name of both tokens;
///         Error for a file that cannot be read, is longer than 4096 bytes, or that others than its
///         owner may read or change
[[nodiscard]] Secret find_secret(const std::filesystem::path& file, const char* variable);

/// The token of a voxel server, which its clients send: of the file, else of TERRAVOX_SERVER_TOKEN,
/// else "".
/// @throws as find_secret(); UsageError for one that is not 8 to 512 visible ASCII characters
[[nodiscard]] std::string find_server_token(const std::filesystem::path& file);

}  // namespace terravox::util
