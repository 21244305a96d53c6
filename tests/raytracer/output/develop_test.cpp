#include "raytracer/output/develop.hpp"

#include <cmath>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/scene_words_text.hpp"

using namespace terravox;

namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

Matrix times(const Matrix& a, const Matrix& b) {
    Matrix out{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k)
                out[i][j] += a[i][k] * b[k][j];
    return out;
}

Matrix inverse(const Matrix& m) {
    Matrix out{};
    const auto minor = [&](std::size_t i, std::size_t j) {
        return m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3] -
               m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3];
    };
    const double determinant =
        m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            out[j][i] = minor(i, j) / determinant;
    return out;
}

/// To XYZ from Rec. 709 primaries that are moved towards white by a share of the way. Ref: SMPTE RP
/// 177.
Matrix to_xyz(double inset) {
    constexpr std::array<double, 2> white = {0.3127, 0.3290};
    constexpr std::array<std::array<double, 2>, 3> primaries = {
        {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}}};
    Matrix m{};
    for (std::size_t p = 0; p < 3; ++p) {
        const double x = std::lerp(primaries[p][0], white[0], inset);
        const double y = std::lerp(primaries[p][1], white[1], inset);
        m[0][p] = x / y;
        m[1][p] = 1;
        m[2][p] = (1 - x - y) / y;
    }
    const Matrix back = inverse(m);
    const std::array<double, 3> white_xyz = {white[0] / white[1], 1,
                                             (1 - white[0] - white[1]) / white[1]};
    for (std::size_t p = 0; p < 3; ++p) {
        double scale = 0;
        for (std::size_t k = 0; k < 3; ++k)
            scale += back[p][k] * white_xyz[k];
        for (std::size_t row = 0; row < 3; ++row)
            m[row][p] *= scale;
    }
    return m;
}

std::array<double, 3> through(const Matrix& m, const std::array<double, 3>& v) {
    std::array<double, 3> out{};
    for (std::size_t i = 0; i < 3; ++i)
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return out;
}

double to_display(double v) {
    return v <= 0           ? 0
           : v >= 1         ? 1
           : v <= 0.0031308 ? v * 12.92
                            : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

/// The agx curve once more, straight from its description.
std::array<double, 3> agx(std::array<double, 3> c) {
    const Matrix inset = times(inverse(to_xyz(0)), to_xyz(0.2));
    c = through(inset, c);
    for (double& v : c) {
        const double x = std::clamp((std::log2(std::max(v, 1e-12) / 0.18) + 10) / 16.5, 0.0, 1.0);
        const double pivot = 10 / 16.5;
        const double run = std::abs(x - pivot);
        const double whole = x < pivot ? pivot : 1 - pivot;
        const double power = x < pivot ? 3 : 3.25;
        const double scale = std::pow(
            std::pow(2 * whole, -power) * (std::pow(2 * whole / 0.5, power) - 1), -1 / power);
        const double u = 2 * run / scale;
        v = std::pow(
            0.5 + (x < pivot ? -1 : 1) * scale * u / std::pow(1 + std::pow(u, power), 1 / power),
            2.2);
    }
    c = through(inverse(inset), c);
    for (double& v : c)
        v = to_display(v);
    return c;
}

/// Hue in degrees and chroma. Ref: Ottosson, "A perceptual color space for image processing"
/// (Oklab), 2020.
std::array<double, 2> hue_of(voxel::Colour display) {
    const auto linear = [](double v) {
        return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    };
    const double r = linear(display.r);
    const double g = linear(display.g);
    const double b = linear(display.b);
    const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    const double u = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s;
    const double v = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s;
    return {std::atan2(v, u) * 57.29577951, std::hypot(u, v)};
}

/// How far the hue wanders while a saturated colour gets from dim to very bright, degrees, the
/// worst of colours all around.
double worst_drift(core::ToneCurve tone) {
    double worst = 0;
    for (int k = 0; k < 36; ++k) {
        const auto part = [&](double at) {
            return static_cast<float>(
                0.03 +
                0.97 * std::clamp(1.5 - std::abs(std::remainder(k / 6.0 - at, 6.0)), 0.0, 1.0));
        };
        const voxel::Colour base = {part(0), part(2), part(4)};
        const double first = hue_of(output::develop(base * 0.25f, 0, tone))[0];
        for (float bright = 0.25f; bright < 20; bright *= 1.4f) {
            const auto [hue, chroma] = hue_of(output::develop(base * bright, 0, tone));
            if (chroma > 0.03)
                worst = std::max(worst, std::abs(std::remainder(hue - first, 360.0)));
        }
    }
    return worst;
}

}  // namespace

