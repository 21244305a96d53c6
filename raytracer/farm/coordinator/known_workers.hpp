#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

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

/// The addresses that are being dialled. Each has a turn, a number that no other has: an address
/// may be removed and added again while the thread of the former turn still runs, and that thread
/// must neither continue nor remove the new turn. Not thread-safe.
class DialledAddresses {
public:
    /// @param address as Address::text
    /// @return its turn; nullopt: it is being dialled already
    [[nodiscard]] std::optional<std::uint64_t> add(const std::string& address);
    void remove(const std::string& address) { m_turns.erase(address); }
    /// Removes the address unless it is in another turn.
    void remove(const std::string& address, std::uint64_t turn);
    [[nodiscard]] bool has(const std::string& address) const { return m_turns.contains(address); }
    /// @return whether the address is being dialled, in this turn
    [[nodiscard]] bool has(const std::string& address, std::uint64_t turn) const;
    [[nodiscard]] std::vector<std::string> list() const;  ///< sorted

private:
    std::map<std::string, std::uint64_t> m_turns;  ///< by address
    std::uint64_t m_next_turn = 1;
};

}  // namespace terravox::farm
