#pragma once

#include <filesystem>
#include <string>

namespace terravox::net {

/// 32 random characters of the system's generator.
[[nodiscard]] std::string new_token();

/// The token of a file, else of the environment variable TERRAVOX_TOKEN, else none.
/// @param file empty: none named @throws Error for a file that cannot be read, that others may read, or whose token is shorter than 16 characters
[[nodiscard]] std::string find_token(const std::filesystem::path& file);

}  // namespace terravox::net
