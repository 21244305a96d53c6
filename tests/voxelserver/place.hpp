#pragma once

namespace terravox::test {

/// Somewhere in France (EPSG:2154): the tests' places count from here, metres east and north.
inline constexpr double kEast0 = 770'000;
inline constexpr double kNorth0 = 6'277'000;
inline constexpr const char* kCrs = "EPSG:2154";

}  // namespace terravox::test
