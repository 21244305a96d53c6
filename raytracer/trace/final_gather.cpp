#include "raytracer/trace/final_gather.hpp"

#include <algorithm>
#include <tuple>

#include "common/util/det_math.hpp"

namespace terravox::trace {
namespace {

constexpr std::size_t kChunkCells = 256;
constexpr std::size_t kWaveRays = 4096;
/// A gather ray meets voxels of twice the size at this distance, in voxels of its cell's level.
constexpr double kCoarserFrom = 128;

// A face that gather rays end on has a small share in what is seen, so fewer rays do. The sun of a
// seen face is sampled for each pixel.
FinalGather::RayNumbers rays_of(const shade::FaceCell& key, const shade::View& view) noexcept {
    const auto seen = static_cast<std::uint32_t>(view.scene.quality.gather_rays);
    if (key.seen())
        return {seen, 0};
    const std::uint32_t gather = std::max(seen / 2, 1U);
    return {gather, view.sky.sun_up() ? std::max(gather / 2, 1U) : 0};
}

const shade::CachedShading& shading_of(const TracerTools& tools) noexcept {
    return static_cast<const shade::CachedShading&>(*tools.shading);
}

std::tuple<int, std::int32_t, std::int32_t> column_of(const shade::FaceCell& cell) noexcept {
    return {cell.level(), cell.voxel.x >> walk::LevelCut::kSideBits,
            cell.voxel.z >> walk::LevelCut::kSideBits};
}

/// The cut that gather rays of a column's cells are walked by. It does not depend on the camera:
/// the finest level is that of the cells.
walk::LevelCut cut_of(const shade::FaceCell& cell, const walk::LevelCut& of_view) {
    const auto [level, bx, bz] = column_of(cell);
    const double side = det::exp2_int(level + walk::LevelCut::kSideBits);
    const voxel::VoxelBounds& bounds = of_view.bounds();
    const core::Vec3 eye = {(bx + 0.5) * side, static_cast<double>(bounds.min[1]),
                            (bz + 0.5) * side};
    return {bounds, eye, 2 / kCoarserFrom, 1, level, std::max(level, of_view.coarsest())};
}

}  // namespace

void FinalGather::clear() {
    m_wanted.clear();
    m_next_wanted = 0;
    m_begun = false;
    m_wave.clear();
    m_requests.clear();
    m_next_request = 0;
    m_wave_end = 0;
}

void FinalGather::start(TracerTools& tools, std::span<walk::TracedRay> rays,
                        std::span<const shade::SampleSum> samples) {
    clear();
    m_rays = rays;
    m_users.clear();
    m_wanted_index.clear();
    const shade::CachedShading& shading = shading_of(tools);
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        walk::TracedRay& ray = rays[i];
        const auto key = shading.kept_light_of(ray, samples[ray.sample].numbers);
        if (!key)
            continue;
        shade::FaceLight light;
        if (tools.view.kept_light->find(*key, light)) {
            ray.kept_direct = light.direct;
            ray.kept_indirect = light.indirect;
            ray.has_kept = true;
            continue;
        }
        const auto [at, added] =
            m_wanted_index.try_emplace(*key, static_cast<std::uint32_t>(m_wanted.size()));
        if (added)
            m_wanted.push_back(*key);
        m_users.emplace_back(i, at->second);
    }
    m_lights.assign(m_wanted.size(), {});
}

bool FinalGather::run(TracerTools& tools, const thread::StopCondition& stop, StageClock& clock,
                      tiles::TraceCounts& counts) {
    shade::IrradianceCache& cache = *tools.view.kept_light;
    *tools.gather_cut = m_cut;  // another thread may have begun the wave
    while (active()) {
        if (!m_begun)
            begin_chunk(cache);
        while (m_next_request < m_requests.size()) {
            if (m_wave_end == m_next_request) {
                begin_wave(tools);
                m_wave.start_groups(*tools.gather, clock, counts);
            }
            while (!m_wave.empty()) {
                const bool walked = m_wave.walk(*tools.gather, stop, counts);
                clock.lap(tiles::TraceStage::kSingle, counts);
                if (!walked)
                    return false;
                m_wave.shade(*tools.gather, m_samples, clock, counts);
                if (stop.is_met() && !m_wave.empty())
                    return false;
            }
            end_wave(tools);
        }
        end_chunk(cache);
        clock.lap(tiles::TraceStage::kShading, counts);
    }
    for (const auto& [ray, wanted] : m_users) {
        m_rays[ray].kept_direct = m_lights[wanted].direct;
        m_rays[ray].kept_indirect = m_lights[wanted].indirect;
        m_rays[ray].has_kept = true;
    }
    return true;
}

