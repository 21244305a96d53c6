#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <set>

#include "raytracer/apps/preview/frame_pacer.hpp"
#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/apps/preview/pane.hpp"
#include "raytracer/apps/preview/probe_processor.hpp"
#include "raytracer/apps/preview/progressive.hpp"
#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/farm/render/render_pool.hpp"

namespace terravox::preview {

/// Retries one of the boxes that a picture lacks, at growing intervals: a server may be back. Used
/// by one thread.
class HoleWatch final : public blocks::BlockListener {
public:
    using Clock = std::chrono::steady_clock;

    explicit HoleWatch(blocks::BlockManager& blocks) : m_blocks(blocks) {}
    ~HoleWatch() override { m_blocks.forget(*this); }

    /// To be called often: a box that has been loaded stays in memory until then. A retry forgets
    /// all holes.
    /// @param holes that the last picture met
    /// @param idle_since when that picture was finished; nullopt: a picture is being rendered, and
    /// nothing is retried
    /// @return whether one of the boxes has been loaded, so that the picture should be rendered
    /// again
    [[nodiscard]] bool look(const std::set<voxel::BoxKey>& holes,
                            std::optional<Clock::time_point> idle_since, Clock::time_point now);

    bool on_block_loaded(const voxel::BoxKey&, std::uint64_t) noexcept override {
        return m_loaded = true;
    }
    static constexpr std::chrono::seconds kFirst{10};
    static constexpr std::chrono::seconds kMax{640};

private:
    blocks::BlockManager& m_blocks;
    std::chrono::seconds m_wait = kFirst;
    Clock::time_point m_since;
    std::optional<voxel::BoxKey> m_requested;
    std::size_t m_turn = 0;
    std::atomic<bool> m_loaded{false};
};

/// Decides when a probe layer (is_probe) is made again because boxes were not in memory: soon while
/// more of them are loaded each time, and at growing intervals while none are. Used by one thread.
class ProbeRetry {
public:
    using Clock = std::chrono::steady_clock;

    /// To be called for another scene or layer, of whose boxes nothing is known.
    void reset() noexcept {
        m_wait = kMin;
        m_missing = std::numeric_limits<std::size_t>::max();
    }
    void begin(Clock::time_point now) noexcept { m_began = now; }
    [[nodiscard]] bool is_due(Clock::time_point now) const noexcept {
        return now - m_began >= m_wait;
    }
    /// To be called when the layer is made again.
    /// @param missing number of boxes that the last probes did not find
    void note(std::size_t missing) noexcept {
        m_wait = missing < m_missing ? kMin : std::min(2 * m_wait, kMax);
        m_missing = missing;
    }
    static constexpr std::chrono::milliseconds kMin{500};
    static constexpr std::chrono::milliseconds kMax{16'000};

private:
    Clock::time_point m_began;
    std::chrono::milliseconds m_wait = kMin;
    std::size_t m_missing = std::numeric_limits<std::size_t>::max();
};

/// Rows of a picture, half-open; empty where first >= end.
struct RowRange {
    int first = 0;
    int end = 0;
    [[nodiscard]] bool empty() const noexcept { return first >= end; }
};

/// Develops a progressive picture for the window: tiles that are new in the film, or the whole film
/// when exposure, tone or layer have changed. Used by one thread.
class ScreenDeveloper {
public:
    /// To be called when a new picture begins; the screen stays until its tiles replace it.
    void begin_picture() noexcept { m_develops_all = false; }
    /// Sets the size of the picture in progress. The screen is cleared if the size differs.
    void resize(int width_px, int height_px) { m_screen.resize(width_px, height_px); }
    /// To be called when another layer of the same film is shown.
    void develop_again() noexcept { m_develops_all = true; }

    /// @param output exposure and tone
    /// @return the rows of the screen that have changed
    [[nodiscard]] RowRange update(Progressive& picture, const scene::Scene::Output& output,
                                  Layer layer);
    [[nodiscard]] const ScreenPicture& screen() const noexcept { return m_screen; }

private:
    ScreenPicture m_screen;
    scene::Scene::Output m_output;  ///< exposure and tone of the screen
    /// The screen was developed with other settings. It is developed again once the picture is
    /// whole, so that no pixels of the previous picture reappear.
    bool m_develops_all = false;
};

/// The scene that must be rendered to show a layer in a pane, without exposure and tone, which need
/// no new rendering.
/// @param resolution ratio of the picture's pixels to the pane's, along an edge
[[nodiscard]] scene::Scene scene_to_show(Layer layer, const scene::Scene& scene, double resolution,
                                         const Pane& pane);

/// The picture in the window. It is rendered progressively by a render pool, and starts again when
/// the scene changes, or when a missing box has arrived. Used by one thread.
///
/// The clock is a parameter; times of a picture itself are those of Progressive.
class LivePicture {
public:
    using Clock = Progressive::Clock;

