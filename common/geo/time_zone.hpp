#pragma once

#include <string>

#include "common/geo/sun_position.hpp"

namespace terravox::geo {

/// @return whether year, month and day name a day of the Gregorian calendar
[[nodiscard]] bool is_date(int year, int month, int day) noexcept;

/// What a clock of a zone shows minus UTC, by the system's table of time zones. Of a time that
/// comes twice, when clocks go back, the first counts (summer time); one that is skipped, when they
/// go forward, counts by the offset before, as if nobody had touched the clock.
/// @param zone IANA name, such as Europe/Ljubljana @param local its utc_offset_h is not looked at;
/// hour in [0, 24]
/// @return hours @throws UsageError for a zone that the table does not have, Error if the table
/// cannot be read. Thread-safe.
[[nodiscard]] double zone_offset_h(const std::string& zone, const DateTime& local);

}  // namespace terravox::geo
