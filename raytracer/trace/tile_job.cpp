#include "raytracer/trace/tile_job.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/shade/random.hpp"

namespace terravox {
namespace {

constexpr std::size_t kPartBlocks = 256;  // 4096 rays: about a megabyte

/// Where sample s of a pixel lies in it.
/// Ref: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018 (R2), shifted by a number of the pixel's own.
struct SamplePoint {
    SamplePoint(int x, int y, int s, int samples) {
        const auto id = static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint32_t>(x);
        const double shift_u = samples == 1 ? 0 : unit_from(hash64(id, 1)), shift_v = samples == 1 ? 0 : unit_from(hash64(id, 2));
        u = 0.5 + 0.7548776662466927 * s + shift_u, v = 0.5 + 0.5698402909980532 * s + shift_v;
        u -= std::floor(u), v -= std::floor(v);
    }
    double u, v;
};

}  // namespace

void TileJob::start(const RenderTile& tile) {
    m_tile = tile;
    m_round = -1;
    m_part_begin = m_part_end = 0;
    m_counts = {};
    m_blocks.clear();
    m_wave.clear();
    m_pending.clear();
    m_parked.clear();
    m_missing.clear();
    m_holes.clear();
    const auto first = [&](int v) { return (v + tile.step - 1) / tile.step * tile.step; };
    const auto count = [&](int begin, int end) { return std::max((end - begin + tile.step - 1) / tile.step, 0); };
    m_lattice = {first(tile.x0), first(tile.y0), tile.step, count(first(tile.x0), tile.x1), count(first(tile.y0), tile.y1)};
}

std::size_t TileJob::lattice_index(int column, int row) const noexcept {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(m_lattice.columns) + static_cast<std::size_t>(column);
}

void TileJob::box_came(const voxel::BoxKey& key) {
    const auto found = m_parked.find(key);
    if (found == m_parked.end()) return;
    m_pending.insert(m_pending.end(), found->second.begin(), found->second.end());
    m_parked.erase(found);
}

bool TileJob::run(TracerTools& tools, const std::atomic<bool>& stop) {
    const std::uint64_t steps = tools.steps(), slabs = tools.slabs();
    const auto count = [&] {
        m_counts.steps += tools.steps() - steps, m_counts.slabs += tools.slabs() - slabs;
        m_holes.merge(tools.walk.take_holes());
        m_holes.merge(tools.surroundings.take_holes());
    };
    if (m_round < 0) begin(tools);
    while (true) {
        walk_pending(tools, stop);
        if (stop) return false;
        if (!m_parked.empty()) {
            count();
            return false;
        }
        shade_wave(tools);
        if (!m_wave.empty()) continue;
        end_round();
        if (++m_round == tools.view.scene.quality.samples) {
            end_part(tools.view);
            if (m_part_end == m_blocks.size()) {
                count();
                return true;
            }
            begin_part();
        }
        make_primary(tools);
    }
}

void TileJob::begin(TracerTools& tools) {
    m_place.assign(static_cast<std::size_t>(m_lattice.columns) * static_cast<std::size_t>(m_lattice.rows), -1);
    std::int32_t count = 0;
    m_tile.each_pixel([&](int x, int y) { m_place[lattice_index((x - m_lattice.first_x) / m_tile.step, (y - m_lattice.first_y) / m_tile.step)] = count++; });
    m_samples.resize(static_cast<std::size_t>(count));
    add_pixel_blocks(m_lattice, tools.view.camera, tools.beams, m_blocks);
    begin_part();
    make_primary(tools);
}

void TileJob::begin_part() {
    m_part_begin = m_part_end;
    m_part_end = std::min(m_part_begin + kPartBlocks, m_blocks.size());
    m_pixels.clear();
    for (std::size_t i = m_part_begin; i < m_part_end; ++i) {
        const PixelBlock& block = m_blocks[i];
        for (int row = block.row; row < block.row + block.rows; ++row)
            for (int column = block.column; column < block.column + block.columns; ++column) {
                const std::int32_t place = m_place[lattice_index(column, row)];
                if (place < 0) continue;
                Pixel pixel;
                pixel.x = m_lattice.first_x + column * m_tile.step, pixel.y = m_lattice.first_y + row * m_tile.step;
                pixel.place = static_cast<std::uint32_t>(place);
                pixel.block = &block;
                m_pixels.push_back(pixel);
            }
    }
    m_sums.resize(m_pixels.size());
    m_round = 0;
}

std::pair<double, double> TileJob::picture_point(const Pixel& pixel, int samples) const noexcept {
    const SamplePoint at(pixel.x, pixel.y, m_round, samples);
    return {pixel.x + at.u, pixel.y + at.v};
}

void TileJob::make_primary(TracerTools& tools) {
    for (SampleSum& sum : m_sums) sum = {};
    m_wave.assign(m_pixels.size(), {});
    const auto size = static_cast<std::uint32_t>(m_pixels.size());
    for (std::uint32_t first = 0, end = 0; first < size; first = end) {
        const PixelBlock& block = *m_pixels[first].block;
        for (end = first + 1; end < size && m_pixels[end].block == &block;) ++end;
        if (tools.packets && block.start.kind == BeamStart::Kind::kPlane) trace_primary_packet(tools, block, first, end - first);
        else
            for (std::uint32_t i = first; i < end; ++i) make_single(tools, i);
    }
    m_counts.rays[static_cast<std::size_t>(RayKind::kPrimary)] += m_wave.size();
}

void TileJob::make_single(TracerTools& tools, std::uint32_t index) {
    const Pixel& pixel = m_pixels[index];
    const auto [px, py] = picture_point(pixel, tools.view.scene.quality.samples);
    TracedRay& ray = m_wave[index] = tools.shading.primary(tools.view.camera.ray(px, py), index);
    if (pixel.block->start.kind != BeamStart::Kind::kMiss) {
        ray.state = RayState(ray.ray);
        if (pixel.block->start.place(ray.state, tools.view.cut)) {
            m_pending.push_back(index);
            return;
        }
    }
    ray.end = WalkEnd::kMiss;
    ++m_counts.spared;
}

void TileJob::trace_primary_packet(TracerTools& tools, const PixelBlock& block, std::uint32_t first, std::uint32_t count) {
    PrimaryLanes lanes = primary_lanes(tools.view.camera, block.start, tools.view.cut);
    for (std::uint32_t i = 0; i < RayPacket::kLanes; ++i) {
        const auto [px, py] = picture_point(m_pixels[first + (i < count ? i : 0)], tools.view.scene.quality.samples);
        lanes.px[i] = px, lanes.py[i] = py;
    }
    RayPacket packet;
    Hit hits[RayPacket::kLanes];
    const std::uint32_t placed = packet_steps()->primary(packet, lanes) & ((1u << count) - 1);
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((placed >> i & 1) == 0) make_single(tools, first + i);
        else m_wave[first + i] = tools.shading.primary({lanes.camera.position, {packet.direction[0][i], packet.direction[1][i], packet.direction[2][i]}}, first + i);
    }
    const PacketWalk::Ends ends = tools.packets->first_hits(packet, placed, hits);
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((placed >> i & 1) == 0) continue;
        TracedRay& ray = m_wave[first + i];
        if ((ends.missed >> i & 1) != 0) {
            ray.end = WalkEnd::kMiss;
            continue;
        }
        m_pending.push_back(first + i);
        if ((ends.hit >> i & 1) != 0) {
            ray.end = WalkEnd::kHit;
            ray.hit = hits[i];
        } else {
            ray.state = RayState(ray.ray);
            packet.update(static_cast<int>(i), ray.state);
        }
    }
}

