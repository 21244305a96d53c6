#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/geo/sun_position.hpp"

namespace terravox::geo {

/// @return whether year, month and day form a valid date of the Gregorian calendar
[[nodiscard]] bool is_date(int year, int month, int day) noexcept;

/// UTC offset of a time zone at a local time, by the system's time zone database. A local time that
/// occurs twice, when clocks go back, means its first occurrence (summer time); one that is
/// skipped, when clocks go forward, is interpreted with the offset before the change. Thread-safe.
/// @param zone IANA name, such as Europe/Ljubljana
/// @param local hour in [0, 24]; its utc_offset_h is ignored
/// @return local time minus UTC, in hours
/// @throws UsageError for a zone that the database lacks; Error if the database cannot be read
[[nodiscard]] double zone_offset_h(const std::string& zone, const DateTime& local);

/// An offset from UTC, and the instant from which on it counts.
struct OffsetFrom {
    std::int64_t from_s = 0;  ///< seconds since 1970-01-01 00:00 UTC
    double offset_h = 0;      ///< local time minus UTC
};
/// The offsets of a time zone from one instant to another, in the order of time; at least one.
/// Thread-safe.
/// @param begin_s, end_s seconds since 1970-01-01 00:00 UTC
/// @throws as zone_offset_h()
[[nodiscard]] std::vector<OffsetFrom> zone_offsets(const std::string& zone, std::int64_t begin_s,
                                                   std::int64_t end_s);

/// Days from 1970-01-01 to a date, which must be valid.
[[nodiscard]] std::int64_t days_from_1970(int year, int month, int day) noexcept;

/// A clock time at an offset, from an instant.
/// @param utc_s seconds since 1970-01-01 00:00 UTC
[[nodiscard]] DateTime clock_at(std::int64_t utc_s, double utc_offset_h) noexcept;

}  // namespace terravox::geo
