#include "raytracer/trace/tile_job.hpp"

#include <algorithm>
#include <numeric>

namespace terravox::trace {
namespace {

constexpr std::size_t kBlockPixels = std::size_t{kPixelBlockSide} * kPixelBlockSide;
enum PictureUse : std::uint32_t { kPixelPoint = 0xffff0000, kLensPoint };

// A wave of many rays for each pixel must not take more memory than one of few.
std::size_t part_blocks(const shade::View& view, std::size_t wave_rays) noexcept {
    const auto& q = view.scene.quality;
    const std::size_t rays = q.integrator == core::Integrator::kDirect && q.ambient_occlusion
                                 ? 1 + static_cast<std::size_t>(q.ao_rays) / 2
                                 : 1;
    return std::max<std::size_t>(wave_rays / kBlockPixels / rays, 1);
}

}  // namespace

void TileJob::start(const tiles::RenderTile& tile, std::size_t wave_rays) {
    m_tile = tile;
    m_wave_rays = wave_rays;
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
    const auto count = [&](int begin, int end) {
        return std::max((end - begin + tile.step - 1) / tile.step, 0);
    };
    m_lattice = {first(tile.x0), first(tile.y0), tile.step, count(first(tile.x0), tile.x1),
                 count(first(tile.y0), tile.y1)};
}

std::size_t TileJob::lattice_index(int column, int row) const noexcept {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(m_lattice.columns) +
           static_cast<std::size_t>(column);
}

void TileJob::box_came(const voxel::BoxKey& key) {
    const auto found = m_parked.find(key);
    if (found == m_parked.end())
        return;
    m_pending.insert(m_pending.end(), found->second.begin(), found->second.end());
    m_parked.erase(found);
}

bool TileJob::run(TracerTools& tools, const StopCondition& stop_condition) {
    const std::uint64_t steps = tools.steps(), slabs = tools.slabs();
    m_lap = std::chrono::steady_clock::now();
    const bool finished = go_on(tools, stop_condition);
    m_counts.steps += tools.steps() - steps;
    m_counts.slabs += tools.slabs() - slabs;
    m_holes.merge(tools.walk.take_holes());
    m_holes.merge(tools.surroundings.take_holes());
    return finished;
}

bool TileJob::go_on(TracerTools& tools, const StopCondition& stop_condition) {
    if (m_round < 0) {
        begin(tools);
        if (stop_condition.asked())
            return false;
    }
    while (true) {
        const bool walked = walk_pending(tools, stop_condition);
        lap(tiles::TraceStage::kSingle);
        if (!walked || !m_parked.empty())
            return false;
        shade_wave(tools);
        if (m_wave.empty()) {
            const bool part_done = !end_round(tools.view);
            if (part_done)
                end_part(tools.view);
            lap(tiles::TraceStage::kPixels);
            if (part_done && m_part_end == m_blocks.size())
                return true;
            if (part_done)
                begin_part(tools.view);
            make_primary(tools);
            lap(tiles::TraceStage::kPrimary);
        }
        if (stop_condition.asked())
            return false;
    }
}

void TileJob::lap(tiles::TraceStage stage) {
    const auto now = std::chrono::steady_clock::now();
    m_counts.seconds[static_cast<std::size_t>(stage)] +=
        std::chrono::duration<double>(now - m_lap).count();
    m_lap = now;
}

void TileJob::begin(TracerTools& tools) {
    m_place.assign(
        static_cast<std::size_t>(m_lattice.columns) * static_cast<std::size_t>(m_lattice.rows), -1);
    std::int32_t count = 0;
    m_tile.each_pixel([&](int x, int y) {
        m_place[lattice_index((x - m_lattice.first_x) / m_tile.step,
                              (y - m_lattice.first_y) / m_tile.step)] = count++;
    });
    m_samples.resize(static_cast<std::size_t>(count));
    m_layers.resize(tools.view.wants_layers() ? m_samples.size() : 0);
    add_pixel_blocks(m_lattice, tools.view.camera, tools.beams, m_blocks);
    lap(tiles::TraceStage::kBeams);
    begin_part(tools.view);
    make_primary(tools);
    lap(tiles::TraceStage::kPrimary);
}

void TileJob::begin_part(const shade::View& view) {
    m_part_begin = m_part_end;
    m_part_end = std::min(m_part_begin + part_blocks(view, m_wave_rays), m_blocks.size());
    m_pixels.clear();
    for (std::size_t i = m_part_begin; i < m_part_end; ++i) {
        const PixelBlock& block = m_blocks[i];
        for (int row = block.row; row < block.row + block.rows; ++row)
            for (int column = block.column; column < block.column + block.columns; ++column) {
                const std::int32_t place = m_place[lattice_index(column, row)];
                if (place < 0)
                    continue;
                Pixel pixel;
                pixel.x = m_lattice.first_x + column * m_tile.step;
                pixel.y = m_lattice.first_y + row * m_tile.step;
                pixel.place = static_cast<std::uint32_t>(place);
                pixel.block = &block;
                m_pixels.push_back(pixel);
            }
    }
    m_pixel_sums.assign(m_pixels.size(), {});
    m_layer_sums.assign(m_layers.empty() ? 0 : m_pixels.size(), {});
    m_active.resize(m_pixels.size());
    std::iota(m_active.begin(), m_active.end(), 0u);
    m_round = 0;
}

std::pair<double, double> TileJob::picture_point(const shade::View& view,
                                                 std::uint32_t place) const noexcept {
    const Pixel& pixel = m_pixels[m_active[place]];
    if (view.scene.quality.samples == 1)
        return {pixel.x + 0.5, pixel.y + 0.5};
    const shade::Sampler::Pair at = m_sums[place].numbers.pair(kPixelPoint);
    return {pixel.x + at.u, pixel.y + at.v};
}

void TileJob::make_primary(TracerTools& tools) {
    m_sums.assign(m_active.size(), {});
    m_wave.assign(m_active.size(), {});
    const auto size = static_cast<std::uint32_t>(m_active.size());
    for (std::uint32_t i = 0; i < size; ++i) {
        const Pixel& pixel = m_pixels[m_active[i]];
        m_sums[i].numbers = shade::Sampler(
            pixel.x, pixel.y, m_tile.first_sample + static_cast<std::uint32_t>(m_round),
            tools.view.scene.quality.seed);
    }
    for (std::uint32_t first = 0, end = 0; first < size; first = end) {
        const PixelBlock& block = *m_pixels[m_active[first]].block;
        for (end = first + 1; end < size && m_pixels[m_active[end]].block == &block;)
            ++end;
        if (tools.packets && block.start.kind == walk::BeamStart::Kind::kPlane)
            trace_primary_packet(tools, block, first, end - first);
        else
            for (std::uint32_t i = first; i < end; ++i)
                make_single(tools, i);
    }
    m_counts.rays[static_cast<std::size_t>(walk::RayKind::kPrimary)] += m_wave.size();
}

void TileJob::make_single(TracerTools& tools, std::uint32_t place) {
    const walk::BeamStart& start = m_pixels[m_active[place]].block->start;
    const auto [px, py] = picture_point(tools.view, place);
    const shade::Sampler::Pair lens = tools.view.camera.has_lens()
                                          ? m_sums[place].numbers.pair(kLensPoint)
                                          : shade::Sampler::Pair{0.5, 0.5};
    const std::optional<core::Ray> sent = tools.view.camera.ray(px, py, lens.u, lens.v);
    walk::TracedRay& ray = m_wave[place] =
        tools.shading->primary(sent ? *sent : tools.view.camera.ray(px, py), place);
    if (!sent) {
        // Nothing is seen there: black, and no share of anything.
        ray.end = walk::WalkEnd::kMiss;
        ray.weight = {};
        return;
    }
    if (start.kind != walk::BeamStart::Kind::kMiss) {
        ray.state = core::RayState(ray.ray);
        if (start.place(ray.state, tools.view.cut)) {
            m_pending.push_back(place);
            return;
        }
    }
    ray.end = walk::WalkEnd::kMiss;
    ++m_counts.spared;
}

void TileJob::trace_primary_packet(TracerTools& tools, const PixelBlock& block, std::uint32_t first,
                                   std::uint32_t count) {
    walk::PrimaryLanes lanes = walk::primary_lanes(tools.view.camera, block.start, tools.view.cut);
    for (std::uint32_t i = 0; i < walk::RayPacket::kLanes; ++i) {
        const auto [px, py] = picture_point(tools.view, first + (i < count ? i : 0));
        lanes.px[i] = px;
        lanes.py[i] = py;
    }
    walk::RayPacket packet;
    walk::Hit hits[walk::RayPacket::kLanes];
    const std::uint32_t placed = walk::packet_steps()->primary(packet, lanes) & ((1u << count) - 1);
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((placed >> i & 1) == 0)
            make_single(tools, first + i);
        else
            m_wave[first + i] = tools.shading->primary(
                {lanes.camera.position,
                 {packet.direction[0][i], packet.direction[1][i], packet.direction[2][i]}},
                first + i);
    }
    const walk::PacketWalk::Ends ends = tools.packets->first_hits(packet, placed, hits);
    for (std::uint32_t i = 0; i < count; ++i) {
        if ((placed >> i & 1) == 0)
            continue;
        walk::TracedRay& ray = m_wave[first + i];
        if ((ends.missed >> i & 1) != 0) {
            ray.end = walk::WalkEnd::kMiss;
            continue;
        }
        m_pending.push_back(first + i);
        if ((ends.hit >> i & 1) != 0) {
            ray.end = walk::WalkEnd::kHit;
            ray.hit = hits[i];
        } else {
            ray.state = core::RayState(ray.ray);
            packet.update(static_cast<int>(i), ray.state);
        }
    }
}

