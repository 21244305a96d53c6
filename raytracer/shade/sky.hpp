#pragma once

#include "common/geo/sun_position.hpp"
#include "raytracer/scene/scene.hpp"
#include "raytracer/shade/colour.hpp"
#include "raytracer/walk/ray.hpp"

namespace terravox {

struct SkySample {
    Vec3 direction;
    double pdf;
};
struct Air {
    Colour transmittance, light;
};

/// The light of a simple clear day: a sun of one direction, and a sky that pales towards the horizon and the sun. Immutable.
class Sky {
public:
    /// @param sun where the sun stands; below the horizon there is only a dim sky
    Sky(const geo::SunPosition& sun, const Scene::Sun& sun_settings, const Scene::Sky& sky_settings);

    [[nodiscard]] Vec3 to_sun() const noexcept { return m_to_sun; }
    [[nodiscard]] Colour sun_light() const noexcept { return m_sun_light; }  ///< on a surface that faces the sun
    [[nodiscard]] bool sun_up() const noexcept { return m_to_sun.y > 0; }
    /// What a ray that leaves the world sees. @param direction of unit length
    [[nodiscard]] Colour radiance(Vec3 direction) const noexcept;
    /// Light of the whole sky (and the ground's reflection of it) on a surface of the given normal.
    [[nodiscard]] Colour ambient(Vec3 normal) const noexcept;
    [[nodiscard]] Vec3 sample_sun(double, double) const noexcept { return m_to_sun; }
    [[nodiscard]] double sun_radius_rad() const noexcept { return 0; }
    [[nodiscard]] Colour sun_disc(Vec3) const noexcept { return {}; }
    [[nodiscard]] float cloud_shadow(Vec3) const noexcept { return 1; }
    [[nodiscard]] bool uneven() const noexcept { return false; }
    [[nodiscard]] SkySample sample(double, double) const noexcept { return {{0, 1, 0}, 0}; }
    [[nodiscard]] double pdf(Vec3) const noexcept { return 0; }
    [[nodiscard]] Air air(Vec3 d, double metres) const noexcept {
        const float h = haze(metres);
        return {Colour{1, 1, 1} * (1 - h), radiance(normalized({d.x, std::max(d.y, 0.0), d.z})) * h};
    }
    /// Share of contrast that haze takes over a distance. @param metres @return [0, 1]
    [[nodiscard]] float haze(double metres) const noexcept;

private:
    Vec3 m_to_sun;
    Colour m_sun_light, m_zenith, m_horizon, m_ground;
    double m_extinction_per_m;
};

/// The sun of a scene at a place: altitude and azimuth if given, else date, time and place.
/// @param place nullptr for worlds that are nowhere on Earth: latitude 46, longitude 14 then @throws UsageError for a bad date
[[nodiscard]] geo::SunPosition sun_of(const Scene::Sun& sun, const geo::LatLon* place);

}  // namespace terravox
