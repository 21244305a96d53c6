#pragma once

#include <string>

namespace terravox::worlds {

/// Whether a world's input is an address (of a voxel server, or of an archive on a web server)
/// rather than a path. Says nothing about whether the address is valid.
[[nodiscard]] inline bool is_http_address(const std::string& input) noexcept {
    return input.starts_with("http://") || input.starts_with("https://");
}

}  // namespace terravox::worlds
