#include <fstream>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/analyse/solar/energy.hpp"
#include "raytracer/analyse/solar/light_sums.hpp"
#include "raytracer/analyse/solar/weather.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/analyse/solar/epw_text.hpp"

namespace {

using namespace terravox;
using namespace terravox::solar;
using test::EpwLight;
using test::TemporaryFolder;

constexpr double kRad = 0.017453292519943295;

WeatherFile read(const std::string& text) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "town.epw";
    std::ofstream(file, std::ios::binary) << text;
    return read_weather(file);
}

scene::Scene year() {
    scene::Scene out;
    out.analysis.kind = core::AnalysisKind::kEnergy;
    out.analysis.from = "2026-01-01";
    out.analysis.to = "2026-12-31";
    out.analysis.step_min = 60;
    out.sun.utc_offset_h = 1;
    return out;
}

struct OnPlane {
    double beam = 0;
    double diffuse = 0;
};

OnPlane on_plane(const Energy& light, double tilt_deg, double azimuth_deg) {
    const core::Vec3 normal{std::sin(tilt_deg * kRad) * std::sin(azimuth_deg * kRad),
                            std::cos(tilt_deg * kRad),
                            -std::sin(tilt_deg * kRad) * std::cos(azimuth_deg * kRad)};
    OnPlane out;
    out.diffuse = light.isotropic * (1 + normal.y) / 2 + light.horizon * std::sin(tilt_deg * kRad);
    for (const LightDirection& from : light.sun) {
        const double cosine = std::max(0.0, core::dot(normal, from.to));
        out.beam += from.beam * cosine;
        out.diffuse += from.around_sun * cosine;
    }
    return out;
}

/// The text with one line changed.
std::string with_line(const std::string& text, int number, const std::string& line) {
    std::size_t begin = 0;
    for (int i = 1; i < number; ++i)
        begin = text.find('\n', begin) + 1;
    std::string out = text;
    out.replace(begin, text.find('\n', begin) - begin, line);
    return out;
}

}  // namespace

TEST_CASE("a year of weather on tilted planes is that of a reference", "[raytracer][solar]") {
    // Made with pvlib 0.16.1 of the same file: read_epw, the sun in the middle of each hour,
    // irradiance.perez; where it is below the horizon the sky's light is even.
    struct Plane {
        double tilt_deg, azimuth_deg, beam, perez, isotropic;
    };
    const Plane planes[] = {
        {0, 180, 605.9792, 437.6723, 437.8790},  {30, 180, 758.2564, 470.6434, 408.5467},
        {60, 90, 453.7823, 359.6177, 328.4092},  {90, 0, 26.6274, 189.2985, 218.9395},
        {45, 225, 692.4555, 439.2291, 373.7531}, {90, 180, 487.7282, 296.6456, 218.9395},
    };
    const WeatherFile weather = read(test::epw_text());
    CHECK(weather.name == "Town");
    CHECK(weather.offset_h == 1);
    for (const double bin_deg : {0.0, 3.0})
        for (const char* const model : {"perez", "isotropic"}) {
            INFO("bins of " << bin_deg << ", " << model);
            scene::Scene scene = year();
            scene.analysis.bin_deg = bin_deg;
            scene.analysis.diffuse = model;
            const WeatherLight light = weather_light(scene, test::kTown, weather);
            CHECK(light.level == Approx(light.global).epsilon(0.01));
            for (const Plane& plane : planes) {
                INFO("tilt " << plane.tilt_deg << ", azimuth " << plane.azimuth_deg);
                const OnPlane found = on_plane(light.energy, plane.tilt_deg, plane.azimuth_deg);
                const bool is_perez = scene.analysis.diffuse == "perez";
                CHECK(found.beam == Approx(plane.beam).epsilon(bin_deg == 0 ? 2e-4 : 2e-3));
                CHECK(found.diffuse ==
                      Approx(is_perez ? plane.perez : plane.isotropic).epsilon(5e-4));
            }
        }
}

TEST_CASE("all of a file's light is in the sums, whatever the steps", "[raytracer][solar]") {
    const WeatherFile weather = read(test::epw_text());
    double beam = 0;
    double diffuse = 0;
    for (const WeatherHour& hour : weather.hours) {
        beam += hour.beam / 1000;
        diffuse += hour.diffuse / 1000;
    }
    for (const double step_min : {5.0, 10.0, 30.0, 60.0}) {
        INFO(step_min);
        scene::Scene scene = year();
        scene.analysis.step_min = step_min;
        scene.analysis.diffuse = "isotropic";
        const Energy light = weather_light(scene, test::kTown, weather).energy;
        CHECK(light.isotropic == Approx(diffuse).epsilon(1e-9));
        double found = 0;
        double hours = 0;
        for (const LightDirection& from : light.sun) {
            found += from.beam;
            hours += from.hours;
        }
        // That of hours in which the sun is never up.
        CHECK(found == Approx(beam).epsilon(2e-3));
        CHECK(found <= beam * (1 + 1e-12));
        CHECK((1000 < hours && hours < 3200));
    }
    scene::Scene scene = year();
    scene.analysis.step_min = 45;
    CHECK_THROWS_WITH(weather_light(scene, test::kTown, weather), test::contains("45"));
}

