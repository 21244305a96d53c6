#include "raytracer/core/output/develop.hpp"

#include <bit>
#include <cmath>

#include "common/util/det_math.hpp"
#include "raytracer/core/base/random.hpp"

namespace terravox::output {

/// A curve from light in [0, infinity) to [0, 1] by straight lines between places that are equally
/// far apart in the bits of a float: 128 in each octave. Never falls, if the curve does not.
class ToneTable {
public:
    template <class Curve>
    explicit ToneTable(const Curve& curve) {
        for (std::size_t i = 0; i < m_values.size(); ++i) {
            const double value = curve(static_cast<double>(
                std::bit_cast<float>(kFirst + (static_cast<std::uint32_t>(i) << kShift))));
            // Steps of 2^-22 make the differences below exact, so that rounding cannot make a line
            // end above its upper end.
            m_values[i] = static_cast<float>(std::floor(value * kSteps + 0.5) / kSteps);
        }
    }
    [[nodiscard]] float operator()(float c) const noexcept {
        if (!(c > 0))
            return 0;
        const auto bits = std::bit_cast<std::uint32_t>(c);
        if (bits < kFirst)
            return m_values[0] * (c * kPerFirst);
        if (bits >= kLast)
            return m_values.back();
        const std::uint32_t at = bits - kFirst;
        const std::uint32_t i = at >> kShift;
        const float part = static_cast<float>(at & kMask) * (1.0f / (kMask + 1));
        return m_values[i] + (m_values[i + 1] - m_values[i]) * part;
    }

private:
    static constexpr int kShift = 23 - 7;
    static constexpr std::uint32_t kMask = (1u << kShift) - 1;
    static constexpr float kMin = 0x1p-18f;
    static constexpr float kMax = 0x1p8f;
    static constexpr float kPerFirst = 0x1p18f;
    static constexpr std::uint32_t kFirst = std::bit_cast<std::uint32_t>(kMin);
    static constexpr std::uint32_t kLast = std::bit_cast<std::uint32_t>(kMax);
    static constexpr double kSteps = 1 << 22;
    std::array<float, ((kLast - kFirst) >> kShift) + 1> m_values{};
};

namespace {

double to_srgb(double linear) noexcept {
    if (linear >= 1)
        return 1;
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * det::pow(linear, 1 / 2.4) - 0.055;
}

const ToneTable& linear_table() {
    static const ToneTable table(to_srgb);
    return table;
}

const ToneTable& photographic_table() {
    static const ToneTable table([](double c) { return to_srgb(1 - det::exp(-c)); });
    return table;
}

// Ref: Hable 2010: shoulder, linear part and toe as one fraction, with the constants that he gives.
// White is what comes out for 11.2.
const ToneTable& filmic_table() {
    static const ToneTable table([](double c) {
        const auto curve = [](double x) {
            return (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
        };
        return to_srgb(std::min(1.0, std::max(0.0, curve(c)) / curve(11.2)));
    });
    return table;
}

// Ref: Sobotka 2022: light as log2 over the range of stops, then a sigmoid of a given slope through
// a pivot, whose toe and shoulder are scaled to reach 0 and 1 at the ends of the range. What comes
// out is meant for a display of gamma 2.2; here it is made linear again.
const ToneTable& agx_table() {
    static const ToneTable table([](double c) {
        constexpr double kMiddleGrey = 0.18;
        constexpr double kStopsBelow = 10;
        constexpr double kStopsAbove = 6.5;
        constexpr double kSlope = 2;
        constexpr double kToe = 3;
        constexpr double kShoulder = 3.25;
        constexpr double kLn2 = 0.693147180559945309417;
        constexpr double kPivotX = kStopsBelow / (kStopsBelow + kStopsAbove);
        constexpr double kPivotY = 0.5;
        const double x =
            std::min(1.0, std::max(0.0, (det::log(c / kMiddleGrey) / kLn2 + kStopsBelow) /
                                            (kStopsBelow + kStopsAbove)));
        // One half of the sigmoid: `run` from the pivot, of `whole`, rises by `height` at the
        // whole.
        const auto half = [&](double run, double whole, double height, double power) {
            // Above 1: a straight line would leave the range.
            const double reach = kSlope * whole / height;
            const double scale = height * det::pow(1 - det::pow(reach, -power), -1 / power);
            const double u = kSlope * run / scale;
            return scale * u / det::pow(1 + det::pow(u, power), 1 / power);
        };
        const double y = x < kPivotX
                             ? kPivotY - half(kPivotX - x, kPivotX, kPivotY, kToe)
                             : kPivotY + half(x - kPivotX, 1 - kPivotX, 1 - kPivotY, kShoulder);
        return det::pow(std::min(1.0, std::max(0.0, y)), 2.2);
    });
    return table;
}

/// Light that goes from each primary to the two others: what a matrix does that keeps greys and
/// whose rows are alike but for the diagonal.
struct Exchange {
    float r;
    float g;
    float b;
    // By differences, which are exactly 0 for greys.
    [[nodiscard]] voxel::Colour operator()(voxel::Colour c) const noexcept {
        return {c.r + (g * (c.g - c.r) + b * (c.b - c.r)),
                c.g + (r * (c.r - c.g) + b * (c.b - c.g)),
                c.b + (r * (c.r - c.b) + g * (c.g - c.b))};
    }
};

// Rec. 709 primaries moved a fifth of the way towards white on the chromaticity diagram, white
// kept, as seen in Rec. 709; and the way back (tests/raytracer/core/output/develop_test.cpp makes
// both from the chromaticities).
constexpr Exchange kInset = {0.04239893f, 0.07843017f, 0.07917091f};
constexpr Exchange kOutset = {-0.05299866f, -0.09803771f, -0.09896363f};

// Light before the curve: at exposure 0 a white wall in the sun lands at four fifths of the
// display's range, and middle grey within a quarter of a stop of where the photographic curve takes
// it.
constexpr double kPhotographicScale = 1.15;
constexpr double kFilmicScale = 3.06;
constexpr double kAgxScale = 1;

}  // namespace

Developer::Developer(double exposure_ev, core::ToneCurve tone)
    : m_agx(tone == core::ToneCurve::kAgx) {
    constexpr double kLn2 = 0.693147180559945309417;
    double scale = 1;
    switch (tone) {
        case core::ToneCurve::kPhotographic:
            m_curve = &photographic_table();
            scale = kPhotographicScale;
            break;
        case core::ToneCurve::kFilmic:
            m_curve = &filmic_table();
            scale = kFilmicScale;
            break;
        case core::ToneCurve::kAgx:
            m_curve = &agx_table();
            scale = kAgxScale;
            break;
        case core::ToneCurve::kLinear: m_curve = &linear_table(); break;
    }
    m_scale = static_cast<float>(scale * det::exp(exposure_ev * kLn2));
}

voxel::Colour Developer::operator()(voxel::Colour linear) const noexcept {
    // Below the most that a float holds, so that no difference of two primaries is infinite minus
    // infinite.
    const auto scaled = [&](float v) { return v > 0 ? std::min(v * m_scale, 1e30f) : 0; };
    voxel::Colour c = {scaled(linear.r), scaled(linear.g), scaled(linear.b)};
    if (!m_agx)
        return {(*m_curve)(c.r), (*m_curve)(c.g), (*m_curve)(c.b)};
    c = kInset(c);
    c = kOutset({(*m_curve)(c.r), (*m_curve)(c.g), (*m_curve)(c.b)});
    const ToneTable& display = linear_table();
    return {display(c.r), display(c.g), display(c.b)};
}

voxel::Colour develop(voxel::Colour linear, double exposure_ev, core::ToneCurve tone) {
    return Developer(exposure_ev, tone)(linear);
}

std::array<std::uint8_t, 3> dithered_bytes(voxel::Colour display, int x, int y) noexcept {
    const std::uint64_t place = static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32 |
                                static_cast<std::uint32_t>(x);
    const float threshold = static_cast<float>(core::hash64(place) >> 40) * 0x1p-24f;  // [0, 1)
    const auto byte = [&](float v) {
        return static_cast<std::uint8_t>(std::min(v * 255 + threshold, 255.0f));
    };
    return {byte(display.r), byte(display.g), byte(display.b)};
}

std::vector<std::uint8_t> developed_bytes(const Film& film, const PictureInfo& info, int channels) {
    const int width = film.width_px();
    const int height = film.height_px();
    const PixelBytes make(info, width, height);
    std::vector<std::uint8_t> out(static_cast<std::size_t>(width) *
                                  static_cast<std::size_t>(height) *
                                  static_cast<std::size_t>(channels));
    std::uint8_t* to = out.data();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x, to += channels) {
            if (channels == 4)
                make.put_with_alpha(film.at(x, y), x, y, to);
            else
                make.put(film.at(x, y), x, y, to);
        }
    return out;
}

}  // namespace terravox::output