void TileJob::walk_pending(TracerTools& tools, const std::atomic<bool>& stop) {
    for (const std::uint32_t index : m_pending) {
        if (stop.load(std::memory_order_relaxed)) return;
        voxel::BoxKey missing;
        if (walk_ray(tools, m_wave[index], missing)) continue;
        ++m_counts.parked;
        auto& waiting = m_parked[missing];
        if (waiting.empty()) m_missing.push_back(missing);
        waiting.push_back(index);
    }
    m_pending.clear();
}

// False: a box is missing.
bool TileJob::walk_ray(TracerTools& tools, TracedRay& ray, voxel::BoxKey& missing) {
    if (ray.end == WalkEnd::kWaits) {
        ray.end = ray.kind == RayKind::kShadow ? tools.walk.any_hit(ray.state, kFar, tools.occluder)
                                               : tools.walk.first_hit(ray.state, ray.kind == RayKind::kBed ? StopAt::kNotWater : StopAt::kSolid, kFar, ray.hit);
        if (ray.end == WalkEnd::kWaits) {
            missing = tools.walk.missing();
            return false;
        }
    }
    if (!tools.shading.needs_surroundings(ray) || tools.surroundings.around(ray.hit, ray.around)) return true;
    missing = tools.surroundings.missing();
    return false;
}

void TileJob::shade_wave(TracerTools& tools) {
    m_next.clear();
    for (const TracedRay& ray : m_wave) {
        if (ray.end == WalkEnd::kHit && ray.kind != RayKind::kShadow && ray.hit.hole) ++m_counts.hole_rays;
        tools.shading.shade(ray, m_sums[ray.sample], m_next);
    }
    m_wave.swap(m_next);
    for (std::uint32_t i = 0; i < m_wave.size(); ++i) ++m_counts.rays[static_cast<std::size_t>(m_wave[i].kind)];
    trace_shadow_groups(tools);
    for (std::uint32_t i = 0; i < m_wave.size(); ++i)
        if (m_wave[i].end == WalkEnd::kWaits) m_pending.push_back(i);
}

// Shadow rays that follow each other in a wave come from neighbouring pixels.
void TileJob::trace_shadow_groups(TracerTools& tools) {
    ShadowGroups groups(tools.shafts, tools.packets ? &*tools.packets : nullptr, tools.view.sky.to_sun());
    m_shadows.clear();
    for (TracedRay& ray : m_wave)
        if (ray.kind == RayKind::kShadow) m_shadows.push_back({ray.ray.origin, &ray.state, &ray.end});
    for (std::size_t first = 0; first < m_shadows.size(); first += ShadowGroups::kMost)
        m_counts.spared += groups.trace(std::span(m_shadows).subspan(first, std::min(ShadowGroups::kMost, m_shadows.size() - first)));
}

void TileJob::end_round() {
    for (std::size_t i = 0; i < m_pixels.size(); ++i) {
        Pixel& pixel = m_pixels[i];
        const SampleSum& sum = m_sums[i];
        pixel.r += sum.colour.r, pixel.g += sum.colour.g, pixel.b += sum.colour.b;
        if (sum.t < kFar) pixel.t += sum.t, ++pixel.hits;
    }
}

void TileJob::end_part(const View& view) {
    const double n = view.scene.quality.samples;
    for (const Pixel& p : m_pixels)
        m_samples[p.place] = {{static_cast<float>(p.r / n), static_cast<float>(p.g / n), static_cast<float>(p.b / n)},
                              static_cast<float>(p.hits / n),
                              p.hits > 0 ? static_cast<float>(p.t / p.hits * view.voxel_m) : std::numeric_limits<float>::infinity()};
}

TileResult TileJob::take_result() { return {m_tile, std::move(m_samples), {}, m_counts, std::move(m_holes)}; }

}  // namespace terravox
