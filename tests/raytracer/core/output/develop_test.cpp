#include "raytracer/core/output/develop.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/scene_words_text.hpp"

using namespace terravox;

namespace {

double to_display(double v) {
    return v <= 0           ? 0
           : v >= 1         ? 1
           : v <= 0.0031308 ? v * 12.92
                            : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
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

TEST_CASE("curves are what their descriptions say", "[raytracer][output]") {
    for (double stop = -9; stop < 6; stop += 0.01) {
        const double c = std::exp2(stop);
        const auto v = static_cast<float>(c);
        CHECK(output::develop({0, v, 0}, 0, core::ToneCurve::kPhotographic).g ==
              Approx(to_display(1 - std::exp(-1.15 * c))).margin(1e-4));
        CHECK(output::develop({0, 0, v}, 0, core::ToneCurve::kLinear).b ==
              Approx(to_display(c)).margin(1e-4));
    }
    struct Case {
        voxel::Colour light;
        std::array<double, 3> shown;
    };
    // Rec. 709 primaries a fifth of the way to white, 10 stops below middle grey and 6.5 above it,
    // a sigmoid of slope 2 through (10 / 16.5, 0.5) with the powers 3 and 3.25, and back. Ref:
    // SMPTE RP 177.
    for (const Case& c : {Case{{0.18f, 0.18f, 0.18f}, {0.50387, 0.50387, 0.50387}},
                          Case{{1, 1, 1}, {0.79253, 0.79253, 0.79253}},
                          Case{{0.02f, 0.005f, 0.001f}, {0.13528, 0.02021, 0}},
                          Case{{4, 0.5f, 0.1f}, {0.97032, 0.71552, 0.55238}},
                          Case{{0.1f, 0.3f, 2}, {0.5227, 0.63387, 0.89645}},
                          Case{{0.05f, 20, 0.4f}, {0.84015, 1, 0.86288}}}) {
        INFO(c.light.r << " " << c.light.g << " " << c.light.b);
        const voxel::Colour found = output::develop(c.light, 0, core::ToneCurve::kAgx);
        CHECK(found.r == Approx(c.shown[0]).margin(5e-4));
        CHECK(found.g == Approx(c.shown[1]).margin(5e-4));
        CHECK(found.b == Approx(c.shown[2]).margin(5e-4));
    }
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
