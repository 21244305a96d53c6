#pragma once

#include <string>

namespace terravox::stac {

/// An instant, or the time from one to another, in UTC as RFC 3339 writes it:
/// "2023-04-01T00:00:00Z".
struct StacTime {
    std::string start;
    std::string end;  ///< not before `start`; the same: an instant
    [[nodiscard]] bool is_instant() const noexcept { return start == end; }
};

/// @param text a date (2023-04-01: all of that day) or an instant (2023-04-01T10:30:00Z), or two of
/// them with a slash between them
/// @throws UsageError for another text, a day that no calendar has, or an end before its start
[[nodiscard]] StacTime stac_time(const std::string& text);

}  // namespace terravox::stac
