#pragma once

#include "common/geo/lat_lon.hpp"

namespace terravox::geo {

/// A date and a clock time at a fixed offset from UTC (no daylight-saving rules).
struct DateTime {
    int year = 2026, month = 6, day = 21;  ///< proleptic Gregorian
    double hour = 16;                      ///< local clock time in decimal hours, [0, 24)
    double utc_offset_h = 0;               ///< clock time minus UTC
};

struct SunPosition {
    /// Altitude of the sun's centre above the horizon, with refraction at sea level.
    double altitude_deg = 0;
    /// Clockwise from true north or from that of a map, as the function says; [0, 360).
    double azimuth_deg = 0;
    friend bool operator==(const SunPosition&, const SunPosition&) = default;
};

enum class SunPrecision {
    /// Error below 0.02 degree from 1950 to 2050. Pictures have their sun by it, bit by bit.
    kPicture,
    /// Error below 0.006 degree above 15 degrees of altitude: also with perturbations by Moon,
    /// Venus and Jupiter, nutation, parallax, and the difference of Terrestrial Time and UT.
    kAnalysis,
};

/// Position of the sun in the sky, azimuth from true north. Errors: SunPrecision; from 1900 to 2100
/// below 0.05 degree.
/// Ref: Meeus, "Astronomical Algorithms", 2nd ed. 1998, chapters 25 and 13, as arranged by NOAA's
/// solar calculator; for kAnalysis also chapters 22 and 40, Meeus, "Astronomical Formulae for
/// Calculators", 2nd ed. 1982, chapter 18 (perturbations), and Espenak & Meeus, "Five Millennium
/// Canon of Solar Eclipses", 2006 (the difference of times).
[[nodiscard]] SunPosition sun_position(const DateTime& time, LatLon place,
                                       SunPrecision precision = SunPrecision::kPicture) noexcept;

/// The same on a map: the azimuth is counted from the map's north, so that directions of the map
/// follow from it.
[[nodiscard]] SunPosition sun_on_map(const DateTime& time, const MapPlace& place,
                                     SunPrecision precision = SunPrecision::kPicture) noexcept;

/// @return the UTC offset of the nautical time zone of a longitude (mean solar time): whole hours,
/// [-12, 12]
[[nodiscard]] double solar_zone_offset_h(double lon_deg) noexcept;

}  // namespace terravox::geo
