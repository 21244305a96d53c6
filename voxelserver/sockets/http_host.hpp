#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace terravox::sockets {

/// The names by which an HTTP server lets itself be asked. A web page whose own name was made to
/// lead to this machine (DNS rebinding) is, for its browser, of the same origin as the server, and
/// may read all replies; but its requests carry that name in the header Host. Numeric addresses and
/// `localhost` are never such names. Immutable, thread-safe.
class HttpNames {
public:
    /// @param bind  numeric address that the server listens on; "": all networks. Beyond loopback
    /// this machine's own host name counts, too.
    /// @param names further names, without a port, in any case
    /// @throws UsageError for one that is no host name
    explicit HttpNames(const std::string& bind = "127.0.0.1",
                       const std::vector<std::string>& names = {});

    /// @param host value of the header Host: a name or a numeric address (IPv6 in brackets), with a
    /// port or without; which port does not matter
    [[nodiscard]] bool allow(std::string_view host) const noexcept;

private:
    std::vector<std::string> m_names;  ///< lower case
};

/// Is this a numeric address of loopback?
[[nodiscard]] bool is_loopback(const std::string& address) noexcept;

/// What browsers say of the page that asks; each is "" where the header is missing.
struct AskingPage {
    std::string_view host;         ///< Host: whom it asks
    std::string_view origin;       ///< Origin
    std::string_view site;         ///< Sec-Fetch-Site
    std::string_view mode;         ///< Sec-Fetch-Mode
    std::string_view destination;  ///< Sec-Fetch-Dest
};

/// Does a page of another origin ask? Following a link from there does not count: the reply is then
/// shown, not handed to that page. Programs other than browsers send none of these headers. Ref:
/// Fetch Standard, 3.2; W3C, "Fetch Metadata Request Headers", 2021.
[[nodiscard]] bool from_another_origin(const AskingPage& page) noexcept;

}  // namespace terravox::sockets
