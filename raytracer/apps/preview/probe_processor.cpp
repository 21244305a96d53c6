#include "raytracer/apps/preview/probe_processor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terravox::preview {
namespace {

constexpr std::size_t kPixelsAtOnce = 256;  // between two readings of the clock
constexpr voxel::Colour kSky{0.06f, 0.06f, 0.07f};
constexpr voxel::Colour kMissing{1.0f, 0.55f, 0.1f};
constexpr voxel::Colour kHole{1.0f, 0.0f, 0.8f};

/// Shades faces, brightest from above, so that shapes are recognizable.
float light_on(core::Face face) noexcept {
    switch (face) {
        case core::Face::kTop: return 1;
        case core::Face::kWest:
        case core::Face::kEast: return 0.75f;
        case core::Face::kNorth:
        case core::Face::kSouth: return 0.6f;
        default: return 0.45f;
    }
}

/// Blue, green, yellow, red, for [0, 1].
voxel::Colour heat(double share) noexcept {
    const double h = 4 * std::clamp(share, 0.0, 1.0);
    const auto ramp = [](double v) { return static_cast<float>(std::clamp(v, 0.0, 1.0)); };
    return {ramp(h - 1.5), ramp(h < 2.5 ? h - 0.3 : 4 - h), ramp(1.6 - h)};
}

voxel::Colour of_steps(std::uint64_t steps) noexcept {
    constexpr double kMax_log2 = 10;
    return heat(std::log2(static_cast<double>(steps) + 1) / kMax_log2);
}

voxel::Colour chequer(const walk::Hit& hit) noexcept {
    const int shift = 6;
    const int high = 8;
    const bool odd =
        (((hit.voxel.x >> shift) + (hit.voxel.y >> high) + (hit.voxel.z >> shift)) & 1) != 0;
    return odd ? voxel::Colour{0.35f, 0.75f, 0.45f} : voxel::Colour{0.25f, 0.55f, 0.75f};
}

}  // namespace

ProbeProcessor::ProbeProcessor(const shade::View& view, blocks::BlockManager& blocks, Layer layer)
    : m_view(view),
      m_blocks(blocks),
      m_layer(layer),
      m_reader(blocks),
      m_walk(m_reader, view.cut) {}

voxel::Colour ProbeProcessor::probe(double px, double py, tiles::PixelSample& sample) {
    sample.alpha = 0;
    sample.depth_m = std::numeric_limits<float>::infinity();
    const auto ray = m_view.camera.ray(px, py, 0.5, 0.5);
    if (!ray)
        return kSky;
    core::RayState state(*ray);
    if (!state.enter(m_view.cut.entry_bounds()))
        return kSky;
    const std::uint64_t before = m_walk.counts().steps;
    walk::Hit hit;
    const walk::WalkEnd end = m_walk.first_hit(state, walk::StopAt::kSolid, core::kFar, hit);
    const std::uint64_t steps = m_walk.counts().steps - before;
    if (end == walk::WalkEnd::kWaits) {
        m_missing.insert(m_walk.missing());
        return kMissing;
    }
    if (m_layer == Layer::kSteps)
        return of_steps(steps);
    if (end == walk::WalkEnd::kMiss)
        return kSky;
    sample.alpha = 1;
    sample.depth_m = static_cast<float>(hit.t * m_view.voxel_m);
    if (hit.hole)
        return kHole;
    return (m_layer == Layer::kLevels ? colour_of_level(hit.level) : chequer(hit)) *
           light_on(hit.face);
}

bool ProbeProcessor::trace_until(std::chrono::steady_clock::time_point until) {
    do {
        if (!m_begun) {
            if (m_waiting.empty())
                return false;
            m_under_way = {};
            m_under_way.tile = m_waiting.front();
            m_waiting.pop_front();
            m_pixels.clear();
            m_next = 0;
            m_under_way.tile.each_pixel([this](int x, int y) { m_pixels.emplace_back(x, y); });
            m_under_way.samples.resize(m_pixels.size());
            m_begun = true;
        }
        const std::size_t end = std::min(m_next + kPixelsAtOnce, m_pixels.size());
        for (; m_next < end; ++m_next) {
            tiles::PixelSample& sample = m_under_way.samples[m_next];
            sample.colour =
                probe(m_pixels[m_next].first + 0.5, m_pixels[m_next].second + 0.5, sample);
        }
        if (m_next == m_pixels.size()) {
            m_result = std::move(m_under_way);
            m_begun = false;
            // No ray waits for the box, so it must be requested here.
            if (m_waiting.empty() && !m_missing.empty())
                m_blocks.prefetch({m_missing.begin(), m_missing.end()});
            return true;
        }
    } while (std::chrono::steady_clock::now() < until);
    return false;
}

std::optional<tiles::TileResult> ProbeProcessor::take() {
    while (!m_result && !m_closed && trace_until(std::chrono::steady_clock::time_point::max())) {
    }
    return std::exchange(m_result, std::nullopt);
}

}  // namespace terravox::preview
