#include <cmath>
#include <random>

#include "common/util/det_math.hpp"
#include "common/util/linear_light.hpp"
#include "common/voxel/colour.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::util;

namespace {

constexpr double kMaxRelative = 1e-14;
double relative(double found, double wanted) {
    return wanted == 0 ? std::abs(found) : std::abs(found - wanted) / std::abs(wanted);
}

}  // namespace

TEST_CASE("exp, log and pow are those of the C library to 14 digits", "[common][util][det_math]") {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> wide(-690, 690), small(-1, 1);
    double worst = 0;
    double at = 0;
    const auto note = [&](double found, double wanted, double x) {
        if (const double r = relative(found, wanted); !(r <= worst)) {
            worst = r;
            at = x;
        }
    };
    SECTION("exp") {
        for (int i = 0; i < 200'000; ++i) {
            const double x = i % 2 == 0 ? wide(random) : small(random);
            note(det::exp(x), std::exp(x), x);
        }
        INFO("worst at x = " << at);
        CHECK(worst < kMaxRelative);
    }
    SECTION("log") {
        for (int i = 0; i < 200'000; ++i) {
            const double x = std::exp(wide(random));
            // Near 1 the logarithm itself is near 0: there the error counts against the rounding of
            // x.
            if (std::abs(x - 1) > 0.01)
                note(det::log(x), std::log(x), x);
        }
        INFO("worst at x = " << at);
        CHECK(worst < kMaxRelative);
        CHECK(det::log(1) == 0);
    }
    SECTION("pow, as colours use it") {
        for (int i = 0; i < 200'000; ++i) {
            const double x = 1e-6 + 2 * std::abs(small(random));
            const double y = i % 2 == 0 ? 2.4 : 1 / 2.4;
            note(det::pow(x, y), std::pow(x, y), x);
        }
        INFO("worst at x = " << at);
        CHECK(worst < kMaxRelative);
    }
}

TEST_CASE("sine, cosine and their inverses are those of the C library",
          "[common][util][det_math]") {
    std::mt19937_64 random(12);
    double worst = 0;
    double at_x = 0;
    double at_y = 0;
    const auto note = [&](double found, double wanted, double x, double y = 0) {
        if (const double r = std::abs(found - wanted); !(r <= worst)) {
            worst = r;
            at_x = x;
            at_y = y;
        }
    };
    const auto in = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    for (int i = 0; i < 300'000; ++i) {
        const double x = i % 3 == 0   ? in(-1e5, 1e5)
                         : i % 3 == 1 ? in(-7, 7)
                                      : std::round(in(-200, 200)) * det::kPi / 4;
        const det::SinCos both = det::sin_cos(x);
        note(both.sin, std::sin(x), x);
        note(both.cos, std::cos(x), x);
        const double y = i % 2 == 0 ? in(-2, 2) : in(-1e-9, 1e-9);
        const double w = i % 5 == 0 ? 0 : in(-2, 2);
        note(det::atan2(y, w), std::atan2(y, w), y, w);
        const double c = i % 2 == 0 ? in(-1, 1) : 1 - std::abs(in(0, 1e-9));
        note(det::acos(c), std::acos(c), c);
        note(det::asin(c), std::asin(c), c);
    }
    INFO("worst at " << at_x << ", " << at_y);
    CHECK(worst < 2e-15);
}

TEST_CASE("angles small enough to matter keep their digits", "[common][util][det_math]") {
    std::mt19937_64 random(13);
    double worst = 0;
    double at = 0;
    for (int i = 0; i < 100'000; ++i) {
        const double x = std::ldexp(std::uniform_real_distribution<double>(0.5, 1)(random),
                                    -static_cast<int>(random() % 60));
        for (const double r :
             {relative(det::sin(x), std::sin(x)), relative(det::tan(x), std::tan(x)),
              relative(det::atan2(x, 1), std::atan(x))})
            if (!(r <= worst)) {
                worst = r;
                at = x;
            }
    }
    INFO("worst at " << at);
    CHECK(worst < kMaxRelative);
}

TEST_CASE("the ends of the angles are where they are said to be", "[common][util][det_math]") {
    CHECK(det::sin(0) == 0);
    CHECK(det::cos(0) == 1);
    CHECK(det::sin(std::nan("")) == 0);
    CHECK(det::cos(1e300) == 1);
    CHECK(det::atan2(0, 0) == 0);
    CHECK(det::atan2(std::nan(""), 1) == 0);
    CHECK(det::atan2(0, -1) == det::kPi);
    CHECK(det::acos(1) == 0);
    CHECK(det::acos(2) == 0);
    CHECK(det::acos(-1) == det::kPi);
    CHECK(det::acos(-1.5) == det::kPi);
    CHECK(det::acos(std::nan("")) == 0);
    CHECK(det::asin(1) == det::kPi / 2);
}

TEST_CASE("the ends of exp and pow are where they are said to be", "[common][util][det_math]") {
    CHECK(det::exp(0) == 1);
    CHECK(det::exp(-701) == 0);
    CHECK(det::exp(-1e300) == 0);
    CHECK(det::exp(1e300) == det::exp(700));
    CHECK(std::isfinite(det::exp(700)));
    CHECK(det::exp(std::nan("")) == 0);
    CHECK(det::pow(0, 2) == 0);
    CHECK(det::pow(0, 0) == 1);
    CHECK(det::exp2_int(-1022) == std::ldexp(1.0, -1022));
    CHECK(det::exp2_int(1023) == std::ldexp(1.0, 1023));
}

TEST_CASE("sRGB there and back gives every byte again", "[raytracer][shade][colour]") {
    float last = -1;
    for (int v = 0; v < 256; ++v) {
        INFO(v);
        const float linear = voxel::srgb_to_linear(static_cast<std::uint8_t>(v));
        CHECK(linear > last);
        last = linear;
        CHECK(std::lround(voxel::linear_to_srgb(linear) * 255) == v);
    }
    CHECK(voxel::linear_to_srgb(-1) == 0);
    CHECK(voxel::linear_to_srgb(std::nanf("")) == 0);
    CHECK(voxel::linear_to_srgb(7) == 1);
}

TEST_CASE("every sRGB value comes back from linear light", "[map][linear]") {
    for (int v = 0; v < 256; ++v)
        CHECK(to_srgb(to_linear(static_cast<std::uint8_t>(v))) == v);
    CHECK(to_linear(0) == 0);
    CHECK(to_linear(255) == kBrightest);
    CHECK(to_srgb(kBrightest + 1) == 255);
    CHECK(to_srgb(0xffffffffU) == 255);
}

TEST_CASE("linear light becomes the nearest sRGB value", "[map][linear]") {
    int wrong = 0;
    int last = 0;
    for (std::uint32_t linear = 0; linear <= kBrightest; ++linear) {
        const double c = linear / 65535.0;
        const double exact =
            255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055);
        const int value = to_srgb(linear);
        wrong += std::abs(value - exact) > 0.53 || value < last ? 1 : 0;
        last = value;
    }
    CHECK(wrong == 0);
}
