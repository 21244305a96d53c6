#include "raytracer/analyse/solar/sky_light.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

namespace {

using namespace terravox;
using namespace terravox::solar;

/// Light of the sky on a plane that nothing stands in front of.
double on_plane(const SkyLight& light, double tilt_deg, double cosine_to_sun) {
    constexpr double kRad = 0.017453292519943295;
    return light.isotropic * (1 + std::cos(tilt_deg * kRad)) / 2 +
           light.around_sun * std::max(cosine_to_sun, 0.0) +
           light.horizon * std::sin(tilt_deg * kRad);
}

}  // namespace

TEST_CASE("light of the sky on tilted planes is that of a reference", "[raytracer][solar]") {
    // Made with pvlib 0.16.1: irradiance.perez, air mass by Kasten and Young.
    struct Case {
        double altitude_deg, beam, diffuse, extraterrestrial, tilt_deg, cosine_to_sun, expected;
    };
    const Case cases[] = {
        {29.8788389, 0, 142.964778, 1338.50079, 83.8090679, -0.29808501, 65.4006417},
        {61.8440182, 0, 173.306081, 1348.06256, 16.3634487, 0.912318876, 167.301296},
        {56.9393498, 0, 319.980513, 1322.72654, 40.5755905, 0.53305535, 260.88927},
        {57.7518538, 731.858376, 248.458623, 1321.28503, 10.0177717, 0.855956425, 255.530775},
        {50.5812735, 0, 35.7680565, 1363.20523, 76.9528665, 0.266328661, 19.3884469},
        {12.3454439, 19.307215, 188.926178, 1370.48537, 81.4965326, -0.765468533, 69.8326118},
        {6.69655944, 0, 130.92265, 1388.59243, 40.9399341, -0.45982311, 71.7808532},
        {67.0284959, 0, 236.218519, 1406.72089, 46.64473, 0.395897285, 182.371257},
        {45.1130069, 701.02372, 344.51112, 1380.61497, 2.8996637, 0.720175737, 348.073203},
        {49.6205042, 529.886686, 325.352275, 1338.39307, 48.8388577, 0.848468163, 334.85706},
    };
    for (const Case& c : cases) {
        INFO("altitude " << c.altitude_deg << ", tilt " << c.tilt_deg);
        const SkyLight light = perez_light({c.beam, c.diffuse}, c.altitude_deg, c.extraterrestrial);
        CHECK(on_plane(light, c.tilt_deg, c.cosine_to_sun) == Approx(c.expected).epsilon(1e-3));
    }
}

TEST_CASE("a level surface gets the light that the sky sends", "[raytracer][solar]") {
    for (const double altitude_deg : {6.0, 20.0, 45.0, 80.0})
        for (const double beam : {0.0, 100.0, 500.0, 900.0}) {
            const Irradiance light{beam, 120};
            const double sine = std::sin(altitude_deg * 0.017453292519943295);
            CHECK(on_plane(isotropic_light(light), 0, sine) == Approx(120));
            CHECK(on_plane(perez_light(light, altitude_deg, 1361), 0, sine) == Approx(120));
        }
    CHECK(perez_light({800, 0}, 30, 1361).isotropic == 0);
}

TEST_CASE("hazier air takes beam and gives diffuse light", "[raytracer][solar]") {
    for (const double altitude_deg : {2.0, 10.0, 30.0, 60.0, 90.0}) {
        INFO(altitude_deg);
        Irradiance before = clear_sky(altitude_deg, 1.5, 0, 172);
        CHECK(before.beam < extraterrestrial_w_m2(172));
        for (const double linke : {2.0, 3.0, 4.0, 5.0}) {
            const Irradiance now = clear_sky(altitude_deg, linke, 0, 172);
            CHECK(now.beam < before.beam);
            CHECK((altitude_deg < 5 || now.diffuse > before.diffuse));
            CHECK(now.beam >= 0);
            CHECK(now.diffuse >= 0);
            before = now;
        }
        // On mountains there is less air.
        CHECK(clear_sky(altitude_deg, 3, 2000, 172).beam > clear_sky(altitude_deg, 3, 0, 172).beam);
    }
    // The Earth is nearest to the sun in early January.
    CHECK(extraterrestrial_w_m2(3) == Approx(1367 * 1.0334).epsilon(1e-3));
    CHECK(extraterrestrial_w_m2(185) == Approx(1367 * 0.9666).epsilon(1e-3));
}

TEST_CASE("turbidities are one number or twelve", "[raytracer][solar]") {
    CHECK(parse_linke("3.5")[0] == 3.5);
    CHECK(parse_linke("3.5")[11] == 3.5);
    const auto months = parse_linke("2,2,3,3,4,4,4.5,4,3,3,2,2");
    CHECK(months[6] == 4.5);
    CHECK(months[11] == 2);
    for (const char* text :
         {"", "0.5", "11", "3,", "3,4", "nan", "3 4", "x", "2,2,3,3,4,4,4,4,3,3,2",
          "2,2,3,3,4,4,4,4,3,3,2,2,2", "2,2,3,3,4,4,4,4,3,3,2,2,"}) {
        INFO("'" << text << "'");
        CHECK_THROWS_AS(parse_linke(text), util::UsageError);
        CHECK_THROWS_WITH(parse_linke(text), terravox::test::contains("analysis.linke"));
    }
}
