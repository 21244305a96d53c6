#pragma once

#include <optional>

#include "raytracer/shade/path_shading.hpp"

namespace terravox::shade {

/// Path tracing whose paths end on the first matt face in air that covers a pixel or more: the
/// light of sky and bounces there is the kept irradiance of the face (IrradianceCache), only its
/// sunlight is sampled for each sample. Smaller faces, leaves with holes, water, glass and mirrors
/// go on by paths. The caller looks cells up, has missing ones gathered, and sets
/// TracedRay::has_kept before shade(). In a gather wave (SampleSum::gathered) a ray that ends on a
/// cell only reports it.
class CachedShading final : public PathShading {
public:
    /// @param cut that rays are walked by; must outlive this
    CachedShading(const View& view, const walk::LevelCut& cut) noexcept
        : PathShading(view), m_cut(cut) {}

    /// The key of the light that a ray's end needs; nullopt: the path goes on.
    [[nodiscard]] std::optional<FaceCell> kept_light_of(const walk::TracedRay& ray,
                                                        const Sampler& numbers) const noexcept;
    /// The ray number `index` of those that gather the light of a cell.
    /// @param key FaceCell::light()
    /// @param sample TracedRay::sample
    [[nodiscard]] walk::TracedRay gather_ray(const FaceCell& key, std::uint32_t index,
                                             std::uint32_t sample) const noexcept;
    /// A ray from a point of the cell towards the sun, which brings `share` of the sun's light.
    /// @return nullopt: the face looks away from the sun
    [[nodiscard]] std::optional<walk::TracedRay> sun_ray(const FaceCell& key, std::uint32_t index,
                                                         std::uint32_t sample,
                                                         float share) const noexcept;
    /// The random numbers of a cell's ray.
    [[nodiscard]] Sampler numbers_of(const FaceCell& cell, std::uint32_t index) const noexcept;

private:
    void shade_opaque(const Interaction& m) const override;
    [[nodiscard]] FaceCell face_of(const walk::TracedRay& ray) const noexcept;
    /// How many bounces the light may have had that a path takes from the ray's end.
    [[nodiscard]] int bounces_at(const walk::TracedRay& ray) const noexcept;
    /// Whether a matt face's light may be kept: the walk that gathers it sees the same face.
    [[nodiscard]] bool is_kept(const walk::TracedRay& ray) const noexcept;
    [[nodiscard]] walk::TracedRay from_cell(const FaceCell& cell, core::Vec3 point,
                                            core::Vec3 direction) const noexcept;

    const walk::LevelCut& m_cut;
};

}  // namespace terravox::shade
