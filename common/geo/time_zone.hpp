#pragma once

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

}  // namespace terravox::geo
