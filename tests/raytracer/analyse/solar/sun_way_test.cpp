#include "raytracer/analyse/solar/sun_way.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/solar/place_and_clock.hpp"
#include "tests/catch.hpp"

namespace {

using namespace terravox;
using core::AnalysisKind;

constexpr geo::MapPlace kPlace{46, 14.5};
constexpr geo::MapPlace kFarNorth{78.2, 15.6};

scene::Scene period(const char* from, const char* to, double step_min = 30) {
    scene::Scene scene;
    scene.analysis.kind = AnalysisKind::kSunPeriod;
    scene.analysis.from = from;
    scene.analysis.to = to;
    scene.analysis.step_min = step_min;
    scene.analysis.bin_deg = 0;
    return scene;
}

scene::Scene in_zone(scene::Scene scene, const char* zone) {
    scene.sun.zone = zone;
    return scene;
}

scene::Scene at_offset(scene::Scene scene, double offset_h) {
    scene.sun.utc_offset_h = offset_h;
    return scene;
}

solar::SunWay way(const scene::Scene& scene, const geo::MapPlace& place = kPlace) {
    return solar::make_sun_way(scene, &place);
}

}  // namespace

TEST_CASE("a day has as many hours as its clocks give it", "[raytracer][solar]") {
    struct Day {
        const char* date;
        int hours;
    };
    for (const Day& d : {Day{"2026-03-28", 24}, Day{"2026-03-29", 23}, Day{"2026-10-25", 25}}) {
        INFO(d.date);
        const scene::Scene scene = in_zone(period(d.date, d.date), "Europe/Ljubljana");
        const solar::Period found = solar::find_period(scene, kPlace);
        CHECK(found.days == 1);
        CHECK(found.end_s - found.begin_s == d.hours * 3600);
    }
}

