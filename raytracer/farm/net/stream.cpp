#include "raytracer/farm/net/stream.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

#include <algorithm>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/farm/net/grpc_settings.hpp"

namespace terravox::net {
namespace {

using Clock = std::chrono::steady_clock;

grpc::ByteBuffer serialized(const farm::Frame& frame, const std::string& peer) {
    grpc::ByteBuffer bytes;
    bool own = false;
    if (!grpc::SerializationTraits<farm::Frame>::Serialize(frame, &bytes, &own).ok())
        throw util::Error("send a frame to " + peer + ": it cannot be serialized");
    return bytes;
}

std::vector<grpc::ByteBuffer> make_messages(const farm::Frame& frame, std::size_t size_bytes,
                                            const std::string& peer) {
    std::vector<grpc::ByteBuffer> out;
    if (size_bytes <= Stream::kMaxPiece_bytes) {
        out.push_back(serialized(frame, peer));
        return out;
    }
    const std::string whole = frame.SerializeAsString();
    if (whole.size() != size_bytes)
        throw util::Error("send a frame to " + peer + ": it cannot be serialized");
    farm::Frame message;
    for (std::size_t at = 0; at < whole.size(); at += Stream::kMaxPiece_bytes) {
        const auto part_bytes = std::min(Stream::kMaxPiece_bytes, whole.size() - at);
        message.mutable_piece()->set_part(whole.data() + at, part_bytes);
        message.mutable_piece()->set_last(at + part_bytes == whole.size());
        out.push_back(serialized(message, peer));
    }
    return out;
}

}  // namespace

Stream::Stream(std::string peer)
    : m_peer(std::move(peer)), m_max_stalled(max_stalled_of_environment()) {}

bool Stream::send(const farm::Frame& frame) {
    const std::size_t size_bytes = frame.ByteSizeLong();
    const bool fits = size_bytes <= kMaxFrame_bytes;
    std::vector<grpc::ByteBuffer> messages;
    if (fits)
        messages = make_messages(frame, size_bytes, m_peer);
    std::unique_lock lock(m_mutex);
    // A peer that accepts nothing must not block a thread that serves others, too.
    if (!wait_for_room(lock)) {
        finish("it took nothing for " +
               std::to_string(std::chrono::ceil<std::chrono::seconds>(m_max_stalled).count()) +
               " s");
        abort_locked();
        return false;
    }
    if (m_closing || m_out.ended || m_over)
        return false;
    if (!fits) {
        finish("a frame of " + std::to_string(size_bytes) +
               " bytes was to be sent; allowed: at most " + std::to_string(kMaxFrame_bytes));
        abort_locked();
        return false;
    }
    for (auto& message : messages) {
        m_out.bytes += message.Length();
        m_out.messages.push_back(std::move(message));
    }
    if (!m_out.under_way)
        write_more();
    return true;
}

/// @return false: nothing has gone out for too long
bool Stream::wait_for_room(std::unique_lock<std::mutex>& lock) {
    const auto began = Clock::now();
    while (m_out.bytes > kMaxQueued_bytes && !m_closing && !m_out.ended && !m_over) {
        const auto until = std::max(began, m_out.last_write) + m_max_stalled;
        if (Clock::now() >= until)
            return false;
        m_changed.wait_until(lock, until);
    }
    return true;
}

std::optional<farm::Frame> Stream::receive() {
    std::string whole;
    for (;;) {
        auto bytes = next_message();
        if (!bytes)
            return std::nullopt;
        farm::Frame frame;
        if (!grpc::SerializationTraits<farm::Frame>::Deserialize(&*bytes, &frame).ok() ||
            (!whole.empty() && !frame.has_piece())) {
            end_unreadable("the other end sent a frame that cannot be read");
            return std::nullopt;
        }
        if (!frame.has_piece())
            return frame;
        const auto& piece = frame.piece();
        if (piece.part().empty() || piece.part().size() > kMaxFrame_bytes - whole.size()) {
            end_unreadable(piece.part().empty()
                               ? "the other end sent a piece of a frame with nothing in it"
                               : "the other end sent a frame of more than " +
                                     std::to_string(kMaxFrame_bytes) + " bytes");
            return std::nullopt;
        }
        whole += piece.part();
        if (!piece.last())
            continue;
        if (frame.ParseFromString(whole) && !frame.has_piece())
            return frame;
        end_unreadable("the other end sent a frame that cannot be read");
        return std::nullopt;
    }
}

std::optional<grpc::ByteBuffer> Stream::next_message() {
    std::unique_lock lock(m_mutex);
    m_changed.wait(lock, [&] { return m_aborted || m_ended || !m_in.messages.empty(); });
    if (m_aborted || m_in.messages.empty())
        return std::nullopt;
    auto bytes = std::move(m_in.messages.front());
    m_in.messages.pop_front();
    m_in.bytes -= bytes.Length();
    read_more();
    return bytes;
}

void Stream::end_unreadable(const std::string& why) {
    const std::lock_guard lock(m_mutex);
    finish(why);
    abort_locked();
}

void Stream::close(std::chrono::milliseconds timeout) noexcept {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    std::unique_lock lock(m_mutex);
    if (!m_closing) {
        m_closing = true;
        m_changed.notify_all();
        if (!m_out.under_way)
            write_more();
        read_more();
    }
    if (!m_changed.wait_until(lock, deadline, [&] { return m_done; }))
        abort_locked();
}

void Stream::abort() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closing = true;
    abort_locked();
}

