#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/farm/net/link.hpp"

namespace terravox::farm {

/// The peer cannot or will not work with us. Final, unless it is busy.
class HelloError : public util::Error {
public:
    HelloError(const std::string& message, bool is_busy) : util::Error(message), busy(is_busy) {}
    bool busy;  ///< another time it may do
};

struct OwnHello {
    farm::Role role = farm::COORDINATOR;
    int threads = 0;
    std::uint64_t memory_bytes = 0;
    int capacity = 0;  ///< of a worker: tiles
    std::string name;  ///< empty: host and process
};
/// The first frame of a link: protocol, software and build of this program, and this machine.
[[nodiscard]] farm::Hello make_hello(const OwnHello& own);

/// Sends our hello, waits for the other's, and compares: protocol, software, build, architecture,
/// role. What does not fit is told to the peer.
/// @param wanted the role that the peer must have @param timeout after it the link is aborted
/// @throws HelloError that names what does not fit, and both sides of it; or what the peer refused
/// us for; Error without a thread for the limit
[[nodiscard]] farm::Hello meet(net::Link& link, const farm::Hello& own,
                               std::initializer_list<farm::Role> wanted,
                               std::chrono::milliseconds timeout = std::chrono::seconds(5));

/// Tells the peer why nothing comes of it, and ends the link.
void refuse(net::Link& link, const std::string& reason, bool busy = false) noexcept;

}  // namespace terravox::farm
