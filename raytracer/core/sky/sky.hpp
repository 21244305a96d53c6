#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/geo/sun_position.hpp"
#include "common/voxel/colour.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::sky {

/// Light from approximately one direction.
struct LightFrom {
    core::Vec3 direction;  ///< of unit length
    voxel::Colour radiance;
    double solid_angle;  ///< steradians
};

/// The light that a white Lambertian surface reflects under light from all around, for every
/// normal: a table over the octahedron, exact for the normals of a voxel's faces up to the sum over
/// the light given. Immutable, thread-safe. Ref: Meyer et al., "On floating-point normal vectors",
/// EGSR 2010 (the octahedral map).
class AmbientTable {
public:
    AmbientTable() = default;  ///< darkness
    explicit AmbientTable(std::span<const LightFrom> light);
    /// @param normal of any length except 0
    [[nodiscard]] voxel::Colour at(core::Vec3 normal) const noexcept;

private:
    std::vector<voxel::Colour> m_nodes;
};

struct SkySample {
    core::Vec3 direction;  ///< of unit length, y >= 0
    double pdf = 0;        ///< 1 / sr
};

/// Samples directions of the upper hemisphere, bright ones more often: the density is constant over
/// each of 64 x 32 cells of equal solid angle. Immutable, thread-safe.
class SkySampler {
public:
    static constexpr int kColumns = 64, kRows = 32;  ///< in azimuth; in the sine of the elevation

    /// @param luminance of the cells, row by row from the horizon up, each from azimuth 0 (east)
    /// over south; >= 0
    explicit SkySampler(const std::vector<double>& luminance);

    /// @param u, v [0, 1)
    [[nodiscard]] SkySample sample(double u, double v) const noexcept;
    /// @param direction of unit length
    /// @return density of sample(); 0 below the horizon
    [[nodiscard]] double pdf(core::Vec3 direction) const noexcept;

private:
    /// A choice of one of kCount by their shares. Ref: Chen, Asau, "On generating random variates
    /// from an empirical distribution", AIIE Transactions 6(2), 1974 (the guide table).
    template <int kCount>
    struct Choice {
        static_assert(kCount <= 256);
        std::array<double, kCount> ends{};  ///< sum of the shares up to and including each; last: 1
        /// The first whose end lies beyond i / kCount: where the search for such a number begins.
        std::array<std::uint8_t, kCount> guide{};

        void make_guide() noexcept;
        /// @return the first whose end lies beyond `u`, [0, 1); `u` becomes its place in that
        /// share, [0, 1]
        [[nodiscard]] int find(double& u) const noexcept;
    };
    Choice<kRows> m_rows;
    std::vector<Choice<kColumns>> m_columns;  ///< of each row
    std::vector<double> m_pdf;                ///< of each cell, 1 / sr
};

/// The air between the eye and a thing: the light that arrives is the thing's times
/// `transmittance`, plus `light`.
struct Air {
    voxel::Colour transmittance{1, 1, 1};
    voxel::Colour light;
};

/// Daylight over one place: the sun, the sky with its clouds and stars, and the air in front of
/// distant things. Light is stated as the radiance that a white Lambertian surface facing it
/// reflects (irradiance / pi), so radiance of the sky needs no factor; a sun 45 degrees high in
/// clear air has 2.4. Directions: x east, y up, z south. Immutable, thread-safe, cheap to copy; the
/// same bits on every machine of one architecture.
class Sky {
public:
    /// @param sun position of the sun, which may be below the horizon
    /// @param place_height_m above the sea, of the ground in view
    /// @param eye_m the camera in world axes, metres: the clouds that it sees are those that cast
    /// shadows; without clouds any place will do
    Sky(const geo::SunPosition& sun, const scene::Scene::Sun& sun_settings,
        const scene::Scene::Sky& sky_settings, double place_height_m, core::Vec3 eye_m = {});

    /// Direction to the middle of the sun's disc, of unit length.
    [[nodiscard]] core::Vec3 to_sun() const noexcept;
    /// Whether any part of the disc is above a level horizon.
    [[nodiscard]] bool sun_up() const noexcept;
    /// Sunlight on a surface that faces it, on the ground, without clouds; black when the sun is
    /// not up. Continuous while it sets.
    [[nodiscard]] voxel::Colour sun_light() const noexcept;
    [[nodiscard]] double sun_radius_rad() const noexcept;  ///< 0: a point
    /// Samples a direction of the disc, uniformly over solid angle.
    /// @param u, v [0, 1)
    [[nodiscard]] core::Vec3 sample_sun(double u, double v) const noexcept;
    /// Radiance of the disc: brightest in the middle, 0 outside. Its integral is sun_light().
    /// @param direction of unit length
    [[nodiscard]] voxel::Colour sun_disc(core::Vec3 direction) const noexcept;

    /// Radiance that a ray leaving the world sees, without the sun's disc. Below the horizon: an
    /// infinite plain, lit like the world, behind its haze; continuous at the horizon.
    /// @param direction of unit length
    [[nodiscard]] voxel::Colour radiance(core::Vec3 direction) const noexcept;
    /// Light of all of radiance() on a surface: its mean weighted by the cosine.
    /// @param normal of unit length
    [[nodiscard]] voxel::Colour ambient(core::Vec3 normal) const noexcept;
    /// The same for the normal of a voxel's face, without a look into the table.
    /// @param face not kNone
    [[nodiscard]] voxel::Colour ambient(core::Face face) const noexcept;
    /// Whether some of it is brighter than the rest, so that sample() is worth its rays.
    [[nodiscard]] bool uneven() const noexcept;
    /// Samples a direction above the horizon, bright ones more often.
    /// @param u, v [0, 1)
    [[nodiscard]] SkySample sample(double u, double v) const noexcept;
    /// Density of sample(), 1 / sr; 0 below the horizon.
    [[nodiscard]] double pdf(core::Vec3 direction) const noexcept;

    /// @param direction from the eye, of unit length
    /// @param metres to the thing, [0, infinity]
    [[nodiscard]] Air air(core::Vec3 direction, double metres) const noexcept;
    /// Share of sunlight that passes through the clouds, [0, 1].
    /// @param point_m world axes, metres
    [[nodiscard]] float cloud_shadow(core::Vec3 point_m) const noexcept;

private:
    class Parts;
    std::shared_ptr<const Parts> m_parts;
};

}  // namespace terravox::sky
