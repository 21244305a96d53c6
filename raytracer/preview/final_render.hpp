#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/render/picture_renderer.hpp"

namespace terravox::preview {

/// The picture of a scene in files, as `terravox render` makes it, on a thread beside the window:
/// bit for bit the same. Threads that trace for it give way to the window's.
class FinalRender {
public:
    ~FinalRender() { stop(); }
    /// One that was under way is waited for. @param world whose boxes it shares
    void start(std::shared_ptr<render::LoadedWorld> world, const scene::Scene& scene,
               std::vector<std::string> files, const render::RenderPoolOptions& render_pool);
    void give_up() noexcept { m_stop.request_stop(); }  ///< soon; not once it is being written
    /// Gives it up, and waits until that is so.
    void stop() noexcept;

    enum class State : std::uint8_t { kIdle, kRunning, kDone, kFailed };
    struct Status {
        State state = State::kIdle;
        std::uint64_t done = 0, of = 0;  ///< tiles
        double seconds = 0;
        std::string message;  ///< of one that has ended: what was written, or what went wrong
    };
    static constexpr const char* kGivenUp = "given up";  ///< message of one that was
    [[nodiscard]] Status status() const;
    [[nodiscard]] bool runs() const { return status().state == State::kRunning; }

private:
    void run(const std::shared_ptr<render::LoadedWorld>& world, const scene::Scene& scene,
             const std::vector<std::string>& files, const render::RenderPoolOptions& render_pool);

    std::stop_source m_stop;
    mutable std::mutex m_mutex;
    Status m_status;
    std::chrono::steady_clock::time_point m_start;
    std::thread m_thread;
};

}  // namespace terravox::preview
