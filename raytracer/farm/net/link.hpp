#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "raytracer/farm/net/farm.pb.h"

namespace terravox::net {

inline constexpr std::uint32_t kProtocol = 1;
/// A ping or a heartbeat that waits behind more bytes than this measures nothing.
inline constexpr std::size_t kMaxBeforePing_bytes = std::size_t{16} << 20;
/// A larger frame ends the link on either side.
inline constexpr std::size_t kMaxFrame_bytes = std::size_t{16} << 20;

/// One connection between a coordinator and a worker, whichever side dialled: frames in both
/// directions, in order, each exactly once. The peer has authenticated (token or certificate)
/// before a Link exists. Thread-safe; receive() is for one thread at a time.
class Link {
public:
    Link() = default;
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;
    virtual ~Link() = default;  ///< as abort()

    /// Queues a frame; blocks while more than 32 MiB are queued. If nothing at all goes out for 10
    /// s meanwhile the link is aborted; a peer that accepts 64 KiB in that time is slow, not stuck.
    /// TERRAVOX_FARM_TEST=1 in the environment makes it 2 s.
    /// @return false: the link has ended, the frame is lost
    virtual bool send(farm::Frame frame) = 0;
    /// Blocks until the next frame.
    /// @return nullopt: the link has ended, by either side
    [[nodiscard]] virtual std::optional<farm::Frame> receive() = 0;
    /// Ends the link once everything queued has been sent, at the latest after the timeout; send()
    /// fails from now on. Idempotent.
    virtual void close(std::chrono::milliseconds timeout = std::chrono::seconds(2)) noexcept = 0;
    /// Ends the link at once: receive() returns. Idempotent.
    virtual void abort() noexcept = 0;
    /// The peer's address, for messages.
    [[nodiscard]] virtual const std::string& peer() const noexcept = 0;
    /// Role of the peer according to its certificate ("worker", "coordinator":
    /// raytracer/farm/net/certificates.hpp); empty with a token.
    [[nodiscard]] virtual std::string certified_role() const { return {}; }
    /// The name of the peer in its certificate, assigned by the CA; empty with a token. Several
    /// machines may share a certificate.
    [[nodiscard]] virtual std::string certified_name() const { return {}; }
    /// Whether the peer's certificate has been revoked since it was admitted, according to the list
    /// on this machine; false with a token. Reads the file system: call it occasionally, such as
    /// with each heartbeat. A caller that gets true must end the link.
    [[nodiscard]] virtual bool is_revoked() { return false; }
    /// Why the link ended, for messages; empty before that, and after a close() by this side.
    [[nodiscard]] virtual std::string why_ended() const = 0;
    /// Approximate bytes on the wire so far: serialized frames. They grow while a large frame is
    /// being sent.
    struct Traffic {
        std::uint64_t sent_bytes = 0;
        std::uint64_t received_bytes = 0;
        /// Bytes accepted by send() and not sent yet; above 32 MiB send() blocks.
        std::uint64_t queued_bytes = 0;
    };
    [[nodiscard]] virtual Traffic traffic() const noexcept = 0;
};

}  // namespace terravox::net
