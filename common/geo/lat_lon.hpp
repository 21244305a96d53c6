#pragma once

namespace terravox::geo {

/// A point on the ellipsoid (EPSG:4326).
struct LatLon {
    double lat_deg = 0;
    double lon_deg = 0;
};

/// A place of a map: where it is on Earth, and how the map is turned there.
struct MapPlace : LatLon {
    /// Meridian convergence: the azimuth of the map's north (that of its grid), clockwise from true
    /// north, (-180, 180].
    double convergence_deg = 0;
};

/// A point on the local tangent plane, in metres east, north and up of its origin; free of
/// distortion near the origin.
struct EastNorthUp {
    double east_m = 0;
    double north_m = 0;
    double up_m = 0;
};

/// A local frame at a place on the WGS 84 ellipsoid (GeographicLib's LocalCartesian). Immutable,
/// thread-safe.
class LocalFrame {
public:
    /// @param height_m above the ellipsoid
    LocalFrame(LatLon origin, double height_m);
    [[nodiscard]] EastNorthUp to_local(LatLon place, double height_m) const;
    /// @param[out] height_m above the ellipsoid
    [[nodiscard]] LatLon to_lat_lon(const EastNorthUp& local, double& height_m) const;

private:
    LatLon m_origin;
    double m_height_m;
};

/// Easting and northing in metres.
struct Projected {
    double easting_m = 0;
    double northing_m = 0;
};

/// D96/TM (EPSG:3794), the system of Slovenia's LiDAR squares: transverse Mercator on GRS 80,
/// central meridian 15 degrees east, scale 0.9999, false easting 500 km, false northing -5000 km.
/// Exact to nanometres (GeographicLib), without PROJ's database.
[[nodiscard]] Projected d96tm_from_lat_lon(LatLon place);
[[nodiscard]] LatLon d96tm_to_lat_lon(Projected point);

}  // namespace terravox::geo
