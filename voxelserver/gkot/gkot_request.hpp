#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace terravox::gkot {

inline constexpr int kMaxSide = 512;                                ///< of a box, voxels
inline constexpr std::int64_t kMaxVoxels = std::int64_t{16} << 20;  ///< of a box: 64 MiB of words
inline constexpr double kMaxCoordinate = 1e9, kMaxHeight_m = 1e6;   ///< of an origin, either sign
inline constexpr std::size_t kMaxQueryBytes = 2048;

/// Where box (0, 0, 0) begins: CRS units (metres in the first system). Decimals count; the first
/// system cut them to integers.
struct OriginRequest {
    double tmx = 0;  ///< easting
    double tmy = 0;  ///< northing
};

/// The box (x, y, z) of sx * sy * sz voxels, counted from the origin: x to the east, y up, z to the
/// south.
struct BoxRequest {
    OriginRequest origin;
    std::optional<double> tmz;  ///< height of y = 0, metres; nullopt = automatic (gkot_origin.hpp)
    std::int32_t x = 0, y = 0, z = 0;
    std::int32_t sx = 0, sy = 0,
                 sz = 0;  ///< powers of two in [1, kMaxSide], together at most kMaxVoxels
};

/// The query of /gkot/origin.json: tmx, tmy. Names that are not known are ignored here and below:
/// old clients send what they like, such as numbers against caches.
/// @param query what follows the '?', percent-encoded as in a URL
/// @throws UsageError: attempt, parameter, value, allowed range; for parameters that are missing,
/// there twice, badly encoded, no finite
///         numbers, or out of range; and for a query longer than kMaxQueryBytes
[[nodiscard]] OriginRequest parse_origin_request(std::string_view query);

/// The query of /gkot/box: format (must be "raw"), tmx, tmy, tmz (may be left out), x, y, z, sx,
/// sy, sz. @throws as above
[[nodiscard]] BoxRequest parse_box_request(std::string_view query);

}  // namespace terravox::gkot
