#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "raytracer/core/base/analysis_bands.hpp"
#include "raytracer/core/shade/sampler.hpp"
#include "raytracer/core/shade/surface.hpp"

namespace terravox::shade {

/// What has been summed up for one sample of a pixel.
struct SampleSum {
    Sampler numbers;                 ///< generator of the sample's random numbers
    voxel::Colour direct, indirect;  ///< linear light; their sum is the sample's colour
    /// Distance of the first hit, in level-0 voxels; infinity: none.
    double t = std::numeric_limits<double>::infinity();
    core::Vec3 point, normal;  ///< position and smooth normal of the first hit
    voxel::Colour albedo;
    float sun = 0;  ///< share of the first hit's sunlight that is not in shadow
    voxel::Material material = voxel::Material::kAir;
    bool water = false;
    core::Bands bands{};  ///< of an analysis
};

/// Evaluates the end of a ray: light, or measured values, for its sample, and further rays that
/// must be traced. It walks no rays itself, so that rays may wait. Immutable; a pure function of
/// its arguments: random numbers are those of the sample and of the ray's stream.
class RayEvaluator {
public:
    RayEvaluator() = default;
    RayEvaluator(const RayEvaluator&) = delete;
    RayEvaluator& operator=(const RayEvaluator&) = delete;
    virtual ~RayEvaluator() = default;

    /// How many pixels are begun together, so that what they send takes no more memory than a wave
    /// of `rays` rays.
    [[nodiscard]] virtual std::size_t wave_pixels(std::size_t rays) const noexcept { return rays; }
    /// The primary ray for a ray of the camera. The caller sets its state.
    [[nodiscard]] virtual walk::TracedRay primary(const core::Ray& ray,
                                                  std::uint32_t sample) const noexcept = 0;
    /// Whether shade() will need the voxels around the ray's hit (TracedRay::around).
    [[nodiscard]] virtual bool needs_surroundings(const walk::TracedRay& ray) const noexcept = 0;
    /// Whether shade() will need a lamp near the ray's hit (TracedRay::lamp), which is not chosen
    /// yet.
    [[nodiscard]] virtual bool needs_lamp(const walk::TracedRay&) const noexcept { return false; }
    /// The random number by which it is chosen, [0, 1).
    [[nodiscard]] virtual double lamp_number(const walk::TracedRay&,
                                             const SampleSum&) const noexcept {
        return 0;
    }
    /// Adds to the sum what the ray has found, and to `next` the rays that must be traced as a
    /// result.
    virtual void shade(const walk::TracedRay& ray, SampleSum& sum,
                       std::vector<walk::TracedRay>& next) const = 0;
    /// The directions of fans of a stream (TracedRay::fan_mask).
    [[nodiscard]] virtual walk::FanDirections directions(std::uint32_t /*stream*/) const {
        return {};
    }
    /// The same as shade(), for a fan.
    virtual void shade_fan(const walk::TracedRay& /*fan*/, walk::FanEnds /*ends*/,
                           SampleSum& /*sum*/, std::vector<walk::TracedRay>& /*next*/) const {}
};

/// Evaluates rays of a picture: what they find is light.
class Shading : public RayEvaluator {
public:
    explicit Shading(const View& view) noexcept : m_view(view) {}

    [[nodiscard]] std::size_t wave_pixels(std::size_t rays) const noexcept final;
    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override;
    [[nodiscard]] bool needs_lamp(const walk::TracedRay& ray) const noexcept final;
    [[nodiscard]] double lamp_number(const walk::TracedRay& ray,
                                     const SampleSum& sum) const noexcept final;
    void shade(const walk::TracedRay& ray, SampleSum& sum,
               std::vector<walk::TracedRay>& next) const final;

protected:
    struct Interaction {
        const walk::TracedRay& ray;
        const Surface& surface;
        voxel::Colour weight;  ///< share of the surface's light that reaches the sample
        SampleSum& sum;
        std::vector<walk::TracedRay>& next;
    };
    /// Streams of random numbers used at one vertex.
    enum Use : std::uint32_t {
        kSunPoint,
        kDirection,
        kFacet,
        kChoice,
        kEnd,
        kSkyPoint,
        kOpacity,
        kAmbientRays,  // as many as there are ambient rays
        kLampChoice = 0x8000,
        kLampPoint
    };