void Stream::abort_locked() noexcept {
    if (m_aborted)
        return;
    m_aborted = m_over = true;
    m_in.messages.clear();
    if (!m_done)
        cancel();
    stop_writing();
    m_changed.notify_all();
}

void Stream::wait_until_done() noexcept {
    std::unique_lock lock(m_mutex);
    m_changed.wait(lock, [&] { return m_done; });
}

Link::Traffic Stream::traffic() const noexcept {
    const std::lock_guard lock(m_mutex);
    return {m_out.sent_bytes, m_in.received_bytes, m_out.bytes};
}

std::string Stream::why_ended() const {
    const std::lock_guard lock(m_mutex);
    return m_end_reason;
}

void Stream::begin() {
    const std::lock_guard lock(m_mutex);
    read_more();
}

void Stream::read_more() {
    const bool room =
        m_closing || (m_in.bytes < kMaxAhead_bytes && m_in.messages.size() < kMaxAhead);
    if (m_in.under_way || m_in.ended || m_over || !room)
        return;
    m_in.under_way = true;
    start_read(&m_in.current);
}

void Stream::read_done(bool ok, const char* why_not) {
    const std::lock_guard lock(m_mutex);
    m_in.under_way = false;
    if (ok) {
        m_in.received_bytes += m_in.current.Length();
        // After closing, the owner only waits for the end of the link, and unread frames must not
        // delay that.
        if (!m_closing) {
            m_in.bytes += m_in.current.Length();
            m_in.messages.push_back(std::move(m_in.current));
        }
        m_in.current.Clear();
        read_more();
    } else {
        m_over = true;
        if (why_not != nullptr)
            finish(why_not);
        stop_writing();
    }
    m_changed.notify_all();
}

void Stream::write_more() {
    if (m_over || m_out.ended) {
        stop_writing();
    } else if (!m_out.messages.empty()) {
        m_out.current = std::move(m_out.messages.front());
        m_out.messages.pop_front();
        m_out.under_way = true;
        start_write(&m_out.current);
    } else if (m_closing) {
        m_out.ended = true;
        end_writes();
    }
}

void Stream::write_done(bool ok) {
    const std::lock_guard lock(m_mutex);
    m_out.under_way = false;
    m_out.last_write = Clock::now();
    m_out.bytes -= m_out.current.Length();
    if (ok) {
        m_out.sent_bytes += m_out.current.Length();
    } else {
        m_out.ended = true;
    }
    m_out.current.Clear();
    write_more();
    m_changed.notify_all();
}

void Stream::stop_writing() {
    for (const auto& frame : m_out.messages)
        m_out.bytes -= frame.Length();
    m_out.messages.clear();
    if (m_over && !m_out.under_way && !m_let_go) {
        m_let_go = true;
        let_go();
    }
}

void Stream::finish(const std::string& why) {
    if (m_end_reason.empty() && !m_closing)
        m_end_reason = why;
    m_ended = true;
}

void Stream::ended(const std::string& why) {
    const std::lock_guard lock(m_mutex);
    m_over = true;
    finish(why);
    stop_writing();
    m_changed.notify_all();
}

void Stream::done() noexcept {
    const std::lock_guard lock(m_mutex);
    m_done = m_ended = m_over = m_let_go = true;
    m_changed.notify_all();
}

}  // namespace terravox::net
