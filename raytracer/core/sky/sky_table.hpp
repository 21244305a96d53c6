#pragma once

#include <vector>

#include "raytracer/core/sky/scattering.hpp"

namespace terravox::sky {

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
