#pragma once

#include <terravox/api.hpp>
#include <terravox/world.hpp>

#include <memory>
#include <string>
#include <vector>

namespace terravox {

struct ServerOptions {
    /// Numeric address to listen on. Beyond this machine (0.0.0.0: all its networks of IPv4)
    /// whoever reaches it may read the world unless a token is set; there is no encryption.
    std::string bind = "127.0.0.1";
    int port = 0;  ///< 0: any that is free
    /// What clients must send as a bearer token; empty: nothing. 32 to 512 letters, digits and
    /// -._~+/=, at least 10 of them different, with both letters and digits.
    std::string token;
    /// Host names by which browsers may reach it, besides numeric addresses and localhost.
    std::vector<std::string> names;
    int memory_mib = 256;  ///< limit for boxes and tiles of the map that are kept (16 to 1048576)
    int threads = 0;       ///< boxes that are made at the same time (0: one for each core)
};

/// Serves the boxes of a world over HTTP, with a map and a viewer for browsers, as `terravox serve`
/// does (docs/formats/http.md). Requests are answered by threads of its own. The world stays open
/// as long as the server. All functions may be called from several threads at once.
///
/// SIGPIPE is ignored in this process from the first server on.
class TERRAVOX_API Server {
public:
    /// Serves from construction.
    /// @throws UsageError for options that are not allowed; Error when it cannot listen
    explicit Server(const World& world, const ServerOptions& options = {});
    /// As stop().
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    [[nodiscard]] int port() const noexcept;
    [[nodiscard]] std::string url() const;  ///< http://address:port, for World::open and browsers

    /// Lets requests that are being answered finish, for ten seconds at most; then nothing is
    /// served any more. Idle it takes up to two seconds; a box that a slow world is making is
    /// waited for. Later calls do nothing, nor does a call in a forked process, which keeps the
    /// port.
    void stop() noexcept;

private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox
