#include "raytracer/trace/tile_job.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/shade/random.hpp"

namespace terravox {
namespace {

constexpr std::uint32_t kShaftRays = 16;
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

TileJob::TileJob(const RenderTile& tile) : m_tile(tile) {
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
    const std::uint64_t steps = tools.walk.counts().steps, slabs = tools.beams.slabs() + tools.shafts.slabs();
    const auto count = [&] {
        m_counts.steps += tools.walk.counts().steps - steps;
        m_counts.slabs += tools.beams.slabs() + tools.shafts.slabs() - slabs;
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
                pixel.start = &block.start;
                m_pixels.push_back(pixel);
            }
    }
    m_sums.resize(m_pixels.size());
    m_round = 0;
}

void TileJob::make_primary(TracerTools& tools) {
    const int samples = tools.view.scene.quality.samples;
    for (SampleSum& sum : m_sums) sum = {};
    m_wave.clear();
    for (std::uint32_t i = 0; i < m_pixels.size(); ++i) {
        const Pixel& pixel = m_pixels[i];
        const SamplePoint at(pixel.x, pixel.y, m_round, samples);
        TracedRay& ray = m_wave.emplace_back(tools.shading.primary(pixel.x + at.u, pixel.y + at.v, i));
        if (pixel.start->place(ray.state, tools.view.cut)) {
            m_pending.push_back(i);
        } else {
            ray.end = WalkEnd::kMiss;
            ++m_counts.spared;
        }
    }
    m_counts.rays[static_cast<std::size_t>(RayKind::kPrimary)] += m_wave.size();
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
    spare_free_shadows(tools);
    for (std::uint32_t i = 0; i < m_wave.size(); ++i)
        if (m_wave[i].end == WalkEnd::kWaits) m_pending.push_back(i);
}

// Shadow rays that follow each other in a wave come from neighbouring pixels: where nothing stands between such a group and the sun,
// none of them needs to be walked.
void TileJob::spare_free_shadows(TracerTools& tools) {
    std::uint32_t group[kShaftRays];
    for (std::uint32_t next = 0; next < m_wave.size();) {
        std::uint32_t size = 0;
        Shaft shaft(tools.view.sky.to_sun());
        for (; next < m_wave.size() && size < kShaftRays; ++next) {
            if (m_wave[next].kind != RayKind::kShadow) continue;
            group[size++] = next;
            shaft.add(m_wave[next].ray.origin, m_wave[next].state);
        }
        if (size < 2) continue;
        const std::int32_t free_from = tools.shafts.free_from(shaft);
        for (std::uint32_t i = 0; i < size; ++i) {
            TracedRay& ray = m_wave[group[i]];
            if (!ShaftMarch::is_free(shaft, ray.state, free_from)) continue;
            ray.end = WalkEnd::kMiss;
            ++m_counts.spared;
        }
    }
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

TileResult TileJob::take_result() { return {m_tile, std::move(m_samples), m_counts}; }

}  // namespace terravox
