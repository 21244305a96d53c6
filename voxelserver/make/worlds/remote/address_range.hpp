#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <initializer_list>
#include <string>

namespace terravox::remote {

/// The range that an IP address belongs to.
enum class AddressRange : std::uint8_t {
    kPublic,    ///< any machine of the Internet
    kPrivate,   ///< a local network: private, link-local, shared by a carrier's customers
    kLoopback,  ///< this machine
    /// Unspecified, multicast, reserved, for documentation, or IPv4 embedded in IPv6.
    kNoMachine,
};

/// A set of address ranges.
class AddressRanges {
public:
    constexpr AddressRanges(std::initializer_list<AddressRange> ranges = {}) noexcept {
        for (const AddressRange range : ranges)
            add(range);
    }
    constexpr void add(AddressRange range) noexcept {
        m_bits |= 1U << static_cast<unsigned>(range);
    }
    [[nodiscard]] constexpr bool holds(AddressRange range) const noexcept {
        return (m_bits >> static_cast<unsigned>(range) & 1U) != 0;
    }
    [[nodiscard]] constexpr bool empty() const noexcept { return m_bits == 0; }
    friend bool operator==(const AddressRanges&, const AddressRanges&) = default;

private:
    unsigned m_bits = 0;
};
inline constexpr AddressRanges kAnyRange{AddressRange::kPublic, AddressRange::kPrivate,
                                         AddressRange::kLoopback, AddressRange::kNoMachine};

/// @param address of IPv4 or IPv6; of anything else: kNoMachine
[[nodiscard]] AddressRange range_of(const sockaddr& address) noexcept;

/// "127.0.0.1", "::1".
[[nodiscard]] std::string text_of(const sockaddr& address);

}  // namespace terravox::remote
