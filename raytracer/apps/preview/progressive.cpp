#include "raytracer/apps/preview/progressive.hpp"

#include <algorithm>
#include <utility>

#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/tiles/tile_plan.hpp"
#include "raytracer/farm/processors/processor_pool.hpp"

namespace terravox::preview {
namespace {

constexpr std::chrono::milliseconds kMin{
    1};  // of a call: a picture whose slices are all too short must come to its end, too
constexpr int kTilePixels = 16;  // along an edge, of those that a pass traces: smaller tiles take
                                 // more to hand out than to trace

}  // namespace

void Progressive::stop() noexcept {
    const auto begin = Clock::now();
    m_processor.reset();
    m_stop_s = std::chrono::duration<double>(Clock::now() - begin).count();
}

void Progressive::start(const scene::Scene& scene, int first_step) {
    stop();
    m_progress.whole = false;
    // The layer of sun hours is measured, too, but its values are pixels.
    if (scene.analysis.kind != core::AnalysisKind::kSunView)
        scene::check_is_picture(scene);
    m_view = std::make_shared<const shade::View>(m_views.make(scene, m_blocks));
    const auto [width, height] = scene.output.size_px;
    if (!m_film || m_film->width_px() != width || m_film->height_px() != height ||
        m_film->has_layers() != m_view->wants_layers())
        m_film = std::make_unique<output::Film>(width, height, m_view->wants_layers());
    m_first_step = first_step;
    m_changes.clear();
    m_progress = {};
    m_progress.start = Clock::now();
    plan();
    render::prefetch_visible(*m_view, m_blocks);
    m_processor = m_begin(*m_view);
    m_next_pass = 0;
    next_pass();
}

void Progressive::plan() {
    const auto& q = m_view->scene.quality;
    const int width = m_film->width_px();
    const int height = m_film->height_px();
    m_passes.clear();
    for (int step = m_first_step; step >= 1; step /= 2) {
        // Tiles of a coarse pass are larger, so that each has enough pixels to trace.
        auto tiles =
            tiles::plan_tiles(width, height, step,
                              std::max(q.tile.in_picture(width), step * kTilePixels), q.tile_order)
                .front();
        for (tiles::RenderTile& tile : tiles) {
            tile.pass = static_cast<std::uint32_t>(m_passes.size());
            tile.refines = step != m_first_step;
            tile.samples = 1;
        }
        m_passes.push_back(std::move(tiles));
    }
}

// Begins the next pass, or doubles the samples of tiles that have not converged.
void Progressive::next_pass() {
    m_pass = {};
    if (m_next_pass < m_passes.size()) {
        m_pass.tiles = m_passes[m_next_pass++];
        return;
    }
    const auto& q = m_view->scene.quality;
    const std::uint32_t more =
        std::min(m_progress.samples, static_cast<std::uint32_t>(q.samples) - m_progress.samples);
    for (tiles::RenderTile tile : m_passes.back()) {
        tile.step = 1;
        tile.refines = false;
        tile.first_sample = m_progress.samples;
        tile.samples = more;
        if (q.noise == 0 || m_progress.samples < static_cast<std::uint32_t>(q.min_samples) ||
            m_film->error_above(tile, q.noise))
            m_pass.tiles.push_back(tile);
    }
}

void Progressive::work(Clock::time_point until) {
    if (!m_processor)
        return;
    try {
        for (bool first = true;; first = false) {
            if (m_pass.done.size() == m_pass.tiles.size()) {
                m_progress.whole = true;
                if (m_progress.first_s == 0)
                    m_progress.first_s = seconds();
                if (m_next_pass == m_passes.size())
                    m_progress.samples +=
                        std::max(m_pass.tiles.empty() ? 1 : m_pass.tiles.front().samples, 1U);
                const bool finished =
                    m_pass.tiles.empty() ||
                    m_progress.samples >= static_cast<std::uint32_t>(m_view->scene.quality.samples);
                if (!finished)
                    next_pass();
                if (finished || m_pass.tiles.empty()) {
                    m_progress.all_s = seconds();
                    return stop();
                }
            }
            while (m_pass.submitted < m_pass.tiles.size() &&
                   m_pass.submitted - m_pass.done.size() <
                       static_cast<std::size_t>(m_processor->capacity()))
                m_processor->submit(m_pass.tiles[m_pass.submitted++]);
            const auto left =
                std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
            if (left.count() <= 0 && !first)
                return;
            if (!m_processor->wait(std::max(left, kMin)))
                continue;
            (void)m_processor
                ->take_invalidated();  // they are delivered again, and replace these pixels
            const auto result = m_processor->take();
            if (!result)
                throw util::Error("render: the processor ended before the picture was finished");
            add(*result);
        }
    } catch (...) {
        m_progress.all_s = seconds();
        stop();
        throw;
    }
}

void Progressive::add(const tiles::TileResult& result) {
    m_film->add(result);
    m_pass.done.insert(result.tile.index);
    m_progress.rays += result.counts.all_rays();
    m_progress.holes.insert(result.holes.begin(), result.holes.end());
    m_changes.push_back(result.tile);
}

Progressive::Status Progressive::status() const {
    Status out;
    if (!m_view)
        return out;
    const auto& tiles = m_pass.tiles;
    out.step = tiles.empty() ? 1 : tiles.front().step;
    out.samples = m_progress.samples;
    out.of_samples = static_cast<std::uint32_t>(m_view->scene.quality.samples);
    out.share = tiles.empty()
                    ? 1
                    : static_cast<double>(m_pass.done.size()) / static_cast<double>(tiles.size());
    out.first_s = m_progress.first_s;
    out.seconds = busy() ? seconds() : m_progress.all_s;
    out.rays = m_progress.rays;
    out.holes = m_progress.holes.size();
    return out;
}

}  // namespace terravox::preview
