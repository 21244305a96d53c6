#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "common/geo/time_zone.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::solar {

/// The place whose sun is that of a scene: of an analysis analysis.place, else the middle of the
/// world.
/// @param centre of the world; nullopt where it is not georeferenced
/// @throws UsageError for an analysis.place that is not on Earth
[[nodiscard]] std::optional<geo::MapPlace> find_place(const scene::Scene& scene,
                                                      const std::optional<geo::MapPlace>& centre);

/// The clock of an analysis's place. Immutable.
class Clock {
public:
    /// That of analysis.clock, else of sun.utc_offset_h, sun.zone, or the place's longitude.
    /// @throws UsageError for dates that find_period() refuses, an unknown zone, a text that is
    /// none
    Clock(const scene::Scene& scene, const geo::MapPlace& place);

    /// @param utc_s seconds since 1970-01-01 00:00 UTC
    [[nodiscard]] double offset_h(std::int64_t utc_s) const noexcept;
    /// The instant at which a day begins, the first one where clocks show midnight twice.
    /// @param day since 1970-01-01
    [[nodiscard]] std::int64_t midnight_s(std::int64_t day) const noexcept;
    /// For analysis.clock, with which no machine needs the table of time zones: offsets in hours,
    /// each with the instant from which on it counts, "1@1767135600 2@1774746000".
    [[nodiscard]] std::string text() const;

private:
    std::vector<geo::OffsetFrom> m_offsets;  ///< at least one, in the order of time
};

/// Days of a scene's analysis: analysis.from to analysis.to, else sun.date.
struct Days {
    std::int64_t begin = 0;  ///< since 1970-01-01
    std::int64_t end = 0;    ///< after the last one
};
/// @throws UsageError for what is no date of the years 1900 to 2100, one date without the other, an
/// end before the beginning
[[nodiscard]] Days list_days(const scene::Scene& scene);

}  // namespace terravox::solar
