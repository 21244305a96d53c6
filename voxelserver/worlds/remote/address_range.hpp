#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <initializer_list>
#include <string>

namespace terravox::remote {

/// Where the number of a machine leads.
enum class AddressRange : std::uint8_t {
    kPublic,     ///< any machine of the Internet
    kPrivate,    ///< a network of one's own: private, link-local, shared by a carrier's customers
    kLoopback,   ///< this machine
    kNoMachine,  ///< unspecified, multicast, reserved, for documents, or IPv4 in the disguise of
                 ///< IPv6
};

/// A set of them.
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
