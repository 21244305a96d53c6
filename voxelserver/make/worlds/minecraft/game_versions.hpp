#pragma once

#include <cstdint>
#include <string>

namespace terravox::minecraft {

/// The release of the game that a data version belongs to: "1.16.4", or "after 1.16.4 (2600)" for
/// one between.
[[nodiscard]] std::string game_version(std::int64_t data_version);

}  // namespace terravox::minecraft
