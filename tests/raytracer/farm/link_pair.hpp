#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>

#include "raytracer/farm/net/link.hpp"

namespace terravox::net {

/// Frames in one direction. They are serialized as on a wire: nothing but their bytes arrives.
class FramePipe {
public:
    bool put(const farm::Frame& frame) {
        std::string bytes = frame.SerializeAsString();
        const std::lock_guard lock(m_mutex);
        if (m_ended)
            return false;
        m_bytes += bytes.size();
        m_frames.push_back(std::move(bytes));
        m_arrived.notify_all();
        return true;
    }
    std::optional<farm::Frame> get() {
        std::unique_lock lock(m_mutex);
        m_arrived.wait(lock, [&] { return m_aborted || m_ended || !m_frames.empty(); });
        if (m_aborted || m_frames.empty())
            return std::nullopt;
        farm::Frame frame;
        const bool whole =
            m_frames.front().size() <= kMaxFrame_bytes && frame.ParseFromString(m_frames.front());
        m_frames.pop_front();
        if (m_frames.empty())
            m_arrived.notify_all();
        if (!whole)
            return std::nullopt;
        return frame;
    }
    /// Accepts no more frames, and waits until those inside have been received.
    void end(std::chrono::milliseconds timeout) noexcept {
        std::unique_lock lock(m_mutex);
        m_ended = true;
        m_arrived.notify_all();
        m_arrived.wait_for(lock, timeout, [&] { return m_aborted || m_frames.empty(); });
    }
    void abort() noexcept {
        const std::lock_guard lock(m_mutex);
        m_ended = m_aborted = true;
        m_arrived.notify_all();
    }
    [[nodiscard]] std::uint64_t bytes() const noexcept {
        const std::lock_guard lock(m_mutex);
        return m_bytes;
    }

private:
    mutable std::mutex m_mutex;
    std::condition_variable m_arrived;
    std::deque<std::string> m_frames;
    std::uint64_t m_bytes = 0;
    bool m_ended = false;
    bool m_aborted = false;
};

class PairedLink final : public Link {
public:
    PairedLink(std::shared_ptr<FramePipe> in, std::shared_ptr<FramePipe> out, std::string peer)
        : m_in(std::move(in)), m_out(std::move(out)), m_peer(std::move(peer)) {}
    ~PairedLink() override { abort(); }
    bool send(farm::Frame frame) override { return m_out->put(frame); }
    std::optional<farm::Frame> receive() override {
        auto frame = m_in->get();
        if (!frame)
            m_ended = true;
        return frame;
    }
    void close(std::chrono::milliseconds timeout) noexcept override {
        m_closed = true;
        m_out->end(timeout);
    }
    void abort() noexcept override {
        m_closed = true;
        m_in->abort();
        m_out->abort();
    }
    const std::string& peer() const noexcept override { return m_peer; }
    std::string why_ended() const override {
        return m_ended && !m_closed ? "the other end closed it" : "";
    }
    Traffic traffic() const noexcept override {
        return {.sent_bytes = m_out->bytes(), .received_bytes = m_in->bytes()};
    }

private:
    std::shared_ptr<FramePipe> m_in;
    std::shared_ptr<FramePipe> m_out;
    std::string m_peer;
    std::atomic<bool> m_ended{false};
    std::atomic<bool> m_closed{false};
};

/// Both ends of a link within this process.
[[nodiscard]] inline std::pair<std::unique_ptr<Link>, std::unique_ptr<Link>> link_pair() {
    auto there = std::make_shared<FramePipe>();
    auto back = std::make_shared<FramePipe>();
    return {std::make_unique<PairedLink>(back, there, "pair:1"),
            std::make_unique<PairedLink>(there, back, "pair:2")};
}

}  // namespace terravox::net
