/**
 * The sun's place in the sky, by the formulas of common/geo/sun_position.cpp, so that the viewer's
 * shadows are those of the ray tracer.
 * Ref: Meeus, "Astronomical Algorithms", 2nd ed. 1998, chapters 25 and 13, as arranged by NOAA's
 * solar calculator. Error below 0.05 degree for the years 1900 to 2100.
 */
import type { MapPlace } from '../../replies.js';

export type SunPosition = {
  /** Of the sun's middle above the horizon, with refraction at sea level. */
  readonly altitudeDeg: number;
  /** Clockwise from the map's north, [0, 360). */
  readonly azimuthDeg: number;
};

/** Where worlds without a place on Earth have their sun. */
export const kNowhere: MapPlace = { latDeg: 46, lonDeg: 14, convergenceDeg: 0 };

const kRad = Math.PI / 180;
const kDayMs = 86_400_000;
const kUnixEpochJulianDay = 2_440_587.5;

const wrapDeg = (a: number): number => a - 360 * Math.floor(a / 360);

/** @param timeMs UTC, milliseconds since 1970 */
export function sunPosition(timeMs: number, place: MapPlace): SunPosition {
  const day = timeMs / kDayMs + kUnixEpochJulianDay;
  const t = (day - 2_451_545) / 36_525;
  // Step 1: the sun's apparent ecliptic longitude.
  const meanLongitude = wrapDeg(280.46646 + t * (36_000.76983 + t * 0.0003032));
  const anomaly = (357.52911 + t * (35_999.05029 - 0.0001537 * t)) * kRad;
  const centre =
    Math.sin(anomaly) * (1.914602 - t * (0.004817 + 0.000014 * t)) +
    Math.sin(2 * anomaly) * (0.019993 - 0.000101 * t) +
    Math.sin(3 * anomaly) * 0.000289;
  const omega = (125.04 - 1934.136 * t) * kRad;
  const longitude = (meanLongitude + centre - 0.00569 - 0.00478 * Math.sin(omega)) * kRad;
  // Step 2: to right ascension and declination.
  const seconds = 21.448 - t * (46.815 + t * (0.00059 - t * 0.001813));
  const obliquity = (23 + (26 + seconds / 60) / 60 + 0.00256 * Math.cos(omega)) * kRad;
  const declination = Math.asin(Math.sin(obliquity) * Math.sin(longitude));
  const ascension = Math.atan2(Math.cos(obliquity) * Math.sin(longitude), Math.cos(longitude));
  // Step 3: the hour angle from sidereal time, then to the horizon.
  const siderealDeg = wrapDeg(
    280.46061837 + 360.98564736629 * (day - 2_451_545) + t * t * (0.000387933 - t / 38_710_000),
  );
  const hourAngle = (siderealDeg + place.lonDeg) * kRad - ascension;
  const lat = place.latDeg * kRad;
  const altitudeDeg =
    Math.asin(
      Math.sin(lat) * Math.sin(declination) +
        Math.cos(lat) * Math.cos(declination) * Math.cos(hourAngle),
    ) / kRad;
  const azimuthDeg =
    Math.atan2(
      Math.sin(hourAngle),
      Math.cos(hourAngle) * Math.sin(lat) - Math.tan(declination) * Math.cos(lat),
    ) / kRad;
  return {
    altitudeDeg: altitudeDeg + refractionDeg(altitudeDeg),
    azimuthDeg: wrapDeg(azimuthDeg + 180 - place.convergenceDeg),
  };
}

// Refraction at sea level from the true altitude (NOAA's piecewise fit).
function refractionDeg(altitudeDeg: number): number {
  if (altitudeDeg > 85) return 0;
  const t = Math.tan(altitudeDeg * kRad);
  if (altitudeDeg > 5) return (58.1 / t - 0.07 / t ** 3 + 0.000086 / t ** 5) / 3600;
  if (altitudeDeg <= -0.575) return -20.774 / t / 3600;
  const a = altitudeDeg;
  return (1735 + a * (-518.2 + a * (103.4 + a * (-12.79 + a * 0.711)))) / 3600;
}
