#pragma once

#include <memory>
#include <optional>
#include <semaphore>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "raytracer/farm/net/link.hpp"
#include "raytracer/farm/worker/worker_daemon.hpp"
#include "tests/raytracer/farm_bench.hpp"

namespace terravox::test {

/// A coordinator that leases arbitrary tiles to a worker, and never sends a box by itself: tiles in
/// progress do not end.
class FakeCoordinator {
public:
    FakeCoordinator(int threads, std::size_t memory_bytes)
        : m_daemon(options(threads, memory_bytes)) {
        auto [mine, theirs] = net::link_pair();
        m_link = std::move(mine);
        m_serving = std::thread([this, end = std::move(theirs)]() mutable {
            m_end = m_daemon.serve(std::move(end), false);
        });
        farm::OwnHello own;
        own.role = farm::COORDINATOR;
        (void)farm::meet(*m_link, farm::make_hello(own), {farm::WORKER});
        // A worker leaves a coordinator that is silent for too long, and a test may have to wait
        // for a slow machine.
        m_pinging = std::thread([this] {
            do {
                farm::Frame frame;
                frame.mutable_ping()->set_stamp(0);
                (void)m_link->send(std::move(frame));
            } while (!m_over.try_acquire_for(farm::farm_times().ping));
        });
    }
    ~FakeCoordinator() { (void)hang_up(); }

    /// @param id of the picture; later ones are of the same world
    void begin(const farm::PictureSpec& spec, std::uint64_t id = 1) {
        m_picture = id;
        farm::Frame frame;
        farm::Picture& picture = *frame.mutable_picture();
        picture.set_id(id);
        picture.set_scene(farm::state_hash(spec.scene));
        picture.set_materials(farm::state_hash(spec.materials));
        picture.set_world(farm::state_hash(spec.world));
        picture.set_asked(true);
        (void)m_link->send(std::move(frame));
        for (const std::string* text : {&spec.scene, &spec.materials, &spec.world})
            tell(*text);
    }
    void tell(const std::string& text) {
        farm::Frame frame;
        frame.mutable_state()->set_hash(farm::state_hash(text));
        frame.mutable_state()->set_content(text);
        (void)m_link->send(std::move(frame));
    }
    void lease(const tiles::RenderTile& tile, std::uint64_t id) {
        farm::Frame frame;
        frame.mutable_task()->set_picture(m_picture);
        *frame.mutable_task()->add_tiles() = farm::to_frame(tile, id);
        (void)m_link->send(std::move(frame));
    }
    /// The picture that was begun last has ended, or one of its tiles is not needed any more.
    void stop(std::optional<std::uint64_t> tile = std::nullopt) {
        farm::Frame frame;
        frame.mutable_stop()->set_picture(m_picture);
        if (tile)
            frame.mutable_stop()->add_ids(*tile);
        (void)m_link->send(std::move(frame));
    }
    /// The worker gives back what it has not begun, and leaves.
    void drain() {
        m_draining = std::thread([this] {
            std::stop_source ending;
            ending.request_stop();
            m_daemon.run(ending.get_token());
        });
    }
    /// Returns when the worker has read all that was sent before.
    /// @return whether one of its frames until then fits
    template <class Fits>
    bool settle(const Fits& fits) {
        farm::Frame frame;
        frame.mutable_ping()->set_stamp(++m_stamp);
        (void)m_link->send(std::move(frame));
        bool has_fitted = false;
        (void)next([&](const farm::Frame& f) {
            has_fitted = has_fitted || fits(f);
            return f.has_pong() && f.pong().stamp() == m_stamp;
        });
        return has_fitted;
    }
    void settle() {
        (void)settle([](const farm::Frame&) { return false; });
    }
    /// @param hole why; empty: it is air
    void reply(const farm::BoxKey& key, const std::string& hole) {
        farm::Frame frame;
        *frame.mutable_box()->mutable_key() = key;
        if (hole.empty())
            frame.mutable_box()->set_air(true);
        else
            frame.mutable_box()->set_hole(hole);
        (void)m_link->send(std::move(frame));
    }
    /// The first frame that fits; nullopt: the worker has ended the link.
    template <class Fits>
    std::optional<farm::Frame> next(const Fits& fits) {
        while (auto frame = m_link->receive()) {
            m_asked.insert(m_asked.end(), frame->need_box().keys().begin(),
                           frame->need_box().keys().end());
            if (fits(*frame))
                return frame;
        }
        return std::nullopt;
    }
    /// Boxes that all frames read so far have requested, with repetitions, since the last call.
    [[nodiscard]] std::vector<farm::BoxKey> take_asked() { return std::exchange(m_asked, {}); }
    farm::WorkerSession::End hang_up() {
        m_link->abort();
        m_over.release();
        for (std::thread* thread : {&m_pinging, &m_serving, &m_draining})
            if (thread->joinable())
                thread->join();
        return m_end;
    }

private:
    static farm::WorkerDaemonOptions options(int threads, std::size_t memory_bytes) {
        farm::WorkerDaemonOptions out;
        out.threads = threads;
        out.memory_bytes = memory_bytes;
        return out;
    }
    farm::WorkerDaemon m_daemon;
    std::unique_ptr<net::Link> m_link;
    std::uint64_t m_picture = 0, m_stamp = 0;
    std::vector<farm::BoxKey> m_asked;
    std::counting_semaphore<> m_over{0};
    farm::WorkerSession::End m_end = farm::WorkerSession::End::kBye;
    std::thread m_serving, m_pinging, m_draining;
};

inline farm::PictureSpec make_spec(bool layers) {
    const Job job(farm_scene(layers));
    return farm::pack(job.view.scene, job.blocks.world_info());
}

}  // namespace terravox::test
