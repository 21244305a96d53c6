#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"

namespace terravox::geo {

enum class ShapeKind : std::uint8_t { kPoint, kLine, kPolygon };

/// A point, a line, or a polygon of a GeoJSON file; of Multi... geometries each part is one.
struct Shape {
    /// x, y, and the third coordinate as it is in the file; NaN: none.
    using Position = std::array<double, 3>;
    ShapeKind kind = ShapeKind::kPoint;
    /// Of a polygon: its border and its holes; of others: one. Never empty, nor are its members.
    std::vector<std::vector<Position>> parts;
    /// Properties of the feature that are numbers, or texts of one in metres, "7" or "7 m", as
    /// OpenStreetMap has them; shared by its shapes.
    std::shared_ptr<const std::map<std::string, double>> numbers;
    std::size_t feature = 0;  ///< its number in the file, from 0

    /// @return NaN where there is no such property
    [[nodiscard]] double number(const std::string& name) const {
        if (!numbers)
            return std::numeric_limits<double>::quiet_NaN();
        const auto found = numbers->find(name);
        return found == numbers->end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
    }
};

/// What a GeoJSON file may hold.
inline constexpr std::size_t kMaxGeoJson_bytes = std::size_t{16} << 20;
inline constexpr std::size_t kMaxGeoJsonPositions = 100'000;

/// Reads the shapes of a GeoJSON file into a CRS. Positions are longitude and latitude (RFC 7946)
/// unless a member "crs" names another system, as GIS programs write it.
/// @throws Error naming the file when it cannot be read, is no GeoJSON, holds more than the limits
/// above, or lies outside of the domain of a CRS; "interrupted" when stopped
[[nodiscard]] std::vector<Shape> read_geojson(const std::filesystem::path& file, const Crs& to,
                                              const std::stop_token& stop = {});

}  // namespace terravox::geo
