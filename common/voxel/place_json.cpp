#include "common/voxel/place_json.hpp"

#include <string>

#include "common/util/error.hpp"

namespace terravox::voxel {
namespace {

double angle(const nlohmann::json& in, const char* name, double limit_deg) {
    const auto value = in.at(name).get<double>();
    if (!(value >= -limit_deg && value <= limit_deg))
        throw util::Error("read the centre of a world: " + std::string(name) + " = " +
                          std::to_string(value) +
                          "; allowed: " + std::to_string(static_cast<int>(-limit_deg)) + " to " +
                          std::to_string(static_cast<int>(limit_deg)));
    return value;
}

}  // namespace

nlohmann::json place_to_json(const geo::MapPlace& place) {
    return {{"lat_deg", place.lat_deg},
            {"lon_deg", place.lon_deg},
            {"convergence_deg", place.convergence_deg}};
}

geo::MapPlace place_from_json(const nlohmann::json& json) {
    geo::MapPlace out{{angle(json, "lat_deg", 90), angle(json, "lon_deg", 360)}, 0};
    if (json.contains("convergence_deg"))
        out.convergence_deg = angle(json, "convergence_deg", 360);
    return out;
}

}  // namespace terravox::voxel
