#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/serve/host/message.hpp"

namespace terravox::http {

/// The host names that a host accepts. A web page whose own name was made to resolve to this
/// machine (DNS rebinding) has, for its browser, the same origin as the host, and may read all
/// replies; but its requests carry that name in the header Host. Numeric addresses and `localhost`
/// cannot be such names. Immutable, thread-safe.
class HostNames {
public:
    /// @param bind  numeric address that the host listens on; "": all networks. Unless it is a
    /// loopback address, this machine's own host name is accepted, too.
    /// @param names further names, without a port, case-insensitive
    /// @throws UsageError for an invalid host name
    explicit HostNames(const std::string& bind = "127.0.0.1",
                       const std::vector<std::string>& names = {});

    /// @param host value of the header Host: a name or a numeric address (IPv6 in brackets), with
    /// or without a port; the port is ignored
    [[nodiscard]] bool allow(std::string_view host) const noexcept;

private:
    std::vector<std::string> m_names;  ///< lower case
};

/// Whether this is a numeric loopback address.
[[nodiscard]] bool is_loopback(const std::string& address) noexcept;

/// Whether a page of another origin sends the request. Following a link from there (GET or HEAD)
/// does not count: the reply is then shown to the user, not passed to that page. Programs other
/// than browsers send no Origin and no Sec-Fetch-Site; browsers send Origin with all other methods.
/// Ref: Fetch Standard, 3.2; W3C, "Fetch Metadata Request Headers", 2021.
[[nodiscard]] bool from_another_origin(const Request& request);

}  // namespace terravox::http
