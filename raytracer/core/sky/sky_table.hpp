#pragma once

#include <vector>

#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/sky/atmosphere.hpp"

namespace terravox::sky {

/// Light that arrives along a line of sight, as shares of the sun's above the air, per steradian.
/// `rayleigh` and `mie` have been scattered once and still lack their phase functions; `multiple`
/// is complete.
struct Scattered {
    Spectrum rayleigh{};
    Spectrum mie{};
    Spectrum multiple{};
};

/// Scattered sunlight in the air for one altitude of the sun. Immutable, thread-safe.
/// Ref: Nishita, Sirai, Tadamura, Nakamae, "Display of the Earth taking into account atmospheric
/// scattering", SIGGRAPH 1993 (single scattering); Hillaire, "A scalable and production ready sky
/// and atmosphere rendering technique", EGSR 2020 (multiple scattering).
class Scattering {
public:
    /// @param altitude_rad of the sun at the observer, [-pi / 2, pi / 2]
    /// @param atmosphere must outlive this
    Scattering(const Atmosphere& atmosphere, double altitude_rad);

    /// Light seen by an observer.
    /// @param height_m [0, kThick_m)
    /// @param elevation sine, [0, 1]
    /// @param azimuth_cosine from the sun
    [[nodiscard]] Scattered seen(double height_m, double elevation,
                                 double azimuth_cosine) const noexcept;

private:
    /// Light scattered any number of times: the average over all directions of what arrives.
    [[nodiscard]] Spectrum multiple_at(double height_m, double sun_sine) const noexcept;
    [[nodiscard]] Spectrum gathered(double height_m, double sun_sine) const noexcept;
    const Atmosphere& m_atmosphere;
    core::Vec3 m_to_sun;  ///< x away from the observer, y up
    double m_first_sine;
    double m_last_sine;
    std::vector<Spectrum> m_multiple;
};

/// The clear sky over one place and for one sun, in linear Rec. 709. Phase functions vary fast near
/// the sun; they are not part of the table but applied by at(). Immutable, thread-safe.
class SkyTable {
public:
    /// @param scale factor from light to the units of a picture; includes the sun's spectrum above
    /// the air
    SkyTable(const Scattering& scattering, double height_m, double scale);

    /// @param elevation sine, [0, 1]
    /// @param azimuth_cosine of the azimuth from the sun
    /// @param sun_cosine of the angle to the sun
    /// @return radiance; components may be slightly negative where light is purer than the
    /// primaries
    [[nodiscard]] voxel::Colour at(double elevation, double azimuth_cosine,
                                   double sun_cosine) const noexcept;

private:
    struct Node {
        voxel::Colour rayleigh;
        voxel::Colour mie;
        voxel::Colour multiple;
    };
    std::vector<Node> m_nodes;
};

/// The colour of a spectrum that is given as shares of the sun's light above the air.
/// @param scale times W / m^2
[[nodiscard]] voxel::Colour sun_colour(const Spectrum& share, double scale) noexcept;

/// Factor from shares of the sun's spectrum to the units of a picture: a sun 45 degrees high in
/// clear air gives 2.4.
[[nodiscard]] double picture_scale();

}  // namespace terravox::sky
