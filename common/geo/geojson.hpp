#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"

namespace terravox::geo {

enum class ShapeKind : std::uint8_t { kPoint, kLine, kPolygon };

/// Properties of a feature that may be lengths.
struct Lengths {
    std::string attempt;  ///< "read the GeoJSON file FILE: feature 7"
    /// Numbers, which are metres, and texts of a number with its unit, as OpenStreetMap has them:
    /// "7 m", "30 ft", "30'", "5'6\"".
    std::map<std::string, double> metres;
    std::map<std::string, std::string> others;  ///< what is there, but says no length
};

/// A point, a line, or a polygon of a GeoJSON file; of Multi... geometries and of collections each
/// part is one.
struct Shape {
    /// x, y, and the third coordinate as it is in the file; NaN: none.
    using Position = std::array<double, 3>;
    ShapeKind kind = ShapeKind::kPoint;
    /// Of a polygon: its border and its holes; of others: one. Never empty, nor are its members.
    std::vector<std::vector<Position>> parts;
    std::shared_ptr<const Lengths> lengths;  ///< shared by all shapes of the feature
    std::size_t feature = 0;                 ///< its number in the file, from 0

    /// @return the property in metres, NaN where there is none
    /// @throws Error naming file, feature and value where it says no length
    [[nodiscard]] double metres(const std::string& name) const;
};

/// What a GeoJSON file may hold.
inline constexpr std::size_t kMaxGeoJson_bytes = std::size_t{16} << 20;
inline constexpr std::size_t kMaxGeoJsonPositions = 100'000;

/// Reads the shapes of a GeoJSON file into a CRS. Positions are longitude and latitude (RFC 7946)
/// unless a member "crs" names another system, as GIS programs write it. Geometries without
/// positions are left out, as RFC 7946 allows. Of a collection, features with geometries of other
/// kinds or without meaning, and those outside of the domain of a CRS, are left out with a warning
/// that names the first; their numbers are not given to others.
/// @throws Error naming the file when it cannot be read, is no GeoJSON, holds more than the limits
/// above, or when what is wrong leaves no shape; "interrupted" when stopped
[[nodiscard]] std::vector<Shape> read_geojson(const std::filesystem::path& file, const Crs& to,
                                              const std::stop_token& stop = {});

}  // namespace terravox::geo
