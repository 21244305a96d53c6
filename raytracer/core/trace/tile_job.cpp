#include "raytracer/core/trace/tile_job.hpp"

#include <algorithm>

namespace terravox::trace {
namespace {

constexpr std::size_t kBlockPixels = std::size_t{kPixelBlockSide} * kPixelBlockSide;

}  // namespace

void TileJob::start(const tiles::RenderTile& tile, std::size_t wave_rays) {
    m_wave_rays = wave_rays;
    m_begun = false;
    m_counts = {};
    m_pixels.start(tile);
    m_wave.clear();
    m_holes.clear();
}

bool TileJob::run(TracerTools& tools, const thread::StopCondition& stop) {
    const std::uint64_t steps = tools.steps();
    const std::uint64_t slabs = tools.slabs();
    m_clock.restart();
    const bool finished = trace(tools, stop);
    m_counts.steps += tools.steps() - steps;
    m_counts.slabs += tools.slabs() - slabs;
    m_holes.merge(tools.walk.take_holes());
    m_holes.merge(tools.surroundings.take_holes());
    m_holes.merge(tools.lamps.take_holes());
    return finished;
}

bool TileJob::trace(TracerTools& tools, const thread::StopCondition& stop) {
    if (!m_begun) {
        begin(tools);
        if (stop.is_met())
            return false;
    }
    while (true) {
        const bool walked = m_wave.walk(tools, m_samples, stop, m_counts);
        m_clock.lap(tiles::TraceStage::kSingle, m_counts);
        if (!walked)
            return false;
        m_wave.shade(tools, m_samples, m_clock, m_counts);
        if (m_wave.empty() && !end_round(tools))
            return true;
        if (stop.is_met())
            return false;
    }
}

void TileJob::begin(TracerTools& tools) {
    const std::size_t pixels = m_pixels.cut(tools.view.camera, tools.beams);
    m_accumulator.begin_tile(pixels, tools.view.wants_layers(), tools.view.bands());
    m_clock.lap(tiles::TraceStage::kBeams, m_counts);
    begin_part(*tools.shading);
    begin_round(tools);
    m_begun = true;
}

void TileJob::begin_part(const shade::RayEvaluator& evaluator) {
    const std::size_t blocks = evaluator.wave_pixels(m_wave_rays) / kBlockPixels;
    m_pixels.next_part(std::max<std::size_t>(blocks, 1));
    m_accumulator.begin_part(m_pixels.pixels().size());
}

void TileJob::begin_round(TracerTools& tools) {
    m_samples.assign(m_accumulator.active().size(), {});
    PrimaryRays rays(tools, m_pixels.pixels(), m_accumulator.active(), m_samples, m_wave, m_counts);
    rays.make(m_pixels.tile().first_sample + m_accumulator.round());
    m_clock.lap(tiles::TraceStage::kPrimary, m_counts);
}

// Returns false if the tile is finished.
bool TileJob::end_round(TracerTools& tools) {
    const std::uint32_t wanted_samples = m_pixels.tile().samples;
    const bool part_goes_on = m_accumulator.add_round(m_samples, tools.view, wanted_samples);
    if (!part_goes_on)
        m_accumulator.end_part(m_pixels.pixels(), tools.view.voxel_m);
    m_clock.lap(tiles::TraceStage::kPixels, m_counts);
    if (!part_goes_on) {
        if (m_pixels.is_last_part())
            return false;
        begin_part(*tools.shading);
    }
    begin_round(tools);
    return true;
}

tiles::TileResult TileJob::take_result() {
    return {m_pixels.tile(),
            m_accumulator.take_samples(),
            m_accumulator.take_layers(),
            m_accumulator.take_bands(),
            m_counts,
            std::move(m_holes)};
}

}  // namespace terravox::trace
