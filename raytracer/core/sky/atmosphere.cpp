#include "raytracer/core/sky/atmosphere.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::sky {
namespace {

struct Xyz {
    double x = 0;
    double y = 0;
    double z = 0;
};

double lobe(double nm, double middle, double below, double above) noexcept {
    const double t = (nm - middle) / (nm < middle ? below : above);
    return det::exp(-t * t / 2);
}

// Ref: Wyman, Sloan, Shirley, "Simple analytic approximations to the CIE XYZ color matching
// functions", JCGT 2013 (multi-lobe fits).
Xyz matching(double nm) noexcept {
    return {1.056 * lobe(nm, 599.8, 37.9, 31.0) + 0.362 * lobe(nm, 442.0, 16.0, 26.7) -
                0.065 * lobe(nm, 501.1, 20.4, 26.2),
            0.821 * lobe(nm, 568.8, 46.9, 40.5) + 0.286 * lobe(nm, 530.9, 16.3, 31.1),
            1.217 * lobe(nm, 437.0, 11.8, 36.0) + 0.681 * lobe(nm, 459.0, 26.0, 13.8)};
}

struct Weights {
    std::array<double, kBands> r;
    std::array<double, kBands> g;
    std::array<double, kBands> b;
};

// What a band brings to each primary: the mean of the matching functions over the band. Ref: ITU-R
// BT.709 for the matrix.
Weights make_weights() noexcept {
    Weights w{};
    for (int band = 0; band < kBands; ++band) {
        constexpr int kParts = 30;
        Xyz sum;
        for (int i = 0; i < kParts; ++i) {
            const Xyz m =
                matching(wavelength_nm(band) + kBandWidth_nm * ((i + 0.5) / kParts - 0.5));
            sum.x += m.x;
            sum.y += m.y;
            sum.z += m.z;
        }
        const double s = kBandWidth_nm / kParts;
        const auto i = static_cast<std::size_t>(band);
        w.r[i] = s * (3.2404542 * sum.x - 1.5371385 * sum.y - 0.4985314 * sum.z);
        w.g[i] = s * (-0.9692660 * sum.x + 1.8760108 * sum.y + 0.0415560 * sum.z);
        w.b[i] = s * (0.0556434 * sum.x - 0.2040259 * sum.y + 1.0572252 * sum.z);
    }
    // A camera set to daylight: the sun's light above the air is white (a plain scaling of the
    // primaries, all are close to it).
    double r = 0;
    double g = 0;
    double b = 0;
    for (std::size_t i = 0; i < kBands; ++i) {
        r += w.r[i] * kSolarIrradiance[i];
        g += w.g[i] * kSolarIrradiance[i];
        b += w.b[i] * kSolarIrradiance[i];
    }
    for (std::size_t i = 0; i < kBands; ++i) {
        w.r[i] *= g / r;
        w.b[i] *= g / b;
    }
    return w;
}

}  // namespace

voxel::Colour to_rec709(const Spectrum& s) noexcept {
    static const Weights weights = make_weights();
    double r = 0;
    double g = 0;
    double b = 0;
    for (std::size_t i = 0; i < kBands; ++i) {
        r += s[i] * weights.r[i];
        g += s[i] * weights.g[i];
        b += s[i] * weights.b[i];
    }
    return {static_cast<float>(r), static_cast<float>(g), static_cast<float>(b)};
}

voxel::Colour in_gamut(voxel::Colour c) noexcept {
    // The filters of a camera overlap: no light of a sky leaves one of them dark. Without this the
    // glow of a low sun would turn a flat yellow where it is overexposed.
    constexpr float kMin = 0.04f;
    const float grey = voxel::luminance(c);
    if (!(grey > 0))
        return {};
    const float least = std::min({c.r, c.g, c.b});
    if (least >= kMin * grey)
        return c;
    const float t = grey * (1 - kMin) / (grey - least);  // share of the colour that is kept
    const auto paled = [&](float v) { return std::max(0.0f, grey + (v - grey) * t); };
    return {paled(c.r), paled(c.g), paled(c.b)};
}

