#include "voxelserver/make/worlds/remote/address_range.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <array>
#include <cstring>
#include <span>

namespace terravox::remote {
namespace {

struct Block {
    std::array<std::uint8_t, 16> first;
    int bits;  ///< of the prefix
    AddressRange range;
};

// Ref: IANA, "IPv4 Special-Purpose Address Registry", "IPv6 Special-Purpose Address Registry". The
// first matching block counts.
constexpr std::array kBlocks4 = {
    Block{{127}, 8, AddressRange::kLoopback},
    Block{{10}, 8, AddressRange::kPrivate},
    Block{{172, 16}, 12, AddressRange::kPrivate},
    Block{{192, 168}, 16, AddressRange::kPrivate},
    Block{{169, 254}, 16, AddressRange::kPrivate},
    Block{{100, 64}, 10, AddressRange::kPrivate},
    Block{{0}, 8, AddressRange::kNoMachine},
    Block{{192, 0, 0}, 24, AddressRange::kNoMachine},
    Block{{192, 0, 2}, 24, AddressRange::kNoMachine},
    Block{{192, 88, 99}, 24, AddressRange::kNoMachine},  // anycast to relays of 6to4
    Block{{198, 18}, 15, AddressRange::kNoMachine},
    Block{{198, 51, 100}, 24, AddressRange::kNoMachine},
    Block{{203, 0, 113}, 24, AddressRange::kNoMachine},
    Block{{224}, 3, AddressRange::kNoMachine},  // multicast, reserved, broadcast
    Block{{}, 0, AddressRange::kPublic},
};
// Only 2000::/3 is assigned to machines. IPv4 within IPv6 (mapped, NAT64, Teredo, 6to4) could lead
// where IPv4 itself must not.
constexpr std::array kBlocks6 = {
    Block{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 128, AddressRange::kLoopback},
    Block{{0xfc}, 7, AddressRange::kPrivate},
    Block{{0xfe, 0x80}, 10, AddressRange::kPrivate},
    Block{{0x20, 0x01}, 23, AddressRange::kNoMachine},
    Block{{0x20, 0x01, 0x0d, 0xb8}, 32, AddressRange::kNoMachine},
    Block{{0x20, 0x02}, 16, AddressRange::kNoMachine},
    Block{{0x3f, 0xff}, 20, AddressRange::kNoMachine},
    Block{{0x20}, 3, AddressRange::kPublic},
    Block{{}, 0, AddressRange::kNoMachine},
};

bool begins_with(const std::uint8_t* address, const Block& block) noexcept {
    const auto whole = static_cast<std::size_t>(block.bits / 8);
    if (std::memcmp(address, block.first.data(), whole) != 0)
        return false;
    const int rest = block.bits % 8;
    return rest == 0 || (address[whole] ^ block.first[whole]) >> (8 - rest) == 0;
}

AddressRange range_in(std::span<const Block> blocks, const std::uint8_t* address) noexcept {
    for (const Block& block : blocks)
        if (begins_with(address, block))
            return block.range;
    return AddressRange::kNoMachine;
}

const std::uint8_t* number_of(const sockaddr& address) noexcept {
    if (address.sa_family == AF_INET)
        return reinterpret_cast<const std::uint8_t*>(
            &reinterpret_cast<const sockaddr_in&>(address).sin_addr);
    if (address.sa_family == AF_INET6)
        return reinterpret_cast<const sockaddr_in6&>(address).sin6_addr.s6_addr;
    return nullptr;
}

}  // namespace

AddressRange range_of(const sockaddr& address) noexcept {
    const std::uint8_t* number = number_of(address);
    if (number == nullptr)
        return AddressRange::kNoMachine;
    return address.sa_family == AF_INET ? range_in(kBlocks4, number) : range_in(kBlocks6, number);
}

std::string text_of(const sockaddr& address) {
    std::array<char, INET6_ADDRSTRLEN> text{};
    const std::uint8_t* number = number_of(address);
    if (number == nullptr ||
        inet_ntop(address.sa_family, number, text.data(), text.size()) == nullptr)
        return "no number of a machine";
    return text.data();
}

}  // namespace terravox::remote
