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
inline constexpr std::size_t kMaxBeforePing_bytes =
    std::size_t{16} << 20;  ///< a ping or a heartbeat that has to wait for more says nothing
inline constexpr std::size_t kMaxFrame_bytes =
    std::size_t{16} << 20;  ///< a larger frame ends the link on either side

/// One connection between a coordinator and a worker, whoever dialled: frames both ways, in order,
/// each once. The peer has shown that it may (token or certificate) before a Link exists.
/// Thread-safe; receive() is for one thread at a time.
class Link {
public:
    Link() = default;
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;
    virtual ~Link() = default;  ///< as abort()

    /// Queues a frame; waits while more than 32 MiB are queued. Where nothing at all goes out for
    /// 10 s meanwhile the link is aborted; a peer that takes 64 KiB in that time is slow, not
    /// stuck. TERRAVOX_FARM_TEST=1 in the environment makes it 2 s.
    /// @return false: the link has ended, the frame is lost
    virtual bool send(farm::Frame frame) = 0;
    /// Waits for the next frame. @return nullopt: the link has ended, by either side
    [[nodiscard]] virtual std::optional<farm::Frame> receive() = 0;
    /// Ends the link once what is queued has been sent, but no later than after this; send() fails
    /// from now on. Idempotent.
    virtual void close(std::chrono::milliseconds timeout = std::chrono::seconds(2)) noexcept = 0;
    /// Ends it at once: receive() returns. Idempotent.
    virtual void abort() noexcept = 0;
    [[nodiscard]] virtual const std::string& peer()
        const noexcept = 0;  ///< its address, for messages
    /// What the peer's certificate lets it be ("worker", "coordinator":
    /// raytracer/farm/net/peer_certificate.hpp); empty with a token.
    [[nodiscard]] virtual std::string certified_role() const { return {}; }
    /// The name that the CA has given the peer in its certificate; empty with a token. Several
    /// machines may share a certificate.
    [[nodiscard]] virtual std::string certified_name() const { return {}; }
    /// Whether the peer's certificate has been revoked since it was let in, by the list of this
    /// machine; false with a token. Asks the file system: for now and then, as with each heartbeat.
    /// Whoever is told so ends the link.
    [[nodiscard]] virtual bool is_revoked() { return false; }
    /// Why it ended, for messages; empty before that, and after a close() of our own.
    [[nodiscard]] virtual std::string why_ended() const = 0;
    /// Bytes on the wire so far, near enough: serialized frames. They grow while a large frame is
    /// on its way.
    struct Traffic {
        std::uint64_t sent_bytes = 0, received_bytes = 0;
        std::uint64_t queued_bytes =
            0;  ///< of what send() took, not sent yet; above 32 MiB send() waits
    };
    [[nodiscard]] virtual Traffic traffic() const noexcept = 0;
};

/// Both ends of a link within this process. For tests.
[[nodiscard]] std::pair<std::unique_ptr<Link>, std::unique_ptr<Link>> link_pair();

}  // namespace terravox::net