namespace {

constexpr double kMieAlbedo = 0.92;  // of dust and droplets inland
constexpr double kMieForward = 0.8;
constexpr double kOzoneMiddle_m = 25'000;
constexpr double kOzoneHalf_m = 15'000;
constexpr double kOzoneMolecules_m2 = 300 * 2.687e20;  // 300 Dobson units

constexpr int kHeights = 32;
constexpr int kSines = 64;
constexpr int kSteps = 40;

/// Substance between a point and the end of the air, metres of the densest: the same for every
/// turbidity, so made once.
class Columns {
public:
    Columns() : m_nodes(static_cast<std::size_t>(kHeights) * kSines) {
        for (int i = 0; i < kHeights; ++i)
            for (int j = 0; j < kSines; ++j) {
                const double u = static_cast<double>(i) / (kHeights - 1);
                const double v = static_cast<double>(j) / (kSines - 1);
                const double height = Atmosphere::kThick_m * u * u;
                const double low = horizon_sine(height);
                m_nodes[place(i, j)] = integrate(height, low + (1 - low) * v * v);
            }
    }
    /// Of the horizon seen from a height: it lies lower than level.
    static double horizon_sine(double height) noexcept {
        const double q = Atmosphere::kEarth_m / (Atmosphere::kEarth_m + height);
        return -std::sqrt(std::max(0.0, 1 - q * q));
    }
    Atmosphere::Densities at(double height, double sine, double horizon) const noexcept {
        const double u =
            std::sqrt(std::clamp(height / Atmosphere::kThick_m, 0.0, 1.0)) * (kHeights - 1);
        const double v =
            std::sqrt(std::clamp((sine - horizon) / (1 - horizon), 0.0, 1.0)) * (kSines - 1);
        const int i = std::min(static_cast<int>(u), kHeights - 2);
        const int j = std::min(static_cast<int>(v), kSines - 2);
        const double a = u - i;
        const double b = v - j;
        Atmosphere::Densities out;
        const auto add = [&](int di, int dj, double w) {
            const auto& n = m_nodes[place(i + di, j + dj)];
            out.rayleigh += w * n.rayleigh;
            out.mie += w * n.mie;
            out.ozone += w * n.ozone;
        };
        add(0, 0, (1 - a) * (1 - b));
        add(0, 1, (1 - a) * b);
        add(1, 0, a * (1 - b));
        add(1, 1, a * b);
        return out;
    }

private:
    static std::size_t place(int i, int j) noexcept {
        return static_cast<std::size_t>(i) * kSines + static_cast<std::size_t>(j);
    }
    static Atmosphere::Densities integrate(double height, double sine) noexcept {
        const double r = Atmosphere::kEarth_m + height;
        const double top = Atmosphere::kEarth_m + Atmosphere::kThick_m;
        const double end =
            -r * sine + std::sqrt(std::max(0.0, r * r * (sine * sine - 1) + top * top));
        // A ray that sinks first is densest at its lowest point: steps are finest there, and grow
        // to both sides.
        const double lowest = std::min(std::max(0.0, -r * sine), end);
        Atmosphere::Densities sum;
        const auto part = [&](double from, double to) {
            for (int i = 0; i < kSteps; ++i) {
                const double a = static_cast<double>(i) / kSteps;
                const double b = static_cast<double>(i + 1) / kSteps;
                const double s = from + (to - from) * (a * a + b * b) / 2;
                const double step = std::fabs(to - from) * (b * b - a * a);
                const auto d = Atmosphere::densities(std::sqrt(r * r + s * s + 2 * r * s * sine) -
                                                     Atmosphere::kEarth_m);
                sum.rayleigh += d.rayleigh * step;
                sum.mie += d.mie * step;
                sum.ozone += d.ozone * step;
            }
        };
        part(lowest, end);
        if (lowest > 0)
            part(lowest, 0);
        return sum;
    }
    std::vector<Atmosphere::Densities> m_nodes;
};

const Columns& columns() {
    static const Columns made;
    return made;
}

}  // namespace

Atmosphere::Atmosphere(double turbidity) {
    columns();
    const double angstrom = std::max(0.0, 0.04608 * turbidity - 0.04586);
    for (int band = 0; band < kBands; ++band) {
        const auto i = static_cast<std::size_t>(band);
        const double um = wavelength_nm(band) / 1000;
        const double um2 = um * um;
        m_rayleigh[i] = 1.24062e-6 / (um2 * um2);
        m_mie_extinction[i] = angstrom * det::pow(um, -1.3) / kMieScale_m;
        m_mie_scattering[i] = kMieAlbedo * m_mie_extinction[i];
        m_ozone[i] = kOzoneCrossSection_m2[i] * kOzoneMolecules_m2 / kOzoneHalf_m;
    }
}

Atmosphere::Densities Atmosphere::densities(double height_m) noexcept {
    const double h = std::max(0.0, height_m);
    return {det::exp(-h / kRayleighScale_m), det::exp(-h / kMieScale_m),
            std::max(0.0, 1 - std::fabs(h - kOzoneMiddle_m) / kOzoneHalf_m)};
}

Spectrum Atmosphere::extinction(const Densities& at) const noexcept {
    Spectrum out;
    for (std::size_t i = 0; i < kBands; ++i)
        out[i] = at.rayleigh * m_rayleigh[i] + at.mie * m_mie_extinction[i] + at.ozone * m_ozone[i];
    return out;
}

// A landscape under its own haze: nearly grey, so that it stays a quiet backdrop.
const Spectrum& Atmosphere::ground_albedo() noexcept {
    static constexpr Spectrum kAlbedo = {0.24, 0.26, 0.27, 0.28, 0.28, 0.27,
                                         0.26, 0.25, 0.24, 0.24, 0.24};
    return kAlbedo;
}

Spectrum Atmosphere::transmittance(double height_m, double sine) const noexcept {
    const Spectrum depth =
        extinction(columns().at(height_m, sine, Columns::horizon_sine(height_m)));
    Spectrum out;
    for (std::size_t i = 0; i < kBands; ++i)
        out[i] = det::exp(-depth[i]);
    return out;
}

Spectrum Atmosphere::sunlight(double height_m, double sine) const noexcept {
    const double above = sine - Columns::horizon_sine(height_m);
    const double t = std::clamp(above / (2 * kSunRadius_rad) + 0.5, 0.0, 1.0);
    const double seen = t * t * (3 - 2 * t);
    if (seen <= 0)
        return {};
    Spectrum out = transmittance(height_m, sine);
    for (double& v : out)
        v *= seen;
    return out;
}

double rayleigh_phase(double c) noexcept {
    return 3 / (16 * det::kPi) * (1 + c * c);
}

double mie_phase(double c) noexcept {
    constexpr double g = kMieForward;
    constexpr double g2 = g * g;
    const double d = 1 + g2 - 2 * g * c;
    return 3 / (8 * det::kPi) * (1 - g2) * (1 + c * c) / ((2 + g2) * d * std::sqrt(d));
}

}  // namespace terravox::sky
