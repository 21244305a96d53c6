#pragma once

#include <filesystem>
#include <string>

namespace terravox::net {

/// Makes a token of 32 random characters from the system's generator.
[[nodiscard]] std::string new_token();

/// Finds the farm's token: in a file, else in the environment variable TERRAVOX_FARM_TOKEN, else
/// none.
/// @param file empty: no file
/// @throws as util::find_secret(); Error for a token with a control character; UsageError for one
/// that can be guessed (token_strength.hpp)
[[nodiscard]] std::string find_token(const std::filesystem::path& file);

}  // namespace terravox::net
