#pragma once

#include <filesystem>
#include <string>

namespace terravox::net {

/// 32 random characters of the system's generator.
[[nodiscard]] std::string new_token();

/// The farm's token: of a file, else of the environment variable TERRAVOX_FARM_TOKEN, else none.
/// @param file empty: none named
/// @throws as util::find_secret(); Error for a token with a control character; UsageError for one
/// that can be guessed (token_strength.hpp)
[[nodiscard]] std::string find_token(const std::filesystem::path& file);

}  // namespace terravox::net
