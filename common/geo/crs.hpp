#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

class OGRSpatialReference;
class OGRCoordinateTransformation;

namespace terravox::geo {

/// A point on the ellipsoid (EPSG:4326).
struct LatLon {
    double lat_deg = 0;
    double lon_deg = 0;
};

/// A coordinate reference system, from a name, WKT or GeoTIFF keys. A value; copying is cheap. Axis
/// order is always easting, northing (longitude, latitude), whatever the authority says.
class Crs {
public:
    /// What a person says. No text makes PROJ open a file or ask the network, whoever wrote it
    /// (crs_text.hpp).
    /// @param text EPSG:n (ESRI, IGNF and OGC too, EPSG:n+m with a vertical system), WKT 1 or 2, or
    /// a PROJ string
    /// @throws UsageError naming the text when it is refused or not understood
    static Crs from_text(const std::string& text);

    /// What a file or another program says.
    /// @param wkt WKT 1 or 2, and nothing else
    /// @throws Error naming the text when it is refused or not understood
    static Crs from_wkt(const std::string& wkt);

    /// A system that GDAL has read, e.g. of an image.
    /// @param origin of it, for messages: a file's name
    /// @throws Error naming the origin when the system names files for PROJ to open
    static Crs from_ogr(const OGRSpatialReference& ogr, const std::string& origin);

    /// The three GeoTIFF VLRs of a LAS file (LASF_Projection 34735, 34736, 34737); the last two may
    /// be empty.
    /// @return nullopt when the keys name no system
    /// @throws Error when the system names files for PROJ to open
    static std::optional<Crs> from_geokeys(std::span<const std::uint16_t> directory,
                                           std::span<const double> doubles,
                                           std::span<const char> ascii);

    [[nodiscard]] const OGRSpatialReference& ogr() const noexcept { return *m_ogr; }
    [[nodiscard]] std::string name()
        const;  ///< "EPSG:3794" when an authority is known, else the CRS's own name
    [[nodiscard]] std::string wkt() const;  ///< WKT 2 (2019), one line
    [[nodiscard]] bool geographic() const;  ///< coordinates are degrees
    [[nodiscard]] bool pseudo_mercator()
        const;  ///< EPSG:3857 and its twins: lengths are stretched by 1 / cos(latitude)
    [[nodiscard]] double metres_per_unit() const;  ///< horizontal unit; 1 for geographic systems
    /// Vertical unit in metres, when the system has a vertical part.
    [[nodiscard]] std::optional<double> vertical_metres_per_unit() const;
    /// What heights are measured from, when the system says: its vertical datum's name, or
    /// "ellipsoid" for a system of three dimensions.
    [[nodiscard]] std::optional<std::string> vertical_datum() const;
    [[nodiscard]] bool same_horizontal(const Crs& other) const;

private:
    explicit Crs(std::shared_ptr<const OGRSpatialReference> ogr) : m_ogr(std::move(ogr)) {}
    std::shared_ptr<const OGRSpatialReference> m_ogr;
};

/// Transforms horizontal coordinates between two systems. Not thread-safe: one for each thread.
class Transform {
public:
    /// @throws Error when PROJ knows no way between them
    Transform(const Crs& from, const Crs& to);
    ~Transform();
    Transform(Transform&&) noexcept;
    Transform& operator=(Transform&&) noexcept;

    /// In place. @throws Error when a point lies outside the domain of either system
    void apply(std::span<double> x, std::span<double> y) const;

private:
    std::string m_between;  ///< "A to B", for messages
    std::unique_ptr<OGRCoordinateTransformation> m_ogr;
};

/// @throws Error outside the domain of `crs`
[[nodiscard]] LatLon to_lat_lon(const Crs& crs, double easting, double northing);

}  // namespace terravox::geo
