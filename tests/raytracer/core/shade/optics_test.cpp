#include "raytracer/core/shade/optics.hpp"

#include <numbers>
#include <random>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

core::Vec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return core::normalized({normal(random), normal(random), normal(random)});
}

bool near(core::Vec3 a, core::Vec3 b, double most) {
    return core::length(a - b) < most;
}

}  // namespace

TEST_CASE("Fresnel's share is that of the books", "[raytracer][shade][optics]") {
    CHECK(shade::fresnel(1, 1.5) == Approx(0.04).epsilon(1e-6));
    CHECK(shade::fresnel(1, 1 / 1.5) == Approx(0.04).epsilon(1e-6));
    CHECK(shade::fresnel(1, 1.333) == Approx(0.0203735).epsilon(1e-4));
    CHECK(shade::fresnel(0, 1.333) == Approx(1).epsilon(1e-12));
    CHECK(shade::fresnel(0.5, 1.0) == Approx(0).margin(1e-12));
    // Brewster's angle: only the s-polarised half is left.
    const double brewster = std::cos(std::atan(1.5));
    const double s = (1.5 * 1.5 - 1) / (1.5 * 1.5 + 1);
    CHECK(shade::fresnel(brewster, 1.5) == Approx(s * s / 2).epsilon(1e-9));
    CHECK(shade::fresnel(std::cos(50 * std::numbers::pi / 180), 1 / 1.333) ==
          1);  // beyond the critical angle of 48.6 degrees
    for (double c = 0.01; c < 1; c += 0.01) {
        const double sin_out = std::sqrt(1 - c * c) / 1.333;
        const double back = shade::fresnel(std::sqrt(1 - sin_out * sin_out), 1 / 1.333);
        REQUIRE(shade::fresnel(c, 1.333) ==
                Approx(back).epsilon(1e-9));  // the same from both sides
    }
}

TEST_CASE("refraction obeys Snell's law and can be undone", "[raytracer][shade][optics]") {
    std::mt19937 random(5);
    for (int i = 0; i < 2000; ++i) {
        const core::Vec3 n = random_direction(random);
        core::Vec3 d = random_direction(random);
        if (core::dot(d, n) > 0)
            d = -d;
        const double index = std::uniform_real_distribution<double>(0.5, 2.5)(random);
        const auto through = shade::refract(d, n, index);
        const double sin_in = core::length(core::cross(d, n));
        INFO("case " << i << ", index " << index);
        REQUIRE(through.has_value() == (sin_in / index < 1));
        if (!through)
            continue;
        REQUIRE(std::abs(core::length(*through) - 1) < 1e-9);
        REQUIRE(core::length(core::cross(*through, n)) * index == Approx(sin_in).margin(1e-7));
        REQUIRE(core::dot(*through, n) < 0);
        const auto back = shade::refract(-*through, -n, 1 / index);
        REQUIRE(back);
        REQUIRE(near(*back, -d, 1e-6));
    }
}