    /// Shades an opaque face.
    virtual void shade_opaque(const Interaction& m) const = 0;
    /// Adds what a ray that has left the world sees, scaled by the weight.
    virtual void miss(const walk::TracedRay& ray, voxel::Colour weight, SampleSum& sum) const = 0;
    /// Whether mirrored and refracted rays are both sent (true), or one of them, chosen at random.
    [[nodiscard]] virtual bool splits(const walk::TracedRay& ray) const noexcept = 0;

    [[nodiscard]] bool allows_surroundings(const walk::TracedRay& ray) const noexcept;
    void add(const walk::TracedRay& ray, voxel::Colour light, SampleSum& sum) const noexcept {
        add(ray.direct, light, sum);
    }
    void add(bool direct, voxel::Colour light, SampleSum& sum) const noexcept;
    /// Sends a ray towards a point of the sun, with the light that it brings to a matt surface if
    /// unblocked.
    void send_sun(const Interaction& m, voxel::Colour weight) const;
    /// Sends a ray towards a point of the lamp that was chosen, with the light that it brings to a
    /// matt surface if unblocked.
    void send_lamp(const Interaction& m, voxel::Colour weight) const;
    /// Sends the ray that a smooth coat reflects.
    void send_mirror(const Interaction& m, voxel::Colour weight) const;
    /// Adds a ray from the surface to the next wave, back into the medium that the ray came
    /// through. It is made where it stays, since rays are large.
    /// @param branch separates the random streams of one vertex
    /// @return the ray, valid until the next one is added
    walk::TracedRay& send(const Interaction& m, core::Vec3 direction, walk::RayKind kind,
                          voxel::Colour weight, std::uint32_t branch) const;
    /// Share of the light of the sky, or of the sun, that reaches a bed through the medium above
    /// it.
    /// @param direction to the light
    [[nodiscard]] voxel::Colour through_medium(const Interaction& m,
                                               core::Vec3 direction) const noexcept;
    [[nodiscard]] static std::uint32_t to_number(const walk::TracedRay& ray,
                                                 std::uint32_t use) noexcept {
        return static_cast<std::uint32_t>(core::hash64(ray.stream, use));
    }

    const View& m_view;

private:
    // The steps of shade(). They are called for each ray, so they are kept in one source, where the
    // compiler can inline them.

    /// Shades the end of a ray that is not a shadow ray: a hit, a hole, or a miss.
    void shade_hit(const walk::TracedRay& ray, SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const;
    void shade_transparent(const Interaction& m) const;
    /// Adds the glow of the medium that the ray comes through, up to its hit if it has one.
    /// @return the weight after the medium's absorption
    [[nodiscard]] voxel::Colour through_water(const walk::TracedRay& ray, voxel::Colour weight,
                                              SampleSum& sum) const;
    /// Adds the light of the air in front of the hit (aerial perspective).
    /// @return the weight after the air's extinction
    [[nodiscard]] voxel::Colour through_air(const walk::TracedRay& ray, voxel::Colour weight,
                                            SampleSum& sum) const;
    /// Continues a ray that starts inside a voxel: in water or between leaves; inside rock it ends.
    void start_inside(const walk::TracedRay& ray, bool transparent,
                      std::vector<walk::TracedRay>& next) const;
    /// Whether the ray passes through a gap between the leaves that it has met.
    [[nodiscard]] bool slips_through(const walk::TracedRay& ray, const Surface& surface,
                                     const SampleSum& sum) const noexcept;
    /// Continues the ray behind the voxel that it has met.
    void continue_through(const walk::TracedRay& ray, std::vector<walk::TracedRay>& next) const;
    /// Continues the ray inside the medium that it starts in.
    void enter_medium(const walk::TracedRay& ray, std::vector<walk::TracedRay>& next) const;
};

/// Makes the shading for the scene's integrator.
/// @param view must outlive the result
[[nodiscard]] std::unique_ptr<const Shading> make_shading(const View& view);

/// What evaluates the rays of a view: its Measuring, or the shading of a picture.
/// @param view must outlive the result
[[nodiscard]] std::unique_ptr<const RayEvaluator> make_evaluator(const View& view);

}  // namespace terravox::shade
