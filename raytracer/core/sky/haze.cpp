#include "raytracer/core/sky/haze.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/core/sky/atmosphere.hpp"

namespace terravox::sky {
namespace {

constexpr double kLog20 = 2.995732273553991;  // 5 % is what is left
// The bands that come nearest to the primaries: 600 - 630, 540 - 570 and 450 - 480 nm.
constexpr std::size_t kRed = 7;
constexpr std::size_t kGreen = 5;
constexpr std::size_t kBlue = 2;

voxel::Colour channels(const Spectrum& s, double times) noexcept {
    return {static_cast<float>(s[kRed] * times), static_cast<float>(s[kGreen] * times),
            static_cast<float>(s[kBlue] * times)};
}

/// Length of air as dense as at the lower end of a line that amounts to the same.
double dense_length(double metres, double rise, double scale_m) noexcept {
    const double x = metres * rise / scale_m;
    return x > 1e-6 ? metres * (1 - det::exp(-x)) / x : metres * (1 - x / 2);
}

}  // namespace

Haze::Haze(double turbidity, double place_height_m, std::optional<double> visibility_km) {
    const Atmosphere air(turbidity);
    const auto at = Atmosphere::densities(place_height_m);
    double rayleigh = at.rayleigh;
    double mie = at.mie;
    if (visibility_km) {
        // Molecules are always there; haze makes up the rest. Air clearer than molecules allow
        // keeps their colour.
        const double wanted = kLog20 / (*visibility_km * 1000);
        const double molecules = rayleigh * air.rayleigh()[kGreen];
        mie = std::max(0.0, wanted - molecules) / air.mie_extinction()[kGreen];
        rayleigh *= std::min(1.0, wanted / molecules);
    }
    m_rayleigh_per_m = channels(air.rayleigh(), rayleigh);
    m_mie_per_m = channels(air.mie_extinction(), mie);
}

voxel::Colour Haze::transmittance(core::Vec3 direction, double metres) const noexcept {
    if (!(metres > 0))
        return {1, 1, 1};
    metres = std::min(metres, 1e12);
    const double rise = std::fabs(direction.y);
    const double rayleigh = dense_length(metres, rise, Atmosphere::kRayleighScale_m);
    const double mie = dense_length(metres, rise, Atmosphere::kMieScale_m);
    const auto left = [&](float r, float m) {
        return static_cast<float>(
            det::exp(-static_cast<double>(r) * rayleigh - static_cast<double>(m) * mie));
    };
    return {left(m_rayleigh_per_m.r, m_mie_per_m.r), left(m_rayleigh_per_m.g, m_mie_per_m.g),
            left(m_rayleigh_per_m.b, m_mie_per_m.b)};
}

}  // namespace terravox::sky