// False: it was asked to leave off; what is left is pending.
bool TileJob::walk_pending(TracerTools& tools, const StopCondition& stop_condition) {
    std::size_t done = 0;
    while (done < m_pending.size()) {
        const std::uint32_t index = m_pending[done++];
        if (voxel::BoxKey missing; !walk_ray(tools, m_wave[index], missing)) {
            ++m_counts.parked;
            auto& waiting = m_parked[missing];
            if (waiting.empty())
                m_missing.push_back(missing);
            waiting.push_back(index);
        }
        if (stop_condition.asked())
            break;
    }
    m_pending.erase(m_pending.begin(), m_pending.begin() + static_cast<std::ptrdiff_t>(done));
    return m_pending.empty();
}

// False: a box is missing.
bool TileJob::walk_ray(TracerTools& tools, walk::TracedRay& ray, voxel::BoxKey& missing) {
    if (ray.end == walk::WalkEnd::kWaits) {
        ray.end = ray.only_blocked()
                      ? tools.walk.any_hit(ray.state, ray.t_max, tools.occluder)
                      : tools.walk.first_hit(ray.state, ray.stop, ray.t_max, ray.hit);
        if (ray.end == walk::WalkEnd::kWaits) {
            missing = tools.walk.missing();
            return false;
        }
        if (ray.only_blocked())
            ray.hit.hole = ray.end == walk::WalkEnd::kHit && tools.occluder.hole;
    }
    if (!tools.shading->needs_surroundings(ray) || tools.surroundings.around(ray.hit, ray.around))
        return true;
    missing = tools.surroundings.missing();
    return false;
}

