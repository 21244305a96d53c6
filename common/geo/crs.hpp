#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/geo/lat_lon.hpp"

class OGRSpatialReference;
class OGRCoordinateTransformation;

namespace terravox::geo {

/// A coordinate reference system, built from a name, WKT or GeoTIFF keys. A value type; copying is
/// cheap. The axis order is always easting, northing (longitude, latitude), whatever the authority
/// defines.
class Crs {
public:
    /// Parses text that a user entered. No text can make PROJ open a file or access the network
    /// (crs_text.hpp).
    /// @param text EPSG:n (ESRI, IGNF and OGC too, EPSG:n+m with a vertical system), WKT 1 or 2, or
    /// a PROJ string
    /// @throws UsageError naming the text when it is refused or cannot be parsed
    static Crs from_text(const std::string& text);

    /// Parses text that was read from a file or received from another program.
    /// @param wkt WKT 1 or 2, and nothing else
    /// @throws Error naming the text when it is refused or cannot be parsed
    static Crs from_wkt(const std::string& wkt);

    /// Wraps a system that GDAL has read, e.g. that of an image.
    /// @param origin where the system comes from, for messages: a file's name
    /// @throws Error naming the origin when the system names files for PROJ to open
    static Crs from_ogr(const OGRSpatialReference& ogr, const std::string& origin);

    /// Reads the three GeoTIFF VLRs of a LAS file (LASF_Projection 34735, 34736, 34737); the last
    /// two may be empty.
    /// @return nullopt when the keys name no system
    /// @throws Error when the system names files for PROJ to open
    static std::optional<Crs> from_geokeys(std::span<const std::uint16_t> directory,
                                           std::span<const double> doubles,
                                           std::span<const char> ascii);

    [[nodiscard]] const OGRSpatialReference& ogr() const noexcept { return *m_ogr; }
    /// "EPSG:3794" when an authority is known, else the CRS's own name.
    [[nodiscard]] std::string name() const;
    [[nodiscard]] std::string wkt() const;  ///< WKT 2 (2019), one line
    /// Whether coordinates are in degrees.
    [[nodiscard]] bool geographic() const noexcept { return m_geographic; }
    /// Whether this is EPSG:3857 or an equivalent: lengths are stretched by 1 / cos(latitude).
    [[nodiscard]] bool pseudo_mercator() const;
    /// Metres per horizontal unit; 1 for geographic systems.
    [[nodiscard]] double metres_per_unit() const noexcept { return m_metres_per_unit; }
    /// Metres per vertical unit; nullopt when the system has no vertical part.
    [[nodiscard]] std::optional<double> vertical_metres_per_unit() const noexcept {
        return m_vertical_metres;
    }
    /// The reference of heights, when the system defines it: the name of its vertical datum, or
    /// "ellipsoid" for a three-dimensional system.
    [[nodiscard]] std::optional<std::string> vertical_datum() const;
    [[nodiscard]] bool same_horizontal(const Crs& other) const;

private:
    explicit Crs(std::shared_ptr<const OGRSpatialReference> ogr);
    std::shared_ptr<const OGRSpatialReference> m_ogr;
    // Asked once: GDAL keeps answers in the object, without a lock, and copies share it.
    bool m_geographic = false;
    double m_metres_per_unit = 1;
    std::optional<double> m_vertical_metres;
};

/// Transforms horizontal coordinates between two systems. Not thread-safe: use one per thread.
class Transform {
public:
    /// @throws Error when PROJ has no operation between the two systems
    Transform(const Crs& from, const Crs& to);
    ~Transform();
    Transform(Transform&&) noexcept;
    Transform& operator=(Transform&&) noexcept;

    /// Transforms in place.
    /// @throws Error when a point lies outside the domain of either system
    void apply(std::span<double> x, std::span<double> y) const;

    /// The least rectangle in the other system around one of this, both as west, south, east,
    /// north; up to what its edges bend between a few points.
    /// @throws Error as apply()
    [[nodiscard]] std::array<double, 4> around(const std::array<double, 4>& rect) const;

private:
    std::string m_between;  ///< "A to B", for messages
    std::unique_ptr<OGRCoordinateTransformation> m_ogr;
};

/// @throws Error outside the domain of `crs`
[[nodiscard]] LatLon to_lat_lon(const Crs& crs, double easting, double northing);

/// A place of a map, with the map's direction there: that of the short line on the ellipsoid
/// between two points of the map, 10 units south and north of it. Rounded to 1e-8 degrees, and the
/// direction to 1e-6, so that all versions of PROJ say the same.
/// @throws Error outside the domain of `crs`
[[nodiscard]] MapPlace map_place(const Crs& crs, double easting, double northing);

}  // namespace terravox::geo
