#include "common/geo/lat_lon.hpp"

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/TransverseMercator.hpp>

namespace terravox::geo {
namespace {

constexpr double kCentralMeridianDeg = 15;
constexpr double kScale = 0.9999;
constexpr double kFalseEastingM = 500'000;
constexpr double kFalseNorthingM = -5'000'000;
constexpr double kGrs80RadiusM = 6'378'137;
constexpr double kGrs80Flattening = 1 / 298.257222101;

const GeographicLib::TransverseMercator& d96tm() {
    static const GeographicLib::TransverseMercator projection(kGrs80RadiusM, kGrs80Flattening,
                                                              kScale);
    return projection;
}

}  // namespace

LocalFrame::LocalFrame(LatLon origin, double height_m) : m_origin(origin), m_height_m(height_m) {}

EastNorthUp LocalFrame::to_local(LatLon place, double height_m) const {
    const GeographicLib::LocalCartesian frame(m_origin.lat_deg, m_origin.lon_deg, m_height_m);
    EastNorthUp out;
    frame.Forward(place.lat_deg, place.lon_deg, height_m, out.east_m, out.north_m, out.up_m);
    return out;
}

LatLon LocalFrame::to_lat_lon(const EastNorthUp& local, double& height_m) const {
    const GeographicLib::LocalCartesian frame(m_origin.lat_deg, m_origin.lon_deg, m_height_m);
    LatLon out;
    frame.Reverse(local.east_m, local.north_m, local.up_m, out.lat_deg, out.lon_deg, height_m);
    return out;
}

Projected d96tm_from_lat_lon(LatLon place) {
    double x = 0;
    double y = 0;
    d96tm().Forward(kCentralMeridianDeg, place.lat_deg, place.lon_deg, x, y);
    return {x + kFalseEastingM, y + kFalseNorthingM};
}

LatLon d96tm_to_lat_lon(Projected point) {
    LatLon out;
    d96tm().Reverse(kCentralMeridianDeg, point.easting_m - kFalseEastingM,
                    point.northing_m - kFalseNorthingM, out.lat_deg, out.lon_deg);
    return out;
}

}  // namespace terravox::geo
