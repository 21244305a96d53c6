#include "common/geo/time_zone.hpp"

#include <tuple>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::geo;
using terravox::test::contains;

TEST_CASE("clocks stand where the zones' laws put them", "[common][geo][zone]") {
    struct Case {
        const char* name;
        std::string zone;
        int year;
        int month;
        int day;
        double hour;
        double offset_h;
    };
    const auto c = GENERATE(values<Case>({
        {"summer time", "Europe/Ljubljana", 2026, 6, 21, 16, 2},
        {"winter time", "Europe/Ljubljana", 2026, 12, 21, 12, 1},
        {"west of Greenwich", "America/New_York", 2024, 7, 1, 12, -4},
        {"no summer time", "America/Phoenix", 2024, 7, 1, 12, -7},
        {"half an hour", "Asia/Kolkata", 2024, 7, 1, 12, 5.5},
        {"three quarters", "Asia/Kathmandu", 2024, 7, 1, 12, 5.75},
        {"summer in January", "Australia/Sydney", 2024, 1, 15, 12, 11},
        {"the whole year an hour ahead", "Europe/London", 1970, 1, 1, 12, 1},
        {"across the date line", "Pacific/Apia", 2012, 1, 2, 12, 14},
        {"the world's time", "UTC", 2024, 7, 1, 0, 0},
        {"an old name", "Europe/Kiev", 2024, 7, 1, 12, 3},
        {"last second before the change", "Europe/Ljubljana", 2026, 3, 29, 2 - 1 / 3600.0, 1},
        {"a time that is skipped", "Europe/Ljubljana", 2026, 3, 29, 2.5, 1},
        {"after it", "Europe/Ljubljana", 2026, 3, 29, 3, 2},
        {"a time that comes twice", "Europe/Ljubljana", 2026, 10, 25, 2.5, 2},
        {"after it", "Europe/Ljubljana", 2026, 10, 25, 3, 1},
        {"the end of the day before a change", "Europe/Ljubljana", 2026, 3, 28, 24, 1},
    }));
    DYNAMIC_SECTION(c.name << ": " << c.zone) {
        CHECK(zone_offset_h(c.zone, {c.year, c.month, c.day, c.hour, 99}) == c.offset_h);
    }
}

TEST_CASE("an instant has the offset and the clock of its zone", "[common][geo][zone]") {
    struct Case {
        const char* name;
        std::int64_t utc_s;
        double offset_h;
        DateTime clock;
    };
    const std::int64_t spring_s = days_from_1970(2026, 3, 29) * 86'400;
    const std::int64_t autumn_s = days_from_1970(2026, 10, 25) * 86'400;
    const auto c = GENERATE_COPY(values<Case>({
        {"the beginning", 0, 1, {1970, 1, 1, 1, 1}},
        {"before it", -7200, 1, {1969, 12, 31, 23, 1}},
        {"before clocks go forward", spring_s + 3599, 1, {2026, 3, 29, 2 - 1 / 3600.0, 1}},
        {"after it", spring_s + 3600, 2, {2026, 3, 29, 3, 2}},
        {"the first of two equal times", autumn_s + 1800, 2, {2026, 10, 25, 2.5, 2}},
        {"the second", autumn_s + 5400, 1, {2026, 10, 25, 2.5, 1}},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(zone_offsets("Europe/Ljubljana", c.utc_s, c.utc_s + 1).at(0).offset_h == c.offset_h);
        const DateTime clock = clock_at(c.utc_s, c.offset_h);
        CHECK(clock.year == c.clock.year);
        CHECK(clock.month == c.clock.month);
        CHECK(clock.day == c.clock.day);
        CHECK(clock.hour == Approx(c.clock.hour));
        CHECK(clock.utc_offset_h == c.clock.utc_offset_h);
    }
}

TEST_CASE("the offsets of a year are those between its changes", "[common][geo][zone]") {
    const std::int64_t begin_s = days_from_1970(2026, 1, 1) * 86'400;
    const auto year = zone_offsets("Europe/Ljubljana", begin_s, begin_s + 365 * 86'400);
    REQUIRE(year.size() == 3);
    CHECK(year[0].from_s == begin_s);
    CHECK(year[0].offset_h == 1);
    CHECK(year[1].from_s == days_from_1970(2026, 3, 29) * 86'400 + 3600);
    CHECK(year[1].offset_h == 2);
    CHECK(year[2].from_s == days_from_1970(2026, 10, 25) * 86'400 + 3600);
    CHECK(year[2].offset_h == 1);
    CHECK(zone_offsets("Asia/Kolkata", begin_s, begin_s + 365 * 86'400).size() == 1);
    CHECK_THROWS_AS(zone_offsets("Europe/Atlantis", 0, 1), util::UsageError);
}

TEST_CASE("unknown zones are refused by name", "[common][geo][zone]") {
    for (const std::string zone : {"Mars/Olympus_Mons", "europe/ljubljana", "CET-1",
                                   "../../etc/passwd", "", "Europe/", "Europe"}) {
        INFO("'" << zone << "'");
        CHECK_THROWS_AS(zone_offset_h(zone, {}), util::UsageError);
        CHECK_THROWS_WITH(zone_offset_h(zone, {}),
                          contains("'" + zone + "' is not known; allowed: IANA names"));
    }
}

TEST_CASE("a date is a day of the calendar", "[common][geo][zone]") {
    CHECK(is_date(2026, 6, 21));
    CHECK(is_date(2024, 2, 29));
    CHECK(is_date(2000, 2, 29));
    for (const auto& [y, m, d] : {std::tuple{2025, 2, 30},
                                  {2025, 2, 29},
                                  {1900, 2, 29},
                                  {2025, 13, 1},
                                  {2025, 0, 1},
                                  {2025, 4, 31},
                                  {2025, 1, 0},
                                  {2025, 1, -3},
                                  {2025, -1, 256 + 3}}) {
        INFO(y << "-" << m << "-" << d);
        CHECK_FALSE(is_date(y, m, d));
    }
}