TEST_CASE("an hour of weather is the hour before its time, by the file's clock",
          "[raytracer][solar]") {
    // Light in one hour alone: from 12 to 13 o'clock on 21 June, which is hour 13.
    const int wanted = (31 + 28 + 31 + 30 + 31 + 20) * 24 + 12;
    const WeatherFile weather = read(test::epw_text(
        [&](int hour) { return hour == wanted ? EpwLight{900, 800, 100} : EpwLight{}; }));
    scene::Scene scene = year();
    scene.analysis.bin_deg = 0;
    scene.analysis.step_min = 10;
    // The clock of the analysis is another one: summer time.
    scene.sun.utc_offset_h = 2;
    const Energy light = weather_light(scene, test::kTown, weather).energy;
    REQUIRE(light.sun.size() == 6);
    double hours = 0;
    for (const LightDirection& from : light.sun) {
        hours += from.hours;
        // The sun is south at 12:04, and goes 15 degrees in an hour.
        CHECK(from.to.z > 0.35);
        CHECK(std::abs(from.to.x) < 0.25);
    }
    CHECK(light.sun.front().to.x > light.sun.back().to.x);
    CHECK(light.sun.back().to.x < -0.15);
    CHECK(hours == Approx(1));
    scene.analysis.from = "2026-06-22";
    CHECK(weather_light(scene, test::kTown, weather).energy.sun.empty());
}

TEST_CASE("a file's year stands for every year", "[raytracer][solar]") {
    const auto to_day = [](int hour) { return EpwLight{0, 0, hour / 24 + 1.0}; };
    scene::Scene scene = year();
    scene.analysis.diffuse = "isotropic";
    const auto diffuse = [&](const WeatherFile& weather, const char* day) {
        scene.analysis.from = scene.analysis.to = day;
        return weather_light(scene, test::kTown, weather).energy.isotropic * 1000 / 24;
    };
    const WeatherFile plain = read(test::epw_text(to_day));
    const WeatherFile leap = read(test::epw_text(to_day, 366));
    CHECK(diffuse(plain, "2026-02-28") == Approx(59));
    CHECK(diffuse(plain, "2028-02-29") == Approx(59));
    CHECK(diffuse(plain, "2028-03-01") == Approx(60));
    CHECK(diffuse(leap, "2028-02-29") == Approx(60));
    CHECK(diffuse(leap, "2026-03-01") == Approx(61));
    CHECK(diffuse(leap, "2026-12-31") == Approx(366));
}

TEST_CASE("a weather file may have its words in any case, and an old end of file",
          "[raytracer][solar]") {
    const std::string good = test::epw_text();
    std::string text = with_line(good, 1, "Location,a,b,c,d,1,46,14,1,300");
    text = with_line(text, 8, "Data Periods,1,1,Data,Sunday,1/1,12/31");
    CHECK(read(text + "\r\n\x1a").hours.size() == read(good).hours.size());
}

TEST_CASE("weather files with faults are refused with the line", "[raytracer][solar]") {
    const std::string good = test::epw_text();
    const auto with_light = [](int from, int to, const EpwLight& light) {
        return test::epw_text([=](int hour) {
            return from <= hour && hour < to ? light : test::made_up_light(hour);
        });
    };
    const auto make_line = [](const char* radiation) {
        return "2001,1,2,5,60,?,1,1,1,1,1,1,1," + std::string(radiation) + ",1,1\r";
    };
    struct Wrong {
        const char* name;
        std::string text;
        const char* says;
    };
    const Wrong wrong[] = {
        {"nothing", "", "does not begin with LOCATION"},
        {"another file", "a,b\nc\n", "does not begin with LOCATION"},
        {"a header alone", "LOCATION,a,b,c,d,1,46,14,1,300\nx\n", "ends in its header"},
        {"half a year", good.substr(0, good.size() / 2), "; allowed"},
        {"a place beyond the pole", with_line(good, 1, "LOCATION,a,b,c,d,1,146,14,1,300"),
         "line 1: latitude = '146'"},
        {"two values an hour", with_line(good, 8, "DATA PERIODS,1,2,Data,Sunday, 1/ 1,12/31"),
         "line 8: '1' periods of '2' values"},
        {"missing radiation", with_light(48, 60, {9999, 9999, 9999}),
         "missing (9999) in 12 hours, the first one on line 57 (month 1, day 3, hour 1)"},
        {"no number", with_line(good, 37, make_line("sun")), "line 37: radiation = 'sun'"},
        {"not finite", with_line(good, 37, make_line("nan")), "line 37: radiation = 'nan'"},
        {"below zero", with_line(good, 37, make_line("-1")), "line 37: radiation = '-1'"},
        {"more than the sun has", with_line(good, 37, make_line("3000")), "allowed: 0 to 2000"},
        {"few columns", with_line(good, 37, "2001,1,2,5,60\r"), "line 37: 5 values"},
        {"an hour twice", with_line(good, 37, "2001,1,2,4,60,?,1,1,1,1,1,1,1,1,1,1\r"),
         "line 37: month 1, day 2, hour 4; allowed here: month 1, day 2, hour 5"},
        {"more than a year", good + "2001,1,1,1,60,?,1,1,1,1,1,1,1,1,1,1\n",
         "after the end of the year"},
    };
    for (const Wrong& one : wrong) {
        INFO(one.name);
        CHECK_THROWS_WITH(read(one.text), test::contains(one.says) && test::contains("town.epw"));
    }
    CHECK_THROWS_WITH(read_weather("/nowhere.epw"), test::contains("no such file"));
    CHECK_THROWS_WITH(read_weather("/"), test::contains("not a plain file"));
}

