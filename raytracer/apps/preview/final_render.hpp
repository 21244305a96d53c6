#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"

namespace terravox::preview {

/// The shell command that renders a scene without a window. Only fields that differ from their
/// defaults are named.
/// @param scene without camera.look: a named view is expanded into the other fields
/// @param world the arguments of the world: inputs, and --ortho with each orthophoto
[[nodiscard]] std::string render_command_line(const scene::Scene& scene,
                                              const std::vector<std::string>& world,
                                              const std::string& picture);

/// Renders a scene to files in the background, bit-identical to `terravox render`. Its tracing
/// threads have a lower priority than the window's.
class FinalRender {
public:
    ~FinalRender() { stop(); }
    /// Starts a rendering. Blocks until one that is in progress has ended.
    /// @param world whose boxes it shares
    void start(std::shared_ptr<render::LoadedWorld> world, const scene::Scene& scene,
               std::vector<std::string> files, const render::RenderPoolOptions& render_pool);
    /// Requests the end of the rendering, unless its files are being written already.
    void give_up() noexcept { m_stop.request_stop(); }
    /// Cancels the rendering, and blocks until it has ended.
    void stop() noexcept;

    enum class State : std::uint8_t { kIdle, kRunning, kDone, kFailed };
    struct Status {
        State state = State::kIdle;
        std::uint64_t done = 0;  ///< finished tiles
        std::uint64_t of = 0;    ///< all tiles
        double seconds = 0;
        std::string message;  ///< after the end: the files that were written, or the error
    };
    /// Message of a rendering that was cancelled.
    static constexpr const char* kGivenUp = "given up";
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
