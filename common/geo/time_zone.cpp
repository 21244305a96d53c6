#include "common/geo/time_zone.hpp"

#include <date/tz.h>

#include <chrono>
#include <cmath>

#include "common/util/error.hpp"

namespace terravox::geo {
namespace {

const date::time_zone& find(const std::string& zone) {
    try {
        date::get_tzdb();  // loaded once
    } catch (const std::exception& e) {
        throw util::Error(std::string("read the system's time zones: ") + e.what() +
                          "; install the package tzdata, or give sun.utc_offset_h");
    }
    try {
        return *date::locate_zone(zone);
    } catch (const std::exception&) {
        throw util::UsageError("find the time zone: '" + zone +
                               "' is not known; allowed: IANA names, such as Europe/Ljubljana");
    }
}

}  // namespace

bool is_date(int year, int month, int day) noexcept {
    return month >= 1 && month <= 12 && day >= 1 && day <= 31 &&
           std::chrono::year_month_day{std::chrono::year(year),
                                       std::chrono::month(static_cast<unsigned>(month)),
                                       std::chrono::day(static_cast<unsigned>(day))}
               .ok();
}

double zone_offset_h(const std::string& zone, const DateTime& local) {
    const date::time_zone& found = find(zone);
    const auto day = date::local_days{date::year{local.year} / local.month / local.day};
    const auto time = day + std::chrono::seconds{std::lround(local.hour * 3600)};
    try {
        // For a skipped or repeated hour, `first` is the rule before the change.
        return std::chrono::duration<double, std::ratio<3600>>(found.get_info(time).first.offset)
            .count();
    } catch (const std::exception& e) {
        throw util::Error("read the time zone '" + zone + "': " + e.what());
    }
}

}  // namespace terravox::geo
