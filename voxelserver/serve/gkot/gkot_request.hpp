#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace terravox::gkot {

inline constexpr int kMaxSide = 512;  ///< edge of a box, voxels
/// Volume of a box: 64 MiB of words.
inline constexpr std::int64_t kMaxVoxels = std::int64_t{16} << 20;
/// Absolute limits of an origin's coordinates and height.
inline constexpr double kMaxCoordinate = 1e9;
inline constexpr double kMaxHeight_m = 1e6;
inline constexpr std::size_t kMaxQueryBytes = 2048;

/// The origin of box (0, 0, 0) in CRS units (metres in the first system). Decimals are significant;
/// the first system truncated them to integers.
struct OriginRequest {
    double tmx = 0;  ///< easting
    double tmy = 0;  ///< northing
};

/// The box (x, y, z) of sx * sy * sz voxels, counted from the origin: x east, y up, z south.
struct BoxRequest {
    OriginRequest origin;
    std::optional<double> tmz;  ///< height of y = 0, metres; nullopt = automatic (gkot_reply.hpp)
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    /// Powers of two in [1, kMaxSide]; their product at most kMaxVoxels.
    std::int32_t sx = 0;
    std::int32_t sy = 0;
    std::int32_t sz = 0;
};

/// Parses the query of /gkot/origin.json: tmx, tmy. Unknown names are ignored here and below: old
/// clients send arbitrary parameters, such as numbers to defeat caches.
/// @param query the part after the '?', percent-encoded as in a URL
/// @throws UsageError: attempt, parameter, value, allowed range; for parameters that are missing,
/// repeated, badly encoded, not finite numbers, or out of range; and for a query longer than
/// kMaxQueryBytes
[[nodiscard]] OriginRequest parse_origin_request(std::string_view query);

/// Parses the query of /gkot/box: format (must be "raw"), tmx, tmy, tmz (optional), x, y, z, sx,
/// sy, sz.
/// @throws as above
[[nodiscard]] BoxRequest parse_box_request(std::string_view query);

}  // namespace terravox::gkot
