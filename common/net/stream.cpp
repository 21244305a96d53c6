#include "common/net/stream.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

#include "common/util/error.hpp"

namespace terravox::net {
namespace {

constexpr std::chrono::seconds kMostStalled{10};

}  // namespace

bool Stream::send(const farm::Frame& frame) {
    grpc::ByteBuffer bytes;
    bool own = false;
    const std::size_t size_bytes = frame.ByteSizeLong();
    const bool fits = size_bytes <= kMostFrame_bytes;
    if (fits && !grpc::SerializationTraits<farm::Frame>::Serialize(frame, &bytes, &own).ok())
        throw Error("send a frame to " + m_peer + ": it cannot be serialized");
    std::unique_lock lock(m_mutex);
    // A peer that takes nothing must not hold up who serves others, too.
    if (!m_changed.wait_for(lock, kMostStalled, [&] { return m_out_bytes <= kMostQueued_bytes || m_closing || m_writes_ended || m_over; })) {
        finish("it took nothing for " + std::to_string(kMostStalled.count()) + " s");
        abort_locked();
        return false;
    }
    if (m_closing || m_writes_ended || m_over) return false;
    if (!fits) {
        finish("a frame of " + std::to_string(size_bytes) + " bytes was to be sent; allowed: at most " + std::to_string(kMostFrame_bytes));
        abort_locked();
        return false;
    }
    m_out_bytes += size_bytes;
    m_out.push_back(std::move(bytes));
    if (!m_writing) write_more();
    return true;
}

std::optional<farm::Frame> Stream::receive() {
    grpc::ByteBuffer bytes;
    {
        std::unique_lock lock(m_mutex);
        m_changed.wait(lock, [&] { return m_aborted || m_ended || !m_in.empty(); });
        if (m_aborted || m_in.empty()) return std::nullopt;
        bytes = std::move(m_in.front());
        m_in.pop_front();
        m_in_bytes -= bytes.Length();
        read_more();
    }
    farm::Frame frame;
    if (grpc::SerializationTraits<farm::Frame>::Deserialize(&bytes, &frame).ok()) return frame;
    const std::lock_guard lock(m_mutex);
    finish("the other end sent a frame that cannot be read");
    abort_locked();
    return std::nullopt;
}

void Stream::close(std::chrono::milliseconds patience) noexcept {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    std::unique_lock lock(m_mutex);
    if (!m_closing) {
        m_closing = true;
        m_changed.notify_all();
        if (!m_writing) write_more();
        read_more();
    }
    if (!m_changed.wait_until(lock, deadline, [&] { return m_done; })) abort_locked();
}

void Stream::abort() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closing = true;
    abort_locked();
}

void Stream::abort_locked() noexcept {
    if (m_aborted) return;
    m_aborted = m_over = true;
    m_in.clear();
    if (!m_done) cancel();
    stop_writing();
    m_changed.notify_all();
}

void Stream::wait_until_done() noexcept {
    std::unique_lock lock(m_mutex);
    m_changed.wait(lock, [&] { return m_done; });
}

std::string Stream::why_ended() const {
    const std::lock_guard lock(m_mutex);
    return m_why;
}

void Stream::begin() {
    const std::lock_guard lock(m_mutex);
    read_more();
}

void Stream::read_more() {
    const bool room = m_closing || (m_in_bytes < kMostAhead_bytes && m_in.size() < kMostAhead);
    if (m_reading || m_reads_ended || m_over || !room) return;
    m_reading = true;
    start_read(&m_being_read);
}

void Stream::read_done(bool ok, const char* why_not) {
    const std::lock_guard lock(m_mutex);
    m_reading = false;
    if (ok) {
        m_received_bytes += m_being_read.Length();
        // Who has closed the link waits for its end alone, and must not be kept from it by frames that nobody takes.
        if (!m_closing) {
            m_in_bytes += m_being_read.Length();
            m_in.push_back(std::move(m_being_read));
        }
        m_being_read.Clear();
        read_more();
    } else {
        m_over = true;
        if (why_not != nullptr) finish(why_not);
        stop_writing();
    }
    m_changed.notify_all();
}

void Stream::write_more() {
    if (m_over || m_writes_ended) {
        stop_writing();
    } else if (!m_out.empty()) {
        m_being_written = std::move(m_out.front());
        m_out.pop_front();
        m_writing = true;
        start_write(&m_being_written);
    } else if (m_closing) {
        m_writes_ended = true;
        end_writes();
    }
}

void Stream::write_done(bool ok) {
    const std::lock_guard lock(m_mutex);
    m_writing = false;
    m_out_bytes -= m_being_written.Length();
    if (ok) {
        m_sent_bytes += m_being_written.Length();
    } else {
        m_writes_ended = true;
    }
    m_being_written.Clear();
    write_more();
    m_changed.notify_all();
}

void Stream::stop_writing() {
    for (const auto& frame : m_out) m_out_bytes -= frame.Length();
    m_out.clear();
    if (m_over && !m_writing && !m_let_go) {
        m_let_go = true;
        let_go();
    }
}

void Stream::finish(const std::string& why) {
    if (m_why.empty() && !m_closing) m_why = why;
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
