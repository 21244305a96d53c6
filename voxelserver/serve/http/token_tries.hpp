#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace terravox::http {

/// Limits how often the clients of an address try a wrong token: kMax times at once, and once more
/// every kPause. What a try beyond that has shown must not be used, so that it tells nothing.
///
/// An address that has shown the right token lately is not limited: a front, or a network behind
/// one address, asks for others as well, whom a guesser must not lock out. Remembers the latest
/// kMaxKept addresses (of IPv6: networks of 64 bits). Reads no clock. Thread-safe.
class TokenTries {
public:
    using Time = std::chrono::steady_clock::time_point;
    static constexpr int kMax = 20;
    static constexpr std::chrono::seconds kPause{1};
    static constexpr std::chrono::minutes kTrusted{10};
    static constexpr std::size_t kMaxKept = 4096;

    /// Counts a try.
    /// @param address numeric, without a port
    /// @return false: too many were wrong before
    [[nodiscard]] bool count(const std::string& address, bool is_right, Time now);

private:
    struct Client {
        Time seen;                  ///< its last try that counted
        Time all_free;              ///< when it has all kMax tries again
        std::optional<Time> right;  ///< when it last showed the right token
    };
    /// With the lock held.
    [[nodiscard]] Client& client(const std::string& address, Time now);

    std::mutex m_mutex;
    std::map<std::string, Client> m_clients;  ///< by neighbourhood
};

}  // namespace terravox::http
