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
        throw util::Error(
            "read the system's time zones: {}; install the package tzdata, or give "
            "sun.utc_offset_h",
            e.what());
    }
    try {
        return *date::locate_zone(zone);
    } catch (const std::exception&) {
        throw util::UsageError(
            "find the time zone: '{}' is not known; allowed: IANA names, such as Europe/Ljubljana; "
            "old ones, such as Europe/Kiev, may need the package tzdata-legacy",
            zone);
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
        throw util::Error("read the time zone '{}': {}", zone, e.what());
    }
}

std::vector<OffsetFrom> zone_offsets(const std::string& zone, std::int64_t begin_s,
                                     std::int64_t end_s) {
    const date::time_zone& found = find(zone);
    std::vector<OffsetFrom> out;
    try {
        date::sys_seconds at{std::chrono::seconds{begin_s}};
        do {
            const auto info = found.get_info(at);
            const double offset_h =
                std::chrono::duration<double, std::ratio<3600>>(info.offset).count();
            if (out.empty() || out.back().offset_h != offset_h)
                out.push_back({at.time_since_epoch().count(), offset_h});
            at = info.end;
        } while (at.time_since_epoch().count() < end_s);
    } catch (const std::exception& e) {
        throw util::Error("read the time zone '{}': {}", zone, e.what());
    }
    return out;
}

std::int64_t days_from_1970(int year, int month, int day) noexcept {
    const std::chrono::year_month_day date{std::chrono::year(year),
                                           std::chrono::month(static_cast<unsigned>(month)),
                                           std::chrono::day(static_cast<unsigned>(day))};
    return std::chrono::sys_days{date}.time_since_epoch().count();
}

DateTime clock_at(std::int64_t utc_s, double utc_offset_h) noexcept {
    const std::chrono::sys_seconds local{
        std::chrono::seconds{utc_s + std::llround(utc_offset_h * 3600)}};
    const auto day = std::chrono::floor<std::chrono::days>(local);
    const std::chrono::year_month_day date{day};
    return {.year = static_cast<int>(date.year()),
            .month = static_cast<int>(static_cast<unsigned>(date.month())),
            .day = static_cast<int>(static_cast<unsigned>(date.day())),
            .hour = static_cast<double>((local - day).count()) / 3600,
            .utc_offset_h = utc_offset_h};
}

}  // namespace terravox::geo