    /// @param blocks, times outlive the picture
    /// @param source as that of RenderPool
    /// @throws as RenderPool
    LivePicture(const render::RenderPoolOptions& render_pool, blocks::BlockManager& blocks,
                const farm::BoxSource& source, FrameTimes& times);

    /// Retries boxes that the finished picture lacks, at growing intervals. To be called each
    /// frame.
    /// @param may_retry a retry may succeed
    /// @return whether a missing box has been loaded, so that the next update() should start again
    [[nodiscard]] bool has_missing_box_arrived(bool may_retry, Clock::time_point now);

    /// Starts the picture again if the scene differs from the picture's; a first pass in progress
    /// may continue for 50 ms.
    /// @param wanted from scene_to_show()
    /// @param restart whether to start again in any case
    /// @param changed_at when a change may have been made
    /// @throws util::Error for a scene that cannot be rendered; it is not tried again
    void update(const scene::Scene& wanted, Layer layer, bool restart, Clock::time_point changed_at,
                Clock::time_point now);
    /// Starts the measurement of the time to the next first picture; to be called once before the
    /// first update().
    void note_change(Clock::time_point changed_at);
    /// As Progressive::work().
    /// @throws what a tile threw; the picture is stopped then
    void work(Clock::time_point until) { m_picture.work(until); }
    /// The next update() starts again, although the scene is the same.
    void invalidate() { m_shown.reset(); }
    /// Ends the measurement of the last change's time, as an error ended its picture.
    void forget_change() { m_changed_at.reset(); }

    /// Develops the tiles that are new.
    /// @param output exposure and tone
    /// @return rows of screen() that changed
    [[nodiscard]] RowRange develop(const scene::Scene::Output& output) {
        return m_developer.update(m_picture, output, m_layer);
    }
    [[nodiscard]] const ScreenPicture& screen() const noexcept { return m_developer.screen(); }
    /// To be called when the window shows screen(). If this is the first picture after a change,
    /// its time is recorded, and the resolution of the next first pass is adapted to it.
    void note_shown(Clock::time_point now);
    void stop() noexcept { m_picture.stop(); }

    [[nodiscard]] const Progressive& progressive() const noexcept { return m_picture; }
    [[nodiscard]] render::RenderPool& render_pool() noexcept { return m_render_pool; }
    /// Whether the picture is being computed, or will be.
    [[nodiscard]] bool busy() const noexcept { return m_picture.busy() || m_changed_at; }
    /// Number of boxes that a probe layer (is_probe) should show and that are not in memory.
    [[nodiscard]] std::size_t missing() const noexcept { return m_probe ? m_probe->missing() : 0; }
    [[nodiscard]] std::uint64_t started_count() const noexcept { return m_started_count; }

private:
    [[nodiscard]] std::shared_ptr<processors::TileProcessor> begin(const shade::View& view);
    void update_layer(const scene::Scene& wanted, Layer layer, Clock::time_point now);
    void start(const scene::Scene& wanted, int first_step, Clock::time_point now);

    blocks::BlockManager& m_blocks;
    FrameTimes& m_times;
    render::RenderPool m_render_pool;
    std::shared_ptr<ProbeProcessor> m_probe;  ///< set while a probe layer is shown
    Progressive m_picture;
    HoleWatch m_holes;
    ScreenDeveloper m_developer;
    ProbeRetry m_probe_retry;
    std::optional<scene::Scene> m_shown;  ///< the picture's scene; nullopt: to be started again
    Layer m_layer = Layer::kBeauty;
    int m_first_step = 8;
    /// When the change was made that the picture in progress will show; nullopt once it is shown.
    std::optional<Clock::time_point> m_changed_at;
    Clock::time_point m_started_at;
    Clock::time_point m_idle_since;
    std::uint64_t m_started_count = 0;
};

}  // namespace terravox::preview
