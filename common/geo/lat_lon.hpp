#pragma once

namespace terravox::geo {

/// A point on the ellipsoid (EPSG:4326).
struct LatLon {
    double lat_deg = 0;
    double lon_deg = 0;
};

}  // namespace terravox::geo
