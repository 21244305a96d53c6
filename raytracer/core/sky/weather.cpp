#include "raytracer/core/sky/weather.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/util/det_math.hpp"
#include "raytracer/core/base/random.hpp"
#include "raytracer/core/sky/atmosphere.hpp"

namespace terravox::sky {
namespace {

constexpr double kLargest_m = 2300;  // distance between the largest features
constexpr int kOctaves = 7;
constexpr double kRise = 0.36;  // of the noise, from a cloud's edge to its full thickness

// Gradient noise, about [-1, 1], smooth; gradients are functions of the lattice point.
double gradient_noise(double x, double y, std::uint64_t octave) noexcept {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    const double a = x - fx;
    const double b = y - fy;
    const auto ix = static_cast<std::int64_t>(fx);
    const auto iy = static_cast<std::int64_t>(fy);
    const auto corner = [&](int i, int j) {
        const std::uint64_t h =
            core::hash64(static_cast<std::uint64_t>(ix + i) * 0x9e3779b97f4a7c15 ^
                         static_cast<std::uint64_t>(iy + j) * 0xc2b2ae3d27d4eb4f ^ octave);
        const double gx = static_cast<double>(h >> 40) * 0x1.0p-23 - 1;
        const double gy = static_cast<double>(h & 0xffffff) * 0x1.0p-23 - 1;
        return gx * (a - i) + gy * (b - j);
    };
    const auto ease = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
    const double u = ease(a);
    const double v = ease(b);
    const double low = corner(0, 0) * (1 - u) + corner(1, 0) * u;
    const double high = corner(0, 1) * (1 - u) + corner(1, 1) * u;
    return 1.6 * (low * (1 - v) + high * v);
}

}  // namespace

Clouds::Clouds(double cover) : m_cover(std::clamp(cover, 0.0, 1.0)) {
    if (!any())
        return;
    // The threshold that leaves the wanted share above it, from places all over a large area (a
    // lattice that no octave is in step with).
    constexpr int kSamples = 4096;
    std::vector<double> found;
    found.reserve(kSamples);
    for (int i = 0; i < kSamples; ++i)
        found.push_back(noise(i * 1543.7, (i % 61) * 2311.3 - i * 377.1, kOctaves));
    std::sort(found.begin(), found.end());
    m_threshold = m_cover >= 1 ? found.front() - kRise / 3
                               : found[static_cast<std::size_t>((1 - m_cover) * (kSamples - 1))];
    double sum = 0;
    for (const double n : found)
        sum += det::exp(-find_depth(n));
    m_mean_passing = sum / kSamples;
}

double Clouds::noise(double x_m, double z_m, int octaves) noexcept {
    if (!(std::fabs(x_m) < 1e9 && std::fabs(z_m) < 1e9))
        return -1e9;
    double x = x_m / kLargest_m;
    double y = z_m / kLargest_m;
    double sum = 0;
    double weight = 0.55;
    // The largest features bend the smaller ones, which makes heaps out of blots.
    const double bend_x = gradient_noise(x * 0.7 + 31.4, y * 0.7, 101);
    const double bend_y = gradient_noise(x * 0.7, y * 0.7 - 17.7, 102);
    x += 0.35 * bend_x;
    y += 0.35 * bend_y;
    for (int octave = 0; octave < octaves; ++octave) {
        const double n = gradient_noise(x, y, static_cast<std::uint64_t>(octave));
        // Small octaves are rounded like the tops of cauliflower.
        sum += weight * (octave < 2 ? n : 0.55 - 1.5 * std::fabs(n) + 0.25 * n);
        weight *= octave == 0 ? 0.6 : 0.52;
        const double turned = 0.8 * x - 0.6 * y;
        y = (0.6 * x + 0.8 * y) * 2.03 + 5.2;
        x = turned * 2.03 - 1.7;
    }
    return sum;
}

double Clouds::find_depth(double noise) const noexcept {
    const double t = std::clamp((noise - m_threshold) / kRise, 0.0, 1.0);
    return kThickest * t * t * (1.5 - 0.5 * t);
}

double Clouds::depth(double x_m, double z_m) const noexcept {
    return any() ? find_depth(noise(x_m, z_m, kOctaves)) : 0;
}

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