TEST_CASE("a clock's text has all that its zone says", "[raytracer][solar]") {
    // Clocks of Beirut change at midnight, Apia left out a day.
    struct Place {
        const char* zone;
        const char* from;
        const char* to;
    };
    for (const Place& p : {Place{"Europe/Ljubljana", "2026-01-01", "2026-12-31"},
                           Place{"Asia/Beirut", "2022-03-20", "2022-11-05"},
                           Place{"Pacific/Apia", "2011-12-28", "2012-01-02"},
                           Place{"Asia/Kathmandu", "2024-07-01", "2024-07-01"}}) {
        INFO(p.zone);
        const scene::Scene by_zone = in_zone(period(p.from, p.to), p.zone);
        scene::Scene by_text = period(p.from, p.to);
        by_text.analysis.clock = solar::Clock(by_zone, kPlace).text();
        INFO(by_text.analysis.clock);
        const solar::Period wanted = solar::find_period(by_zone, kPlace);
        const solar::Period found = solar::find_period(by_text, kPlace);
        CHECK(found.begin_s == wanted.begin_s);
        CHECK(found.end_s == wanted.end_s);
        const solar::SunWay zone_way = way(by_zone);
        const solar::SunWay text_way = way(by_text);
        REQUIRE(zone_way.directions.size() == text_way.directions.size());
        for (std::size_t i = 0; i < zone_way.directions.size(); ++i) {
            REQUIRE(zone_way.directions[i].to == text_way.directions[i].to);
            REQUIRE(zone_way.directions[i].begin_h == text_way.directions[i].begin_h);
            REQUIRE(zone_way.directions[i].month_hours == text_way.directions[i].month_hours);
        }
    }
    // Midnight is where the law puts it: skipped, the clock goes from 23:59 to 1:00.
    const scene::Scene spring = in_zone(period("2022-03-26", "2022-03-27"), "Asia/Beirut");
    const solar::Clock beirut(spring, kPlace);
    const std::int64_t day = geo::days_from_1970(2022, 3, 27);
    CHECK(beirut.midnight_s(day) == day * 86'400 - 2 * 3600);
    CHECK(beirut.midnight_s(day + 1) == (day + 1) * 86'400 - 3 * 3600);
    for (const char* text :
         {"1", "@", "1@", "x@0", "1@0,", "1@0 ", "1@0 2@0", "2@5 1@4", "25@0", "nan@0",
          "1@99999999999999999999", "1@9999999999999", "1@-9223372036854775808"}) {
        INFO("'" << text << "'");
        scene::Scene bad = period("2026-01-01", "2026-01-01");
        bad.analysis.clock = text;
        CHECK_THROWS_AS(way(bad), util::UsageError);
        CHECK_THROWS_WITH(way(bad), terravox::test::contains("analysis.clock"));
    }
}

TEST_CASE("clocks that change move no sun", "[raytracer][solar]") {
    struct Change {
        const char* from;
        const char* to;
        double offset_h;  // before the change
    };
    for (const Change& c :
         {Change{"2026-03-28", "2026-03-30", 1}, Change{"2026-10-24", "2026-10-26", 2}}) {
        INFO(c.from);
        const solar::SunWay by_law = way(in_zone(period(c.from, c.to, 5), "Europe/Ljubljana"));
        const solar::SunWay by_offset = way(at_offset(period(c.from, c.to, 5), c.offset_h));
        CHECK(by_law.days == 3);
        REQUIRE(by_law.directions.size() == by_offset.directions.size());
        for (std::size_t i = 0; i < by_law.directions.size(); ++i)
            REQUIRE(by_law.directions[i].to == by_offset.directions[i].to);
        CHECK(by_law.hours == by_offset.hours);
    }
}

TEST_CASE("clock times of a day are those of its clocks", "[raytracer][solar]") {
    scene::Scene day = in_zone(period("", ""), "Europe/Ljubljana");
    day.analysis.kind = AnalysisKind::kSun;
    const auto first_sun = [&](const char* date) {
        day.sun.date = date;
        return way(day).directions.front().begin_h;
    };
    // In steps of half an hour the sun rises when it did the day before, by a clock that has moved.
    CHECK(first_sun("2026-03-28") == 6);
    CHECK(first_sun("2026-03-29") == 7);
    CHECK(first_sun("2026-10-24") == 7.5);
    CHECK(first_sun("2026-10-25") == 6.5);
}

TEST_CASE("the sun of polar days does not set, that of polar nights not rise",
          "[raytracer][solar]") {
    CHECK(way(period("2026-06-01", "2026-06-30"), kFarNorth).hours == 30 * 24);
    const solar::SunWay night = way(period("2026-12-01", "2026-12-31"), kFarNorth);
    CHECK(night.hours == 0);
    CHECK(night.directions.empty());
    CHECK(night.days == 31);
    // Of a whole year it is up for half, and some days more by refraction.
    const double year = way(period("2026-01-01", "2026-12-31"), kFarNorth).hours;
    CHECK(year > 365 * 12);
    CHECK(year < 365 * 12.6);
}

TEST_CASE("steps fill a day whatever their length", "[raytracer][solar]") {
    for (const double step_min : {1.0, 7.0, 7.5, 37.0, 60.0}) {
        INFO(step_min);
        const solar::SunWay found = way(period("2026-06-21", "2026-06-21", step_min), kFarNorth);
        CHECK(found.hours == Approx(24).margin(1e-9));
    }
}

TEST_CASE("bins keep the hours and the middle of the sun's places", "[raytracer][solar]") {
    for (const geo::MapPlace& place :
         {kPlace, kFarNorth, geo::MapPlace{0, 30}, geo::MapPlace{-35, 150}})
        for (const double bin_deg : {1.0, 3.0, 10.0}) {
            INFO(place.lat_deg << " degrees north, bins of " << bin_deg);
            scene::Scene scene = period("2025-07-01", "2026-06-30");
            const solar::SunWay each = way(scene, place);
            scene.analysis.bin_deg = bin_deg;
            const solar::SunWay binned = way(scene, place);
            CHECK(binned.hours == Approx(each.hours));
            CHECK(binned.directions.size() < 2.2 * 8300 / (bin_deg * bin_deg) + 200);
            double month_hours = 0;
            for (const solar::SunDirection& bin : binned.directions) {
                REQUIRE(bin.to.y > 0);
                REQUIRE(core::dot(bin.to, bin.to) == Approx(1));
                double months = 0;
                for (const float month : bin.month_hours)
                    months += static_cast<double>(month);
                REQUIRE(months == Approx(bin.hours).epsilon(1e-5));
                month_hours += months;
                const double nearest =
                    std::accumulate(each.directions.begin(), each.directions.end(), -1.0,
                                    [&](double most, const solar::SunDirection& step) {
                                        return std::max(most, core::dot(step.to, bin.to));
                                    });
                REQUIRE(nearest > std::cos(bin_deg * 0.75 * 3.1416 / 180));
            }
            CHECK(month_hours == Approx(each.hours).epsilon(1e-5));
        }
}

TEST_CASE("on a map whose north is turned, the sun's way is turned the other way",
          "[raytracer][solar]") {
    const double turn_deg = GENERATE(-1.15, 3.0, 45.0);
    const double bin_deg = GENERATE(0.0, 3.0);
    INFO("turned by " << turn_deg << ", bins of " << bin_deg);
    scene::Scene scene = period("2026-03-01", "2026-03-31");
    scene.analysis.bin_deg = bin_deg;
    const solar::SunWay plain = way(scene);
    const solar::SunWay turned = way(scene, {{kPlace.lat_deg, kPlace.lon_deg}, turn_deg});
    REQUIRE(turned.directions.size() == plain.directions.size());
    CHECK(turned.hours == plain.hours);
    const double rad = turn_deg * det::kPi / 180;
    for (std::size_t i = 0; i < plain.directions.size(); ++i) {
        // The map's north lies clockwise of true north: the sun moves counter-clockwise on it.
        const core::Vec3 from = plain.directions[i].to;
        const core::Vec3 wanted{from.x * std::cos(rad) + from.z * std::sin(rad), from.y,
                                from.z * std::cos(rad) - from.x * std::sin(rad)};
        const core::Vec3 apart = turned.directions[i].to - wanted;
        REQUIRE(core::dot(apart, apart) < 1e-20);
        REQUIRE(turned.directions[i].hours == plain.directions[i].hours);
    }
}

TEST_CASE("an instant has one direction by day and none by night", "[raytracer][solar]") {
    scene::Scene scene = at_offset(period("", ""), 1);
    scene.analysis.kind = AnalysisKind::kShadow;
    scene.sun.time_h = 12;
    const solar::SunWay noon = way(scene);
    REQUIRE(noon.directions.size() == 1);
    CHECK(std::abs(noon.directions[0].to.x) < 0.05);
    CHECK(noon.directions[0].to.z > 0);
    scene.sun.time_h = 2;
    CHECK(way(scene).directions.empty());
}

TEST_CASE("periods that cannot be are refused by name", "[raytracer][solar]") {
    using terravox::test::contains;
    struct Case {
        const char* name;
        scene::Scene scene;
        const char* says;
    };
    scene::Scene of_a_day = period("2026-01-01", "2026-01-02");
    of_a_day.analysis.kind = AnalysisKind::kSun;
    scene::Scene fine_bins = period("2026-01-01", "2026-01-02");
    fine_bins.analysis.bin_deg = 1e-9;
    scene::Scene many_bins = period("2026-01-01", "2027-06-30", 1);
    many_bins.analysis.bin_deg = 0.1;
    const Case cases[] = {
        {"bins of nothing", fine_bins, "allowed: 0.1 to 15"},
        {"too many bins", many_bins, "a larger analysis.bin_deg"},
        {"no end", period("2026-01-01", ""), "analysis.to is missing"},
        {"no beginning", period("", "2026-01-01"), "analysis.from is missing"},
        {"backwards", period("2026-02-01", "2026-01-31"), "not before analysis.from"},
        {"no day", period("2026-02-01", "2026-02-30"), "no day of the calendar"},
        {"no date", period("yesterday", "2026-02-30"), "YYYY-MM-DD"},
        {"before the almanac", period("1899-12-31", "1900-02-01"), "years 1900 to 2100"},
        {"after it", period("2100-01-01", "2101-01-01"), "years 1900 to 2100"},
        {"too many steps", period("1900-01-01", "2100-12-31", 1), "up to 1000000"},
        {"too many rays", period("2000-01-01", "2019-12-31"), "a larger analysis.bin_deg"},
        {"a day of many", of_a_day, "of one day"},
        {"no zone", in_zone(period("2026-01-01", "2026-01-01"), "Moon/Tycho"), "Moon/Tycho"},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        CHECK_THROWS_AS(way(c.scene), util::UsageError);
        CHECK_THROWS_WITH(way(c.scene), contains(c.says));
    }
    CHECK_THROWS_WITH(solar::make_sun_way(period("2026-01-01", "2026-01-01"), nullptr),
                      contains("no place on Earth"));
}
