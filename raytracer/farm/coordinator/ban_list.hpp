#pragma once

#include <map>
#include <set>
#include <string>

namespace terravox::farm {

/// The workers that a coordinator has expelled, and admits no more.
///
/// A worker that was dialled is known by that address. One that dialled in is known by its name and
/// host, as its port changes; since it can choose any name, a host with several expelled workers is
/// no longer admitted at all. Not thread-safe.
class BanList {
public:
    /// Expelled workers of one host, under any names, after which the host is banned.
    static constexpr int kMaxOfHost = 3;

    struct Worker {
        std::string name;     ///< of its hello, which it chooses freely
        std::string peer;     ///< its address, with a port
        std::string dialled;  ///< address that was dialled; empty: it dialled in
    };
    void ban(const Worker& worker);  ///< idempotent
    /// @return whether this worker, or its host, is banned
    [[nodiscard]] bool has(const Worker& worker) const;

private:
    /// Addresses that were dialled; for workers that dialled in, names with their hosts.
    std::set<std::string> m_banned;
    std::map<std::string, int> m_number_of_host;  ///< number of banned workers that dialled in
};

}  // namespace terravox::farm
