#include "raytracer/core/sky/spectrum.hpp"

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

}  // namespace terravox::sky
