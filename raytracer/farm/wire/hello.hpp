#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "common/util/error.hpp"
#include "raytracer/farm/net/link.hpp"

namespace terravox::farm {

/// The peer cannot or will not work with this program. Final, unless it is busy.
class HelloError : public util::Error {
public:
    HelloError(const std::string& peer, std::string why, bool is_busy)
        : util::Error("meet " + peer + ": " + why), reason(std::move(why)), busy(is_busy) {}
    std::string reason;  ///< without the peer
    bool busy;           ///< it may accept later
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

/// Sends this side's hello, waits for the peer's, and compares: protocol, software, build,
/// architecture, role. A mismatch is reported to the peer.
/// @param wanted the role that the peer must have
/// @param timeout after which the link is aborted
/// @throws HelloError that names the mismatch with the values of both sides, or the peer's reason
/// for refusing; Error when no thread can be started for the timeout
[[nodiscard]] farm::Hello meet(net::Link& link, const farm::Hello& own,
                               std::initializer_list<farm::Role> wanted,
                               std::chrono::milliseconds timeout = std::chrono::seconds(5));

/// Sends the peer the reason of a refusal, and ends the link.
void refuse(net::Link& link, const std::string& reason, bool busy = false) noexcept;

}  // namespace terravox::farm
