#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/thread/stop.hpp"
#include "common/util/stage_times.hpp"
#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/farm/render/loaded_world.hpp"
#include "raytracer/farm/render/render_pool.hpp"
#include "raytracer/farm/render/statistics.hpp"

namespace terravox::render {

/// How the tiles of a picture are saved while it is rendered.
struct KeepOptions {
    /// Finished tiles are saved, and saved ones are not rendered again.
    bool resume = false;
    /// Finished tiles are saved where workers render, too; there must be no saved ones yet.
    bool on_farms = false;
    /// Only these tiles, into their checkpoint; no picture is written.
    std::optional<farm::Part> part;
};

/// A world, opened once, and pictures of it in files. Not thread-safe. If it has opened the world
/// itself, SIGINT and SIGTERM end a picture early instead of the program from construction on.
class PictureRenderer {
public:
    /// @param base settings for all pictures: world and processing
    /// @param render_pool what renders: threads, workers
    /// @param quiet print nothing but errors
    /// @throws Error, UsageError
    PictureRenderer(const worlds::WorldOptions& world, const RenderPoolOptions& render_pool,
                    const scene::Scene& base, bool quiet);
    /// For a world that is open, and whose boxes others may use meanwhile. Signal handlers are not
    /// changed.
    /// @param stop ends a picture early
    PictureRenderer(std::shared_ptr<LoadedWorld> world, const RenderPoolOptions& render_pool,
                    const scene::Scene& base, bool quiet, std::stop_token stop);
    ~PictureRenderer();
    /// Sets a callback for each tile, called on the rendering thread.
    void on_progress(std::function<void(std::uint64_t done, std::uint64_t of)> reported) {
        m_reported = std::move(reported);
    }

    /// Checks, before any work is done, that all files can be written.
    /// @throws UsageError, Error
    static void check(const scene::Scene& scene, const std::vector<std::string>& files);
    /// Renders a scene and writes it to all files. Where the film would not fit into half of the
    /// memory for boxes, tiles are streamed to the files. Layers are kept only for EXR files. Warns
    /// once when the world is out of sight.
    /// @param start time from which quality.time_s counts
    /// @throws Error, UsageError
    RenderStatistics render(
        const scene::Scene& scene, const std::vector<std::string>& files,
        const KeepOptions& keep = {},
        std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now());

    /// Renders a scene tile by tile into a sink of the caller's: an analysis, a map.
    /// @param file that the sink is for: names the checkpoint
    /// @param begin makes the sink anew, and returns it; called again where the picture must be
    /// started again
    /// @param write makes the file of the finished sink; the checkpoint is kept until it has
    /// @throws Error, UsageError
    RenderStatistics render_tiles(
        const scene::Scene& scene, const std::string& file,
        const std::function<output::TileSink&()>& begin,
        const std::function<void(const RenderStatistics&)>& write, const KeepOptions& keep = {},
        std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now());

    [[nodiscard]] util::StageTimes& times() noexcept { return m_loaded->times; }
    /// The view of the last picture.
    [[nodiscard]] const shade::View& view() const noexcept { return *m_view; }

private:
    PictureRenderer(std::shared_ptr<LoadedWorld> world, const RenderPoolOptions& render_pool,
                    const scene::Scene& base, bool quiet,
                    std::unique_ptr<thread::StopSignals> signals);
    /// Renders the picture, once more where it has to start again.
    /// @param work returns what a job costs
    void trace(const std::function<RenderCounts(const RenderJob&)>& work,
               RenderStatistics& statistics, std::chrono::steady_clock::time_point start);
    void render_to_film(RenderStatistics& statistics, const std::vector<std::string>& files,
                        std::chrono::steady_clock::time_point start);
    void render_to_files(RenderStatistics& statistics, const std::vector<std::string>& files,
                         std::chrono::steady_clock::time_point start);
    void finish(RenderStatistics& statistics, std::chrono::steady_clock::time_point start) const;

    void prepare(scene::Scene scene, const std::vector<std::string>& files,
                 const KeepOptions& keep);
    void finish_checkpoint(const RenderStatistics& statistics);
    void open_checkpoint(const scene::Scene& scene, const std::vector<std::string>& files,
                         const KeepOptions& keep);

    std::unique_ptr<thread::StopSignals> m_signals;  ///< null: signal handlers are not changed
    const std::shared_ptr<LoadedWorld> m_loaded;
    bool m_quiet;
    int m_threads;
    const std::stop_token m_stop;
    std::function<void(std::uint64_t, std::uint64_t)> m_reported;
    shade::ViewMaker m_views{analyse::measure};
    std::unique_ptr<RenderPool> m_render_pool;
    std::unique_ptr<shade::View> m_view;
    std::unique_ptr<farm::Checkpoint> m_checkpoint;
    std::optional<farm::Part> m_part;
    bool m_warned = false;  ///< that the world is out of sight: once for all frames
};

}  // namespace terravox::render
