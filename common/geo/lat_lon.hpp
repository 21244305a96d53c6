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

}  // namespace terravox::geo
