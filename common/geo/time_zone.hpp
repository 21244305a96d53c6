#pragma once

#include <cstdint>
#include <string>

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

/// UTC offset of a time zone at an instant. Thread-safe.
/// @param utc_s seconds since 1970-01-01 00:00 UTC
/// @return local time minus UTC, in hours
/// @throws as zone_offset_h()
[[nodiscard]] double zone_offset_at_h(const std::string& zone, std::int64_t utc_s);

/// Days from 1970-01-01 to a date, which must be valid.
[[nodiscard]] std::int64_t days_from_1970(int year, int month, int day) noexcept;

/// A clock time at an offset, from an instant.
/// @param utc_s seconds since 1970-01-01 00:00 UTC
[[nodiscard]] DateTime clock_at(std::int64_t utc_s, double utc_offset_h) noexcept;

}  // namespace terravox::geo
