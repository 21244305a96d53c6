#include "raytracer/core/sky/atmosphere.hpp"

#include <random>

#include "tests/raytracer/core/sky/skies.hpp"

using namespace terravox;
using namespace terravox::test;

TEST_CASE("phase functions share out all light, none more", "[raytracer][sky][atmosphere]") {
    double rayleigh = 0;
    double mie = 0;
    double ahead = 0;
    over_sphere(400'000, -1, [&](core::Vec3 d, double sr) {
        rayleigh += sky::rayleigh_phase(d.y) * sr;
        mie += sky::mie_phase(d.y) * sr;
        ahead += sky::mie_phase(d.y) * sr * d.y;
    });
    CHECK(rayleigh == Approx(1).epsilon(1e-4));
    CHECK(mie == Approx(1).epsilon(1e-3));
    CHECK(ahead > 0.6);
}

TEST_CASE("the air above is as thick as published", "[raytracer][sky][atmosphere]") {
    // Turbidity 1 is air without haze. Vertical optical depth of molecules at 555 nm: 0.094 (Hansen
    // and Travis 1974); of ozone, 300 Dobson units, in the band at 600 nm: 0.038. The air mass at
    // the horizon is 38 (Kasten and Young 1989), for molecules 34 to 40.
    const sky::Atmosphere clean(1), hazy(3);
    const auto depth = [](const sky::Atmosphere& air, double sine, std::size_t band) {
        return -std::log(air.transmittance(0, sine)[band]);
    };
    CHECK(depth(clean, 1, 5) == Approx(0.094 + 0.029).epsilon(0.15));
    CHECK(depth(clean, 0, 1) / depth(clean, 1, 1) == Approx(38).epsilon(0.12));
    // Preetham's turbidity 3: beta 0.092, at 555 nm 0.198 of haze.
    CHECK(depth(hazy, 1, 5) - depth(clean, 1, 5) == Approx(0.198).epsilon(0.03));
    CHECK(depth(clean, 0.5, 5) / depth(clean, 1, 5) == Approx(2).epsilon(0.01));
}

TEST_CASE("light that comes down is never more than was sent, and less on a longer way",
          "[raytracer][sky][atmosphere]") {
    std::mt19937 random(21);
    const auto in = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    for (int i = 0; i < 3000; ++i) {
        const sky::Atmosphere air(in(1.5, 10));
        const double height = in(0, 1) < 0.5 ? in(0, 5000) : in(0, 100'000);
        const double sine = in(-0.1, 0.95);
        const sky::Spectrum low = air.sunlight(height, sine);
        const sky::Spectrum high = air.sunlight(height, sine + 0.05);
        for (std::size_t k = 0; k < sky::kBands; ++k) {
            INFO("height " << height << ", sine " << sine << ", band " << k);
            REQUIRE(low[k] >= 0);
            REQUIRE(high[k] <= 1);
            REQUIRE(low[k] <= high[k] + 1e-12);
        }
    }
}

TEST_CASE("the sun's light above the air is white, and paling keeps luminance",
          "[raytracer][sky][spectrum]") {
    const voxel::Colour sun = sky::to_rec709(sky::kSolarIrradiance);
    CHECK(sun.r == Approx(sun.g).epsilon(1e-4));
    CHECK(sun.b == Approx(sun.g).epsilon(1e-4));
    std::mt19937 random(22);
    std::uniform_real_distribution<float> any(-0.3f, 1);
    for (int i = 0; i < 5000; ++i) {
        const voxel::Colour c{any(random), any(random), any(random)};
        const voxel::Colour out = sky::in_gamut(c);
        INFO(c.r << " " << c.g << " " << c.b);
        REQUIRE(good(out));
        REQUIRE(voxel::luminance(out) == Approx(std::max(0.0f, voxel::luminance(c))).margin(1e-6));
    }
    const voxel::Colour inside{0.5f, 0.4f, 0.3f};
    CHECK(sky::in_gamut(inside).b == inside.b);
    CHECK(brightness(sky::in_gamut({-1, -1, -1})) == 0);
    CHECK(good(sky::in_gamut({std::nanf(""), 1, 1})));
}
