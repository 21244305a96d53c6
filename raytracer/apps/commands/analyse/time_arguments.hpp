#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::commands {

/// Up to so many bands, which is each quarter of an hour of a day, or each hour of four days.
inline constexpr std::size_t kMaxTimes = 96;

/// One of the instants of `analyse sun --times`.
struct ClockTime {
    std::string date;  ///< YYYY-MM-DD; empty: that of the scene
    double hour = 0;   ///< on the scene's clock
    std::string band;  ///< name of its band, such as sunlit_0900 or sunlit_2026-06-21T0900
};

/// The hour of HH:MM.
/// @param option for the message @throws UsageError
[[nodiscard]] double hour_of(const std::string& option, const std::string& text);

/// Reads HH:MM or YYYY-MM-DDTHH:MM, several separated by commas.
/// @throws UsageError for none or more than kMaxTimes, for one that is given twice, and for what is
/// no time
[[nodiscard]] std::vector<ClockTime> times_of(const std::string& text);

/// When the sun of a scene is, as seconds since 1970-01-01 00:00 UTC.
/// @throws UsageError as sky::time_of()
[[nodiscard]] std::int64_t instant_of(const scene::Scene& scene, const geo::MapPlace& place);

/// The scene with the sun of an instant.
[[nodiscard]] scene::Scene scene_at(const scene::Scene& scene, const ClockTime& time);

}  // namespace terravox::commands
