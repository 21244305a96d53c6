#pragma once

#include <cstdint>
#include <string>

namespace terravox::sockets {

/// A host and port to connect to or to listen on.
struct Address {
    std::string host;  ///< name or numeric address; empty when listening: all interfaces
    std::uint16_t port = 0;
    /// @param text "host:port", ":port", "[v6]:port"
    /// @param default_port used where none is given; 0: a port is required
    /// @throws UsageError
    [[nodiscard]] static Address parse(const std::string& text, std::uint16_t default_port);
    [[nodiscard]] std::string text() const;
};

}  // namespace terravox::sockets
