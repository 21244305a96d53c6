#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace terravox::farm {

/// The addresses that are being dialled. Each has a turn, a number that no other has: an address
/// may be removed and added again while the thread of the former turn still runs, and that thread
/// must neither continue nor remove the new turn. Not thread-safe.
class DialledAddresses {
public:
    /// @param address as Address::text
    /// @return its turn; nullopt: it is being dialled already
    [[nodiscard]] std::optional<std::uint64_t> add(const std::string& address);
    void remove(const std::string& address);
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
