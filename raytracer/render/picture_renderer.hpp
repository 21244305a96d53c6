#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/thread/stop_signals.hpp"
#include "common/util/stage_times.hpp"
#include "raytracer/render/loaded_world.hpp"
#include "raytracer/render/render_pool.hpp"
#include "raytracer/render/statistics.hpp"
#include "raytracer/shade/view_maker.hpp"

namespace terravox::render {

/// What a picture is kept in while it is made.
struct KeepOptions {
    bool resume =
        false;  ///< finished tiles are kept, and those that are there are not rendered again
    bool on_farms =
        false;  ///< they are kept where workers render, too, as long as there are none yet
    std::optional<farm::Part> part;  ///< only these tiles, into their checkpoint and no picture
};

/// A world, opened once, and pictures of it in files. Not thread-safe. From its making on, SIGINT
/// and SIGTERM end a picture early instead of the program, where it has opened the world itself.
class PictureRenderer {
public:
    /// @param base what holds for all pictures: world and processing @param render_pool who renders
    /// @param quiet say nothing but errors
    /// @throws Error, UsageError
    PictureRenderer(const worlds::WorldOptions& world, const RenderPoolOptions& render_pool,
                    const scene::Scene& base, bool quiet);
    /// Of a world that is open, and whose boxes others may use meanwhile. Signals are left alone.
    /// @param stop ends a picture early
    PictureRenderer(std::shared_ptr<LoadedWorld> world, const RenderPoolOptions& render_pool,
                    const scene::Scene& base, bool quiet, std::stop_token stop);
    ~PictureRenderer();
    /// Is told of each tile, on the thread that renders.
    void on_progress(std::function<void(std::uint64_t done, std::uint64_t of)> told) {
        m_told = std::move(told);
    }

    /// Refuses, before any work is done, what cannot be written. @throws UsageError, Error
    static void check(const scene::Scene& scene, const std::vector<std::string>& files);
    /// Renders a scene and writes it to all files. Where the film would not fit into half of the
    /// memory for boxes, tiles go straight into the files. Layers are kept for EXR files alone.
    /// Warns when the world is out of sight, once.
    /// @param start from which quality.time_s counts @throws Error, UsageError
    RenderStatistics render(
        const scene::Scene& scene, const std::vector<std::string>& files,
        const KeepOptions& keep = {},
        std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now());

    [[nodiscard]] util::StageTimes& times() noexcept { return m_loaded->times; }
    /// The view of the last picture.
    [[nodiscard]] const shade::View& view() const noexcept { return *m_view; }

private:
    PictureRenderer(std::shared_ptr<LoadedWorld> world, const RenderPoolOptions& render_pool,
                    const scene::Scene& base, bool quiet,
                    std::unique_ptr<thread::StopSignals> signals);
    [[nodiscard]] RenderJob job(processors::TileProcessor& processor,
                                std::chrono::steady_clock::time_point start);
    void render_with_pool(const std::function<void(processors::TileProcessor&)>& work,
                          RenderStatistics& statistics);
    void render_to_film(RenderStatistics& statistics, const std::vector<std::string>& files,
                        std::chrono::steady_clock::time_point start);
    void render_to_files(RenderStatistics& statistics, const std::vector<std::string>& files,
                         std::chrono::steady_clock::time_point start);
    void finish(RenderStatistics& statistics, std::chrono::steady_clock::time_point start) const;

    void open_checkpoint(const scene::Scene& scene, const std::vector<std::string>& files,
                         const KeepOptions& keep);
    void render_part(RenderStatistics& statistics, std::chrono::steady_clock::time_point start);

    std::unique_ptr<thread::StopSignals> m_signals;  ///< null: signals are left alone
    const std::shared_ptr<LoadedWorld> m_loaded;
    bool m_quiet;
    int m_threads;
    const std::stop_token m_stop;
    std::function<void(std::uint64_t, std::uint64_t)> m_told;
    shade::ViewMaker m_views;
    std::unique_ptr<RenderPool> m_render_pool;
    std::unique_ptr<shade::View> m_view;
    std::unique_ptr<farm::Checkpoint> m_checkpoint;
    std::optional<farm::Part> m_part;
    bool m_warned = false;  ///< that the world is out of sight: once for all frames
};

}  // namespace terravox::render
