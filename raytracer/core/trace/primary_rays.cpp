#include "raytracer/core/trace/primary_rays.hpp"

#include <optional>

namespace terravox::trace {
void PrimaryRays::make(std::uint32_t sample) {
    m_rays = m_wave.begin(m_active.size());
    const auto size = static_cast<std::uint32_t>(m_active.size());
    for (std::uint32_t i = 0; i < size; ++i) {
        const TilePixel& pixel = m_pixels[m_active[i]];
        m_samples[i].numbers =
            shade::Sampler(pixel.x, pixel.y, sample, m_tools.view.scene.quality.seed);
    }
    std::uint32_t end = 0;
    for (std::uint32_t first = 0; first < size; first = end) {
        const PixelBlock& block = *m_pixels[m_active[first]].block;
        end = first + 1;
        while (end < size && m_pixels[m_active[end]].block == &block)
            ++end;
        if (m_tools.packets && block.start.kind == walk::BeamStart::Kind::kPlane) {
            make_packet(block, first, end - first);
            continue;
        }
        for (std::uint32_t i = first; i < end; ++i)
            make_single(i);
    }
    m_counts.rays[static_cast<std::size_t>(walk::RayKind::kPrimary)] += m_rays.size();
}

std::pair<double, double> PrimaryRays::picture_point(std::uint32_t place) const noexcept {
    const TilePixel& pixel = m_pixels[m_active[place]];
    if (m_tools.view.scene.quality.samples == 1)
        return {pixel.x + 0.5, pixel.y + 0.5};
    const shade::Sampler::Pair at = m_samples[place].numbers.in_pixel();
    return {pixel.x + at.u, pixel.y + at.v};
}

void PrimaryRays::make_single(std::uint32_t place) {
    const shade::View& view = m_tools.view;
    const walk::BeamStart& start = m_pixels[m_active[place]].block->start;
    const auto [px, py] = picture_point(place);
    const shade::Sampler::Pair lens = view.camera.has_lens() ? m_samples[place].numbers.on_lens()
                                                             : shade::Sampler::Pair{0.5, 0.5};
    const std::optional<core::Ray> sent = view.camera.ray(px, py, lens.u, lens.v);
    walk::TracedRay& ray = m_rays[place];
    ray = m_tools.shading->primary(sent ? *sent : view.camera.ray(px, py), place);
    if (!sent) {
        // Nothing is seen there: black, and no share of anything.
        ray.end = walk::WalkEnd::kMiss;
        ray.weight = {};
        return;
    }
    if (start.kind != walk::BeamStart::Kind::kMiss) {
        ray.state = core::RayState(ray.ray);
        if (start.place(ray.state, view.cut)) {
            m_wave.add_pending(place);
            return;
        }
    }
    ray.end = walk::WalkEnd::kMiss;
    ++m_counts.spared;
}

void PrimaryRays::make_packet(const PixelBlock& block, std::uint32_t first, std::uint32_t count) {
    walk::PrimaryLanes lanes =
        walk::primary_lanes(m_tools.view.camera, block.start, m_tools.view.cut);
    for (std::uint32_t i = 0; i < walk::RayPacket::kLanes; ++i) {
        const auto [px, py] = picture_point(first + (i < count ? i : 0));
        lanes.px[i] = px;
        lanes.py[i] = py;
    }
    walk::RayPacket packet;
    walk::Hit hits[walk::RayPacket::kLanes];
    const std::uint32_t placed = walk::packet_steps()->primary(packet, lanes) & ((1U << count) - 1);
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((placed >> i & 1) == 0) {
            make_single(first + i);
            continue;
        }
        const core::Vec3 direction = {packet.direction[0][i], packet.direction[1][i],
                                      packet.direction[2][i]};
        m_rays[first + i] = m_tools.shading->primary({lanes.camera.position, direction}, first + i);
    }
    const walk::PacketWalk::Ends ends = m_tools.packets->first_hits(packet, placed, hits);
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((placed >> i & 1) == 0)
            continue;
        walk::TracedRay& ray = m_rays[first + i];
        if ((ends.missed >> i & 1) != 0) {
            ray.end = walk::WalkEnd::kMiss;
            continue;
        }
        m_wave.add_pending(first + i);
        if ((ends.hit >> i & 1) != 0) {
            ray.end = walk::WalkEnd::kHit;
            ray.hit = hits[i];
        } else {
            ray.state = core::RayState(ray.ray);
            packet.update(static_cast<int>(i), ray.state);
        }
    }
}

}  // namespace terravox::trace