void TileJob::shade_wave(TracerTools& tools) {
    m_next.clear();
    for (const walk::TracedRay& ray : m_wave) {
        if (ray.end == walk::WalkEnd::kHit && ray.hit.hole)
            ++m_counts.hole_rays;
        tools.shading->shade(ray, m_sums[ray.sample], m_next);
    }
    m_wave.swap(m_next);
    for (std::uint32_t i = 0; i < m_wave.size(); ++i)
        ++m_counts.rays[static_cast<std::size_t>(m_wave[i].kind)];
    lap(tiles::TraceStage::kShading);
    trace_shadow_groups(tools);
    lap(tiles::TraceStage::kSun);
    trace_scattered(tools);
    lap(tiles::TraceStage::kScattered);
    for (std::uint32_t i = 0; i < m_wave.size(); ++i)
        if (m_wave[i].end == walk::WalkEnd::kWaits || tools.shading->needs_surroundings(m_wave[i]))
            m_pending.push_back(i);
}

// Shadow rays that follow each other in a wave come from neighbouring pixels.
void TileJob::trace_shadow_groups(TracerTools& tools) {
    ShadowGroups groups(tools.shafts, tools.packets ? &*tools.packets : nullptr,
                        tools.view.sky.to_sun(), tools.view.sky.sun_radius_rad());
    m_shadows.clear();
    for (walk::TracedRay& ray : m_wave)
        if (ray.kind == walk::RayKind::kShadow && ray.stop == walk::StopAt::kSolid &&
            ray.state.t == 0)
            m_shadows.push_back({ray.ray.origin, &ray.state, &ray.end});
    for (std::size_t first = 0; first < m_shadows.size(); first += ShadowGroups::kMax)
        m_counts.spared += groups.trace(std::span(m_shadows).subspan(
            first, std::min(ShadowGroups::kMax, m_shadows.size() - first)));
    // Where it counts what stops a ray, it goes once more, alone.
    for (walk::TracedRay& ray : m_wave)
        if (ray.leaves && ray.end == walk::WalkEnd::kHit)
            ray.end = walk::WalkEnd::kWaits;
}

