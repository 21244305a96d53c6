#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/thread/stop_condition.hpp"
#include "raytracer/shade/cached_shading.hpp"
#include "raytracer/trace/ray_wave.hpp"
#include "raytracer/trace/stage_clock.hpp"

namespace terravox::trace {

/// Finds the kept light that a walked wave needs before it is shaded, and gathers what the cache
/// lacks. Missing cells are taken a few at a time. Rays gather what surrounds a face that a camera
/// sees; they end on whole faces, whose light is kept, too, and gathered by fewer rays: these go on
/// as paths. Both steps are waves of rays, which may wait for boxes. Used by one thread at a time.
class FinalGather {
public:
    /// Forgets everything in progress.
    void clear();
    /// Sets the kept light of those rays whose cells are in the cache, and becomes active if there
    /// are others.
    /// @param rays, samples of a walked wave; unchanged by others until active() is false
    void start(TracerTools& tools, std::span<walk::TracedRay> rays,
               std::span<const shade::SampleSum> samples);
    [[nodiscard]] bool active() const noexcept { return m_next_wanted < m_wanted.size(); }
    /// Continues as far as the boxes in memory allow, or until `stop` requests an end.
    /// @return whether all rays have their light; active() is false then
    [[nodiscard]] bool run(TracerTools& tools, const thread::StopCondition& stop, StageClock& clock,
                           tiles::TraceCounts& counts);
    /// The wave of gather rays.
    [[nodiscard]] RayWave& wave() noexcept { return m_wave; }
    [[nodiscard]] const RayWave& wave() const noexcept { return m_wave; }

    /// Numbers of rays by which a light is gathered.
    struct RayNumbers {
        std::uint32_t gather = 1;
        std::uint32_t sun = 0;  ///< towards the sun
    };

private:
    /// A light of the chunk.
    struct Entry {
        shade::FaceCell key;           ///< FaceCell::light()
        shade::FaceLight light;        ///< of a seen face, without what its links bring
        std::uint32_t first_link = 0;  ///< in m_links; of seen faces
        std::uint32_t link_count = 0;
        bool hole = false;  ///< depends on a box that is not available
    };
    /// A gather ray's end: an entry, and the share of its light that arrives.
    struct Link {
        std::uint32_t entry = 0;
        voxel::Colour weight;
    };

    void begin_chunk(shade::IrradianceCache& cache);
    /// The entry of a light; one that is not in the cache is requested.
    std::uint32_t entry_of(shade::IrradianceCache& cache, const shade::FaceCell& key);
    void sort_requests();
    void begin_wave(TracerTools& tools);
    void add_rays(const shade::CachedShading& shading, const shade::FaceCell& key,
                  RayNumbers count);
    void end_wave(TracerTools& tools);
    void end_chunk(shade::IrradianceCache& cache);

    std::span<walk::TracedRay> m_rays;  ///< of the caller's wave
    std::vector<shade::FaceCell> m_wanted;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> m_users;  ///< ray, index in m_wanted
    std::unordered_map<shade::FaceCell, std::uint32_t, shade::FaceCellHash> m_wanted_index;
    std::size_t m_next_wanted = 0;  ///< first of the chunk
    std::size_t m_chunk_end = 0;
    std::vector<shade::FaceLight> m_lights;  ///< of m_wanted

    bool m_begun = false;  ///< the chunk
    std::vector<Entry> m_entries;
    std::unordered_map<shade::FaceCell, std::uint32_t, shade::FaceCellHash> m_entry_index;
    std::vector<Link> m_links;
    /// Entries to be gathered: seen ones, then those that these end on. Those of one column of
    /// boxes are next to each other.
    std::vector<std::uint32_t> m_requests;
    std::size_t m_next_request = 0;
    std::size_t m_wave_end = 0;  ///< in m_requests
    walk::LevelCut m_cut{voxel::VoxelBounds{}, 0};
    RayWave m_wave;
    std::vector<shade::SampleSum> m_samples;
    std::vector<shade::GatherHit> m_hits;
};

}  // namespace terravox::trace
