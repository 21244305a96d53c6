#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

namespace terravox::net {

/// Logs why connections were refused: each reason once a minute for each address, so that a flood
/// does not fill the disk. Remembers at most kMaxKept of them; while it is full, others count
/// together as "other addresses", whatever their reasons. Not thread-safe.
class RefusalLog {
public:
    using Clock = std::chrono::steady_clock;
    static constexpr std::size_t kMaxKept = 1024;
    static constexpr std::chrono::seconds kQuiet{60};

    /// @param say receives the lines; none: they are logged as warnings
    /// @param what begins them
    explicit RefusalLog(std::function<void(const std::string&)> say = {},
                        std::string what = "farm: refused");
    /// @param who the address without its port
    /// @param peer the address with its port
    void refused(const std::string& who, const std::string& peer, const std::string& why,
                 Clock::time_point now = Clock::now());

private:
    struct Reported {
        Clock::time_point when;
        std::uint64_t since = 0;  ///< number of refusals that were not logged
    };
    std::function<void(const std::string&)> m_say;
    const std::string m_what;
    std::map<std::pair<std::string, std::string>, Reported> m_reported;
    /// When old entries were last removed; that is not done for each refusal, since there may be
    /// very many.
    Clock::time_point m_cleared{};
};

}  // namespace terravox::net
