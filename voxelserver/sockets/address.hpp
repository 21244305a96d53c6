#pragma once

#include <cstdint>
#include <string>

namespace terravox::sockets {

/// Where to dial or listen.
struct Address {
    std::string host;  ///< name or number; empty when listening: all interfaces
    std::uint16_t port = 0;
    /// @param text "host:port", ":port", "[v6]:port"
    /// @param default_port where none is named; 0: it must be named
    /// @throws UsageError
    [[nodiscard]] static Address parse(const std::string& text, std::uint16_t default_port);
    [[nodiscard]] std::string text() const;
};

}  // namespace terravox::sockets
