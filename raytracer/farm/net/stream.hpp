#pragma once

#include <grpcpp/support/byte_buffer.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "raytracer/farm/net/certificates.hpp"
#include "raytracer/farm/net/link.hpp"

namespace terravox::net {

/// One end of a call of Farm.Join as gRPC's callbacks see it. It lives until done() has returned
/// and the Link has released it.
///
/// One mutex guards all of it. It is never held while anything waits, except in condition
/// variables, and gRPC never calls back from within the start_ functions, so they are called under
/// it. Frames pass through two queues of messages: a frame is one message, a large one several
/// (Piece). Outward: send() fills the queue and blocks while it is full (kMaxQueued_bytes), and one
/// write is under way at a time. gRPC reports when a message has gone out, but not how much of it
/// has: pieces are how a slow peer is distinguished from one that accepts nothing. Inward: reads
/// run ahead of receive() up to kMaxAhead_bytes, then HTTP/2's flow control slows the peer down.
/// Neither direction waits for the other. The end of the inward direction is the end of the call: a
/// failed write only ends the writing, since the frame with the reason (Refusal, Bye) may still be
/// on its way in.
class Stream {
public:
    static constexpr std::size_t kMaxQueued_bytes = std::size_t{32} << 20;
    static constexpr std::size_t kMaxPiece_bytes = std::size_t{64} << 10;
    static constexpr std::size_t kMaxAhead_bytes = std::size_t{4} << 20;
    static constexpr std::size_t kMaxAhead = 256;

    explicit Stream(std::string peer);
    virtual ~Stream() = default;

    bool send(const farm::Frame& frame);
    [[nodiscard]] std::optional<farm::Frame> receive();
    void close(std::chrono::milliseconds timeout) noexcept;
    void abort() noexcept;
    /// Waits until gRPC no longer uses it, which follows the end of the call.
    void wait_until_done() noexcept;
    [[nodiscard]] const std::string& peer() const noexcept { return m_peer; }
    [[nodiscard]] const Certified& certified() const noexcept { return m_certified; }
    [[nodiscard]] bool is_revoked() { return m_revocations && m_revocations->is_revoked(); }
    [[nodiscard]] std::string why_ended() const;
    [[nodiscard]] Link::Traffic traffic() const noexcept;

protected:
    // Operations on gRPC; called with the mutex held, never after done().
    virtual void start_read(grpc::ByteBuffer* into) = 0;
    virtual void start_write(const grpc::ByteBuffer* frame) = 0;
    /// Ends writing: the peer learns that this end has closed the link; once.
    virtual void end_writes() = 0;
    virtual void cancel() = 0;
    virtual void let_go() = 0;  ///< called once, after which no operation is started

    /// Sets the certificate that the peer has presented.
    /// @param ca file of the CA's certificate
    void set_certified(Certified certified, const std::filesystem::path& ca) {
        m_certified = std::move(certified);
        m_revocations = std::make_unique<RevocationWatch>(m_certified.pem, ca);
    }

    /// To be called with the mutex held: no further read is started; gRPC may have finished before
    /// it would accept one.
    void end_reads() noexcept { m_in.ended = true; }

    // Notifications from gRPC.
    void begin();
    void read_done(bool ok, const char* why_not);
    void write_done(bool ok);
    void ended(const std::string& why);  ///< done() will follow
    void done() noexcept;                ///< the last notification

    // Not changed once a Link exists.
    std::string m_peer;
    Certified m_certified;  ///< contents of the peer's certificate; empty with a token
    std::unique_ptr<RevocationWatch> m_revocations;  ///< nullptr with a token

private:
    /// Messages that have arrived and that receive() has not taken, oldest first.
    struct Inward {
        std::deque<grpc::ByteBuffer> messages;
        std::size_t bytes = 0;             ///< of `messages`; meaningless after an abort
        grpc::ByteBuffer current;          ///< the read under way fills it
        bool under_way = false;            ///< a read was started and has not finished
        bool ended = false;                ///< no further read is started
        std::uint64_t received_bytes = 0;  ///< of all messages so far
    };
    /// Messages that send() has accepted and that have not gone out, oldest first.
    struct Outward {
        std::deque<grpc::ByteBuffer> messages;
        std::size_t bytes = 0;     ///< of `messages` and `current`
        grpc::ByteBuffer current;  ///< the message that the write under way sends
        bool under_way = false;    ///< a write was started and has not finished
        bool ended = false;        ///< end_writes() was called, or a write failed
        /// When the last message had gone out.
        std::chrono::steady_clock::time_point last_write;
        std::uint64_t sent_bytes = 0;  ///< of all messages so far
    };

    [[nodiscard]] std::optional<grpc::ByteBuffer> next_message();
    [[nodiscard]] bool wait_for_room(std::unique_lock<std::mutex>& lock);
    void end_unreadable(const std::string& why);
    void read_more();
    void write_more();
    void stop_writing();
    void finish(const std::string& why);
    void abort_locked() noexcept;

    const std::chrono::milliseconds m_max_stalled;

    mutable std::mutex m_mutex;
    std::condition_variable m_changed;
    Inward m_in;
    Outward m_out;
    bool m_closing = false;  ///< by this side
    bool m_aborted = false;  ///< by this side
    bool m_over = false;     ///< nothing more will arrive
    bool m_let_go = false;
    bool m_ended = false;
    bool m_done = false;
    std::string m_end_reason;
};

/// A Stream as a Link. Its destructor waits until gRPC has finished the call; an abort makes that
/// soon.
class StreamLink final : public Link {
public:
    explicit StreamLink(std::shared_ptr<Stream> stream) : m_stream(std::move(stream)) {}
    ~StreamLink() override {
        m_stream->abort();
        m_stream->wait_until_done();
    }
    bool send(farm::Frame frame) override { return m_stream->send(frame); }
    std::optional<farm::Frame> receive() override { return m_stream->receive(); }
    void close(std::chrono::milliseconds timeout) noexcept override { m_stream->close(timeout); }
    void abort() noexcept override { m_stream->abort(); }
    const std::string& peer() const noexcept override { return m_stream->peer(); }
    std::string certified_role() const override { return m_stream->certified().role; }
    std::string certified_name() const override { return m_stream->certified().name; }
    bool is_revoked() override { return m_stream->is_revoked(); }
    std::string why_ended() const override { return m_stream->why_ended(); }
    Traffic traffic() const noexcept override { return m_stream->traffic(); }

private:
    std::shared_ptr<Stream> m_stream;
};

}  // namespace terravox::net
