#include "raytracer/core/sky/sky_table.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::sky {
namespace {

// Of the table of multiple scattering.
constexpr int kTableHeights = 10;
constexpr int kTableSines = 14;
// Along a level line of sight the sun's altitude changes by up to 10.2 degrees until the air ends.
constexpr double kReach_rad = 0.2;
constexpr double kGround_m = Atmosphere::kEarth_m;
constexpr double kTop_m = Atmosphere::kEarth_m + Atmosphere::kThick_m;

/// Walks a line of sight through the air in steps that grow with the distance, and calls
/// visit(height, sine of the sun's altitude, densities, weight per band), where weight is the
/// integral of transmittance over the step.
/// @return transmittance of the whole line
template <class Visit>
Spectrum march(const Atmosphere& air, double height, core::Vec3 direction, core::Vec3 to_sun,
               double end, int steps, Visit&& visit) {
    Spectrum left;
    left.fill(1);
    const core::Vec3 start{0, kGround_m + height, 0};
    for (int i = 0; i < steps; ++i) {
        const double a = static_cast<double>(i) / steps;
        const double b = static_cast<double>(i + 1) / steps;
        const double from = end * a * a;
        const double step = end * b * b - from;
        const core::Vec3 at = start + direction * (from + step / 2);
        const double r = core::length(at);
        const double here = std::max(0.0, r - kGround_m);
        const auto densities = Atmosphere::densities(here);
        const Spectrum extinction = air.extinction(densities);
        Spectrum weight;
        for (std::size_t k = 0; k < kBands; ++k) {
            const double depth = extinction[k] * step;
            const double through = det::exp(-depth);
            // (1 - e^-x) / x loses its digits for small x, where it is 1 - x / 2.
            weight[k] = left[k] * step * (depth > 1e-6 ? (1 - through) / depth : 1 - depth / 2);
            left[k] *= through;
        }
        visit(here, core::dot(at, to_sun) / r, densities, weight);
    }
    return left;
}

double to_top(double height, double sine) noexcept {
    const double r = kGround_m + height;
    return -r * sine + std::sqrt(std::max(0.0, r * r * (sine * sine - 1) + kTop_m * kTop_m));
}

/// @return the distance to the ground, or a negative number
double to_ground(double height, double sine) noexcept {
    const double r = kGround_m + height;
    const double inside = r * r * (sine * sine - 1) + kGround_m * kGround_m;
    return sine < 0 && inside > 0 ? -r * sine - std::sqrt(inside) : -1;
}

}  // namespace

Scattering::Scattering(const Atmosphere& atmosphere, double altitude_rad)
    : m_atmosphere(atmosphere) {
    const auto sun = det::sin_cos(altitude_rad);
    m_to_sun = {sun.cos, sun.sin, 0};
    m_first_sine = det::sin(std::max(altitude_rad - kReach_rad, -det::kPi / 2));
    m_last_sine = det::sin(std::min(altitude_rad + kReach_rad, det::kPi / 2));
    m_multiple.reserve(static_cast<std::size_t>(kTableHeights) * kTableSines);
    for (int i = 0; i < kTableHeights; ++i)
        for (int j = 0; j < kTableSines; ++j) {
            const double u = static_cast<double>(i) / (kTableHeights - 1);
            const double v = static_cast<double>(j) / (kTableSines - 1);
            m_multiple.push_back(gathered(Atmosphere::kThick_m * u * u,
                                          m_first_sine + (m_last_sine - m_first_sine) * v));
        }
}

// Step 1 of Hillaire's estimate: light scattered twice, as if the first time had no direction. Step
// 2: all further orders are a geometric series, whose ratio is the share of evenly spread light
// that comes back after one more scattering.
Spectrum Scattering::gathered(double height_m, double sun_sine) const noexcept {
    // Eight elevations (Gauss and Legendre's, on [-1, 1]) by four azimuths; the other side of the
    // sun's plane is the same.
    constexpr double kNodes[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                 0.9602898564975363};
    constexpr double kWeights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                   0.1012285362903763};
    constexpr double kAzimuthCosines[] = {0.9238795325112867, 0.3826834323650898,
                                          -0.3826834323650898, -0.9238795325112867};
    constexpr int kSteps = 12;
    const core::Vec3 to_sun{std::sqrt(std::max(0.0, 1 - sun_sine * sun_sine)), sun_sine, 0};
    Spectrum twice{};
    Spectrum again{};
    for (int n = 0; n < 8; ++n) {
        const double sine = n < 4 ? kNodes[n] : -kNodes[n - 4];
        const double flat = std::sqrt(1 - sine * sine);
        const double ground = to_ground(height_m, sine);
        const double end = ground >= 0 ? ground : to_top(height_m, sine);
        for (const double c : kAzimuthCosines) {
            const double share = kWeights[n % 4] / 2 / 4;
            const core::Vec3 direction{flat * c, sine, flat * std::sqrt(1 - c * c)};
            const Spectrum left =
                march(m_atmosphere, height_m, direction, to_sun, end, kSteps,
                      [&](double h, double s, const auto& d, const Spectrum& weight) {
                          const Spectrum sun = m_atmosphere.sunlight(h, s);
                          for (std::size_t k = 0; k < kBands; ++k) {
                              const double scattered = (d.rayleigh * m_atmosphere.rayleigh()[k] +
                                                        d.mie * m_atmosphere.mie_scattering()[k]) *
                                                       weight[k] * share;
                              twice[k] += scattered * sun[k] / (4 * det::kPi);
                              again[k] += scattered;
                          }
                      });
            if (ground < 0)
                continue;
            const core::Vec3 foot = core::Vec3{0, kGround_m + height_m, 0} + direction * ground;
            const double facing = core::dot(foot, to_sun) / kGround_m;
            const Spectrum sun = m_atmosphere.sunlight(0, facing);
            for (std::size_t k = 0; k < kBands; ++k)
                twice[k] += share * left[k] * Atmosphere::ground_albedo()[k] / det::kPi *
                            std::max(0.0, facing) * sun[k];
        }
    }
    for (std::size_t k = 0; k < kBands; ++k)
        twice[k] /= 1 - std::min(again[k], 0.98);
    return twice;
}