// What matt faces send out, mirrors, and shadow rays among leaves.
void TileJob::trace_scattered(TracerTools& tools) {
    if (!tools.lanes)
        return;
    m_scattered.clear();
    for (walk::TracedRay& ray : m_wave)
        if (ray.end == walk::WalkEnd::kWaits && ray.stop == walk::StopAt::kSolid)
            m_scattered.push_back(
                {&ray.state, &ray.end, ray.t_max, ray.only_blocked() ? nullptr : &ray.hit});
    tools.lanes->trace(m_scattered);
}

// False: no pixel of the part needs more.
bool TileJob::end_round(const shade::View& view) {
    for (std::size_t i = 0; i < m_active.size(); ++i) {
        m_pixel_sums[m_active[i]].add(m_sums[i]);
        if (!m_layer_sums.empty())
            m_layer_sums[m_active[i]].add(m_sums[i], view);
    }
    ++m_round;
    const auto& q = view.scene.quality;
    constexpr int kAskEvery = 4;
    if (q.noise > 0 && m_round >= q.min_samples && m_round % kAskEvery == 0)
        std::erase_if(m_active, [&](std::uint32_t i) {
            return m_pixel_sums[i].mean(view.voxel_m).is_known(q.noise);
        });
    const int wanted = m_tile.samples > 0 ? static_cast<int>(m_tile.samples) : q.samples;
    return m_round < wanted && !m_active.empty();
}

void TileJob::end_part(const shade::View& view) {
    for (std::size_t i = 0; i < m_pixels.size(); ++i)
        m_samples[m_pixels[i].place] = m_pixel_sums[i].mean(view.voxel_m);
    for (std::size_t i = 0; i < m_layer_sums.size(); ++i)
        m_layers[m_pixels[i].place] = m_layer_sums[i].mean();
}

tiles::TileResult TileJob::take_result() {
    return {m_tile, std::move(m_samples), std::move(m_layers), m_counts, std::move(m_holes)};
}

}  // namespace terravox::trace
