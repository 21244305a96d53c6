#include "voxelserver/serve/http/squares.hpp"

#include <nlohmann/json.hpp>

#include "voxelserver/serve/http/message.hpp"

namespace terravox::http {

using nlohmann::json;

std::string squares_json(const std::vector<SquareEntry>& squares, const voxel::WorldInfo& info) {
    json features = json::array();
    for (const SquareEntry& s : squares) {
        const double west = s.min_x * info.crs_units_per_voxel;
        const double east = s.max_x * info.crs_units_per_voxel;
        const double north = -s.min_z * info.crs_units_per_voxel;
        const double south = -s.max_z * info.crs_units_per_voxel;
        const double area_m2 = (static_cast<double>(s.max_x) - s.min_x) *
                               (static_cast<double>(s.max_z) - s.min_z) * info.voxel_m *
                               info.voxel_m;
        const auto text = [](const std::optional<std::string>& t) { return t ? json(*t) : json(); };
        const json density =
            s.points && area_m2 > 0 ? json(static_cast<double>(*s.points) / area_m2) : json();
        features.push_back(
            {{"type", "Feature"},
             {"geometry",
              {{"type", "Polygon"},
               {"coordinates",
                {{{west, south}, {east, south}, {east, north}, {west, north}, {west, south}}}}}},
             {"properties",
              {{"name", s.name},
               {"state", s.state},
               {"file", text(s.file)},
               {"points", s.points ? json(*s.points) : json()},
               {"density_per_m2", density},
               {"bytes", s.bytes},
               {"source", s.source},
               {"licence", s.licence},
               {"attribution", s.attribution},
               {"error", s.error ? json(without_folders(*s.error)) : json()}}}});
    }
    const json out = {{"type", "FeatureCollection"}, {"crs", info.crs}, {"features", features}};
    return out.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace terravox::http
