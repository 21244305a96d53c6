#include "common/util/det_math.hpp"

#include <cmath>
#include <random>

#include "raytracer/shade/colour.hpp"
#include "tests/catch.hpp"

using namespace terravox;

namespace {

constexpr double kMostRelative = 1e-13;
double relative(double found, double wanted) { return wanted == 0 ? std::abs(found) : std::abs(found - wanted) / std::abs(wanted); }

}  // namespace

TEST_CASE("exp, log and pow are those of the C library to 13 digits", "[common][util][det_math]") {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> wide(-690, 690), small(-1, 1);
    double worst = 0, at = 0;
    const auto note = [&](double found, double wanted, double x) {
        if (const double r = relative(found, wanted); !(r <= worst)) worst = r, at = x;
    };
    SECTION("exp") {
        for (int i = 0; i < 200'000; ++i) {
            const double x = i % 2 == 0 ? wide(random) : small(random);
            note(det::exp(x), std::exp(x), x);
        }
        INFO("worst at x = " << at);
        CHECK(worst < kMostRelative);
    }
    SECTION("log") {
        for (int i = 0; i < 200'000; ++i) {
            const double x = std::exp(wide(random));
            // Near 1 the logarithm itself is near 0: there the error counts against the rounding of x.
            if (std::abs(x - 1) > 0.01) note(det::log(x), std::log(x), x);
        }
        INFO("worst at x = " << at);
        CHECK(worst < kMostRelative);
        CHECK(det::log(1) == 0);
    }
    SECTION("pow, as colours use it") {
        for (int i = 0; i < 200'000; ++i) {
            const double x = 1e-6 + 2 * std::abs(small(random)), y = i % 2 == 0 ? 2.4 : 1 / 2.4;
            note(det::pow(x, y), std::pow(x, y), x);
        }
        INFO("worst at x = " << at);
        CHECK(worst < kMostRelative);
    }
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
        const float linear = srgb_to_linear(static_cast<std::uint8_t>(v));
        CHECK(linear > last);
        last = linear;
        CHECK(std::lround(linear_to_srgb(linear) * 255) == v);
    }
    CHECK(linear_to_srgb(-1) == 0);
    CHECK(linear_to_srgb(std::nanf("")) == 0);
    CHECK(linear_to_srgb(7) == 1);
}