TEST_CASE(
    "developing keeps black black and greys grey, never leaves [0, 1], and never gets darker with "
    "more light",
    "[raytracer][output]") {
    const auto tone(GENERATE(core::ToneCurve::kPhotographic, core::ToneCurve::kFilmic,
                             core::ToneCurve::kAgx, core::ToneCurve::kLinear));
    INFO(tone);
    const output::Developer developed(0, tone);
    CHECK(developed({}).r == 0);
    float last = 0;
    int wrong = 0;
    for (float c = 1e-9f; c < 1e9f; c *= 1.0003f) {
        const voxel::Colour d = developed({c, c, c});
        if (!(d.r >= last && d.r <= 1 && d.g == d.r && d.b == d.r) && ++wrong == 1)
            FAIL_CHECK("first at " << c << ": " << d.r << " " << d.g << " " << d.b << " after "
                                   << last);
        last = d.r;
    }
    CHECK(last == 1);
    CHECK(developed({0.1f, 0.1f, 0.1f}).r < output::develop({0.1f, 0.1f, 0.1f}, 1, tone).r);
    const float far = std::numeric_limits<float>::infinity();
    const float none = std::numeric_limits<float>::quiet_NaN();
    for (const voxel::Colour odd : {voxel::Colour{far, 0, 0},
                                    {none, 1, 1},
                                    {-1, -far, 2},
                                    {1e38f, far, 1e-38f},
                                    {3e38f, 1, -3e38f}}) {
        const voxel::Colour d = developed(odd);
        INFO(odd.r << " " << odd.g << " " << odd.b << " -> " << d.r << " " << d.g << " " << d.b);
        for (const float v : {d.r, d.g, d.b})
            CHECK((v >= 0 && v <= 1));
    }
}

TEST_CASE("an exposure of one stop is twice the light", "[raytracer][output]") {
    const auto tone(GENERATE(core::ToneCurve::kPhotographic, core::ToneCurve::kFilmic,
                             core::ToneCurve::kAgx, core::ToneCurve::kLinear));
    for (const float c : {0.01f, 0.2f, 0.9f})
        CHECK(output::develop({c, c, c}, 1, tone).g ==
              Approx(output::develop({2 * c, 2 * c, 2 * c}, 0, tone).g).margin(1e-6));
}

TEST_CASE("tone curves show middle grey and white walls about alike", "[raytracer][output]") {
    const auto tone =
        GENERATE(core::ToneCurve::kPhotographic, core::ToneCurve::kFilmic, core::ToneCurve::kAgx);
    INFO(tone);
    CHECK(output::develop({0.18f, 0.18f, 0.18f}, 0, tone).g == Approx(0.48).margin(0.03));
    CHECK(output::develop({1, 1, 1}, 0, tone).g == Approx(0.81).margin(0.04));
}

TEST_CASE("curves are what their descriptions say", "[raytracer][output]") {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> stops(-9, 6);
    double worst_photographic = 0;
    double worst_agx = 0;
    double worst_linear = 0;
    for (int i = 0; i < 20'000; ++i) {
        const std::array<double, 3> c = {std::exp2(stops(random)), std::exp2(stops(random)),
                                         std::exp2(stops(random))};
        const voxel::Colour light = {static_cast<float>(c[0]), static_cast<float>(c[1]),
                                     static_cast<float>(c[2])};
        const auto expected = agx(c);
        const voxel::Colour a = output::develop(light, 0, core::ToneCurve::kAgx);
        const voxel::Colour p = output::develop(light, 0, core::ToneCurve::kPhotographic);
        const voxel::Colour l = output::develop(light, 0, core::ToneCurve::kLinear);
        worst_agx = std::max({worst_agx, std::abs(a.r - expected[0]), std::abs(a.g - expected[1]),
                              std::abs(a.b - expected[2])});
        worst_photographic =
            std::max(worst_photographic, std::abs(p.g - to_display(1 - std::exp(-1.15 * c[1]))));
        worst_linear = std::max(worst_linear, std::abs(l.b - to_display(c[2])));
    }
    CHECK(worst_photographic < 1e-4);
    CHECK(worst_linear < 1e-4);
    CHECK(worst_agx < 5e-4);
}

TEST_CASE("agx lets bright colours pale and keeps their hue", "[raytracer][output]") {
    const double agx_drift = worst_drift(core::ToneCurve::kAgx);
    const double photographic_drift = worst_drift(core::ToneCurve::kPhotographic);
    CAPTURE(agx_drift, photographic_drift);
    CHECK(agx_drift < 35);
    CHECK(agx_drift < 0.6 * photographic_drift);
    CHECK(hue_of(output::develop({20, 0.4f, 0.4f}, 0, core::ToneCurve::kAgx))[1] <
          0.5 * hue_of(output::develop({1, 0.02f, 0.02f}, 0, core::ToneCurve::kAgx))[1]);
}

TEST_CASE(
    "dithering gives the right mean, moves nothing by a whole step, and leaves whole bytes alone",
    "[raytracer][output]") {
    const float value =
        GENERATE(0.0f, 0.1f / 255, 17.3f / 255, 0.5f, 200.5f / 255, 254.9f / 255, 1.0f);
    INFO(value * 255);
    double sum = 0;
    int wrong = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 200; ++x) {
            const auto bytes = output::dithered_bytes({value, value, value}, x, y);
            wrong += std::abs(static_cast<float>(bytes[0]) - value * 255) >= 1 ||
                             bytes[0] != bytes[1] || bytes[0] != bytes[2]
                         ? 1
                         : 0;
            sum += bytes[0];
        }
    CHECK(wrong == 0);
    CHECK(sum / 40'000 == Approx(value * 255).margin(0.01));
    for (int b = 0; b < 256; ++b)
        CHECK(output::dithered_bytes({static_cast<float>(b) / 255, 0, 1}, b * 7, b) ==
              std::array<std::uint8_t, 3>{static_cast<std::uint8_t>(b), 0, 255});
}
