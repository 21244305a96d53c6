#pragma once

#include <memory>
#include <optional>

#include "common/voxel/colour.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/sky/sky_table.hpp"
#include "raytracer/core/sky/sun.hpp"
#include "raytracer/core/sky/weather.hpp"

namespace terravox::sky {

/// The stars: points of a few hundredths of a degree, the same in every picture, about seven
/// hundred above any horizon. They represent a night sky, not that of a given date. Their light on
/// things is negligible and not computed.
/// @param d of unit length
/// @return radiance as a multiple of the night sky's
[[nodiscard]] voxel::Colour starlight(core::Vec3 d) noexcept;

/// The glow of a clear night at the zenith. That of a moonless night is a ten-thousandth of this;
/// like a lens left open, the picture's night is as bright as the end of dusk.
inline constexpr voxel::Colour kNightLight{1.1e-5f, 2.0e-5f, 4.4e-5f};

/// Radiance of the upper half of the sky: the clear air by day and in twilight, the night's glow
/// and stars, and clouds in front of them, without the sun's disc. Natural light: no strength of a
/// scene is applied. Immutable and thread-safe once lit.
class Dome {
public:
    struct Settings {
        double turbidity = 2.5;
        double place_height_m = 0;
        double clouds = 0;
        double cloud_height_m = 1500;
        std::optional<double> visibility_km;  ///< > 0
        core::Vec3 eye_m;                     ///< eye around which the clouds lie
    };
    Dome(const Sun& sun, const Settings& settings);

    /// Radiance of the air alone, for directions on and above the horizon.
    /// @param d of unit length, y >= 0
    [[nodiscard]] voxel::Colour clear(core::Vec3 d) const noexcept;
    /// Radiance of the air at the horizon below or above a direction; varies smoothly, also through
    /// the zenith and nadir.
    [[nodiscard]] voxel::Colour horizon(core::Vec3 d) const noexcept;
    /// Radiance of everything together.
    /// @param d of unit length, y >= 0
    [[nodiscard]] voxel::Colour radiance(core::Vec3 d) const noexcept;
    /// Sunlight on a surface that faces the sun, on the ground, under a clear sky.
    [[nodiscard]] voxel::Colour sun_light() const noexcept { return m_sun_light; }
    /// Share of light from a direction that passes through the clouds.
    /// @param d of unit length, y >= 0
    [[nodiscard]] double passing(core::Vec3 d) const noexcept;
    /// Share of sunlight that passes through the clouds to a point.
    /// @param point_m world axes, metres
    [[nodiscard]] double sun_passing(core::Vec3 point_m) const noexcept;
    [[nodiscard]] double mean_passing() const noexcept { return m_clouds.mean_passing(); }
    [[nodiscard]] const Haze& haze() const noexcept { return m_haze; }

private:
    struct CloudPlace {
        double distance_m;
        double x_m;
        double z_m;
    };
    [[nodiscard]] double azimuth_cosine(core::Vec3 d, double flat) const noexcept;
    [[nodiscard]] CloudPlace cloud_place(core::Vec3 d) const noexcept;
    [[nodiscard]] voxel::Colour cloud_light(const CloudPlace& at, double depth,
                                            double sun_cosine) const noexcept;
    void light_clouds(const Atmosphere& air, double scale);

    Settings m_settings;
    core::Vec3 m_to_sun, m_sun_flat;  ///< flat: horizontal, of unit length
    Haze m_haze;
    Clouds m_clouds;
    std::shared_ptr<const SkyTable> m_table;
    voxel::Colour m_sun_light;
    voxel::Colour m_cloud_sun;
    voxel::Colour m_cloud_above;
    voxel::Colour m_cloud_below;
    float m_stars = 0;
};

/// Share of light that the open country around the world reflects.
[[nodiscard]] voxel::Colour ground_colour() noexcept;

}  // namespace terravox::sky