TEST_CASE("light as text is the same light, and other texts are refused", "[raytracer][solar]") {
    const WeatherFile weather = read(test::epw_text());
    scene::Scene scene = year();
    scene.analysis.crown_light = "0.03,0.45";
    const Energy light = weather_light(scene, test::kTown, weather).energy;
    CHECK((0.1 < light.through_crowns && light.through_crowns < 0.2));
    const std::string text = to_text(light);
    CHECK(text.size() < 60'000);
    const Energy again = parse_light(text);
    REQUIRE(again.sun.size() == light.sun.size());
    CHECK(again.isotropic == Approx(light.isotropic).epsilon(1e-7));
    CHECK(again.horizon == Approx(light.horizon).epsilon(1e-7));
    for (std::size_t i = 0; i < light.sun.size(); ++i) {
        CHECK(core::dot(again.sun[i].to, light.sun[i].to) == Approx(1).epsilon(1e-12));
        CHECK(again.sun[i].beam == Approx(light.sun[i].beam).epsilon(1e-6));
        CHECK(again.sun[i].hours == Approx(light.sun[i].hours).epsilon(1e-6));
        CHECK(again.sun[i].through_crowns == Approx(light.sun[i].through_crowns).epsilon(1e-6));
    }
    CHECK(to_text(again).size() > 10'000);
    CHECK(parse_light("3,-1,0.5").sun.empty());
    const char* const wrong[] = {
        "x",
        "1,2",
        "1,2,0,4",
        "-1,0,0",
        "1,nan,0",
        "1,2e6,0",
        "1,0,1.5",
        "1,2,0;",
        "1,2,0;0,1,0",
        "1,2,0;0,1,0,1,1,1,0;",
        "1,2,0;0,2,0,1,1,1,0",
        "1,2,0;0,-1,0,1,1,1,0",
        "1,2,0;1,0,0,1,1,1,0",
        "1,2,0;0,1,0,-1,1,1,0",
        "1,2,0;0,1,0,1,inf,1,0",
        "1,2,0;0,1,0,1,1,1,-0.1",
        "1,2,0;0,1,0,1,1,1,0 ",
    };
    for (const char* const one : wrong) {
        INFO(one);
        CHECK_THROWS_AS(parse_light(one), util::UsageError);
    }
    std::string many = "1,2,0";
    for (std::size_t i = 0; i <= kMaxListedDirections; ++i)
        many += ";0,1,0,1,1,1,0";
    CHECK_THROWS_AS(parse_light(many), util::UsageError);
    Energy wide;
    wide.sun.resize(kMaxListedDirections + 1);
    CHECK_THROWS_WITH(to_text(wide), test::contains("bin_deg"));
}

TEST_CASE("crowns have leaves in summer, on either side of the equator", "[raytracer][solar]") {
    const CrownLight north("0.03,0.45", {46, 14.5});
    const CrownLight south("0.03,0.45", {-38, 145});
    for (int month = 1; month <= 12; ++month) {
        INFO("month " << month);
        CHECK(north.share(month) == (4 <= month && month <= 10 ? 0.03 : 0.45));
        CHECK(south.share(month) == (5 <= month && month <= 9 ? 0.45 : 0.03));
        CHECK(CrownLight("0.2", {46, 14.5}).share(month) == 0.2);
    }
    for (const char* const wrong :
         {"", "x", "-0.1", "1.1", "nan", "0.1,", ",0.1", "0.1,2", "0,0,0"})
        CHECK_THROWS_AS(CrownLight(wrong, test::kTown), util::UsageError);
}