Spectrum Scattering::multiple_at(double height_m, double sun_sine) const noexcept {
    const double u =
        std::sqrt(std::clamp(height_m / Atmosphere::kThick_m, 0.0, 1.0)) * (kTableHeights - 1);
    const double v =
        std::clamp((sun_sine - m_first_sine) / (m_last_sine - m_first_sine), 0.0, 1.0) *
        (kTableSines - 1);
    const int i = std::min(static_cast<int>(u), kTableHeights - 2);
    const int j = std::min(static_cast<int>(v), kTableSines - 2);
    const double a = u - i;
    const double b = v - j;
    const Spectrum* node = &m_multiple[static_cast<std::size_t>(i * kTableSines + j)];
    Spectrum out;
    for (std::size_t k = 0; k < kBands; ++k)
        out[k] = (1 - a) * ((1 - b) * node[0][k] + b * node[1][k]) +
                 a * ((1 - b) * node[kTableSines][k] + b * node[kTableSines + 1][k]);
    return out;
}

Scattered Scattering::seen(double height_m, double elevation,
                           double azimuth_cosine) const noexcept {
    constexpr int kSteps = 32;
    Scattered out;
    const double flat = std::sqrt(std::max(0.0, 1 - elevation * elevation));
    const double across = std::sqrt(std::max(0.0, 1 - azimuth_cosine * azimuth_cosine));
    const core::Vec3 direction{flat * azimuth_cosine, elevation, flat * across};
    march(m_atmosphere, height_m, direction, m_to_sun, to_top(height_m, elevation), kSteps,
          [&](double h, double s, const auto& d, const Spectrum& weight) {
              const Spectrum sun = m_atmosphere.sunlight(h, s);
              const Spectrum multiple = multiple_at(h, s);
              for (std::size_t k = 0; k < kBands; ++k) {
                  const double rayleigh = d.rayleigh * m_atmosphere.rayleigh()[k] * weight[k];
                  const double mie = d.mie * m_atmosphere.mie_scattering()[k] * weight[k];
                  out.rayleigh[k] += rayleigh * sun[k];
                  out.mie[k] += mie * sun[k];
                  out.multiple[k] += (rayleigh + mie) * multiple[k];
              }
          });
    return out;
}

namespace {

// Rows stand at elevations of sine (i / last)^2, close together near the horizon; columns at
// azimuths whose half has the sine j / last, close together near the sun.
constexpr int kRows = 40;
constexpr int kColumns = 24;

/// Clamps to [0, 1]; NaN becomes 0, so that no direction leads outside the table.
double cut(double v) noexcept {
    return v > 0 ? std::min(v, 1.0) : 0;
}

}  // namespace

voxel::Colour sun_colour(const Spectrum& share, double scale) noexcept {
    Spectrum light;
    for (std::size_t k = 0; k < kBands; ++k)
        light[k] = share[k] * kSolarIrradiance[k] * scale;
    return to_rec709(light);
}

double picture_scale() {
    static const double scale = [] {
        constexpr double kNoonLight = 2.4;
        constexpr double kTurbidity = 2.5;
        constexpr double kRad = det::kPi / 180;
        return kNoonLight / static_cast<double>(voxel::luminance(sun_colour(
                                Atmosphere(kTurbidity).transmittance(0, det::sin(45 * kRad)), 1)));
    }();
    return scale;
}

SkyTable::SkyTable(const Scattering& scattering, double height_m, double scale) {
    m_nodes.reserve(static_cast<std::size_t>(kRows) * kColumns);
    for (int i = 0; i < kRows; ++i)
        for (int j = 0; j < kColumns; ++j) {
            if (i == kRows - 1 && j > 0) {  // the zenith is one place
                m_nodes.push_back(m_nodes.back());
                continue;
            }
            const double u = static_cast<double>(i) / (kRows - 1);
            const double v = static_cast<double>(j) / (kColumns - 1);
            const Scattered s = scattering.seen(height_m, u * u, 1 - 2 * v * v);
            m_nodes.push_back({sun_colour(s.rayleigh, scale), sun_colour(s.mie, scale),
                               sun_colour(s.multiple, scale)});
        }
}

voxel::Colour SkyTable::at(double elevation, double azimuth_cosine,
                           double sun_cosine) const noexcept {
    const double u = std::sqrt(cut(elevation)) * (kRows - 1);
    const double v = std::sqrt(cut((1 - azimuth_cosine) / 2)) * (kColumns - 1);
    const int i = std::min(static_cast<int>(u), kRows - 2);
    const int j = std::min(static_cast<int>(v), kColumns - 2);
    const auto a = static_cast<float>(u - i);
    const auto b = static_cast<float>(v - j);
    const auto rayleigh = static_cast<float>(rayleigh_phase(sun_cosine));
    const auto mie = static_cast<float>(mie_phase(sun_cosine));
    const auto of = [&](const Node& n) { return n.rayleigh * rayleigh + n.mie * mie + n.multiple; };
    const Node* node = &m_nodes[static_cast<std::size_t>(i * kColumns + j)];
    return voxel::mix(voxel::mix(of(node[0]), of(node[1]), b),
                      voxel::mix(of(node[kColumns]), of(node[kColumns + 1]), b), a);
}

}  // namespace terravox::sky