void FinalGather::begin_chunk(shade::IrradianceCache& cache) {
    m_begun = true;
    m_entries.clear();
    m_entry_index.clear();
    m_links.clear();
    m_requests.clear();
    m_next_request = 0;
    m_wave_end = 0;
    m_chunk_end = std::min(m_next_wanted + kChunkCells, m_wanted.size());
    for (std::size_t i = m_next_wanted; i < m_chunk_end; ++i)
        (void)entry_of(cache, m_wanted[i]);
    sort_requests();
}

std::uint32_t FinalGather::entry_of(shade::IrradianceCache& cache, const shade::FaceCell& key) {
    const auto [at, added] =
        m_entry_index.try_emplace(key, static_cast<std::uint32_t>(m_entries.size()));
    if (!added)
        return at->second;
    Entry& entry = m_entries.emplace_back();
    entry.key = key;
    if (!cache.find(key, entry.light))
        m_requests.push_back(at->second);
    return at->second;
}

// Of those not begun: seen faces first, whose waves request others.
void FinalGather::sort_requests() {
    const auto order = [this](std::uint32_t i) {
        return std::pair(!m_entries[i].key.seen(), column_of(m_entries[i].key));
    };
    std::stable_sort(m_requests.begin() + static_cast<std::ptrdiff_t>(m_next_request),
                     m_requests.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return order(a) < order(b); });
}

void FinalGather::begin_wave(TracerTools& tools) {
    const shade::CachedShading& shading = shading_of(*tools.gather);
    const shade::FaceCell& first = m_entries[m_requests[m_next_request]].key;
    m_cut = cut_of(first, tools.view.cut);
    *tools.gather_cut = m_cut;
    (void)m_wave.begin(0);
    m_samples.clear();
    m_hits.clear();
    for (; m_wave_end < m_requests.size() && m_wave.rays().size() < kWaveRays; ++m_wave_end) {
        const shade::FaceCell& key = m_entries[m_requests[m_wave_end]].key;
        if (key.seen() != first.seen() || column_of(key) != column_of(first))
            break;
        add_rays(shading, key, rays_of(key, tools.view));
    }
}

void FinalGather::add_rays(const shade::CachedShading& shading, const shade::FaceCell& key,
                           RayNumbers count) {
    const auto sample = static_cast<std::uint32_t>(m_samples.size());
    shade::SampleSum& sum = m_samples.emplace_back();
    sum.numbers = shading.numbers_of(key.cell(), 0);
    sum.gathered = key.seen() ? &m_hits : nullptr;
    for (std::uint32_t k = 0; k < count.gather; ++k)
        m_wave.add(shading.gather_ray(key, k, sample));
    const float share =
        static_cast<float>(count.gather) / static_cast<float>(std::max(count.sun, 1U));
    for (std::uint32_t k = 0; k < count.sun; ++k)
        if (const auto ray = shading.sun_ray(key, k, sample, share))
            m_wave.add(*ray);
}

void FinalGather::end_wave(TracerTools& tools) {
    shade::IrradianceCache& cache = *tools.view.kept_light;
    std::stable_sort(m_hits.begin(), m_hits.end(),
                     [](const auto& a, const auto& b) { return a.sample < b.sample; });
    std::size_t hit = 0;
    for (std::uint32_t sample = 0; m_next_request < m_wave_end; ++sample, ++m_next_request) {
        const std::uint32_t index = m_requests[m_next_request];
        const shade::FaceCell key = m_entries[index].key;
        const shade::SampleSum& sum = m_samples[sample];
        const float share = 1 / static_cast<float>(rays_of(key, tools.view).gather);
        const auto first_link = static_cast<std::uint32_t>(m_links.size());
        for (; hit < m_hits.size() && m_hits[hit].sample == sample; ++hit)
            m_links.push_back(
                {entry_of(cache, m_hits[hit].link.key), m_hits[hit].link.weight * share});
        Entry& entry = m_entries[index];
        entry.light = {sum.direct * share, sum.indirect * share};
        entry.hole = sum.hole;
        entry.first_link = first_link;
        entry.link_count = static_cast<std::uint32_t>(m_links.size()) - first_link;
        if (!key.seen() && !entry.hole)
            cache.insert(key, entry.light);
    }
    sort_requests();
}

void FinalGather::end_chunk(shade::IrradianceCache& cache) {
    for (std::size_t i = m_next_wanted; i < m_chunk_end; ++i) {
        Entry& entry = m_entries[m_entry_index.at(m_wanted[i])];
        for (std::uint32_t l = 0; l < entry.link_count; ++l) {
            const Link& link = m_links[entry.first_link + l];
            const Entry& from = m_entries[link.entry];
            entry.light.indirect =
                entry.light.indirect + link.weight * (from.light.direct + from.light.indirect);
            entry.hole = entry.hole || from.hole;
        }
        if (entry.key.seen() && !entry.hole)
            cache.insert(entry.key, entry.light);
        m_lights[i] = entry.light;
    }
    m_next_wanted = m_chunk_end;
    m_begun = false;
}

}  // namespace terravox::trace
