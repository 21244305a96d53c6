#include "raytracer/analyse/solar/analysis_place.hpp"

#include <cmath>
#include <string>

#include "common/util/error.hpp"

namespace terravox::solar {

std::optional<geo::MapPlace> place_of(const scene::Scene& scene,
                                      const std::optional<geo::MapPlace>& centre) {
    if (!scene.analysis.place || scene.analysis.kind == core::AnalysisKind::kNone)
        return centre;
    const auto& [lat_deg, lon_deg, convergence_deg] = *scene.analysis.place;
    if (!(std::abs(lat_deg) <= 90 && std::abs(lon_deg) <= 180 && std::abs(convergence_deg) <= 180))
        throw util::UsageError(
            "place the sun: analysis.place = " + std::to_string(lat_deg) + "," +
            std::to_string(lon_deg) + "," + std::to_string(convergence_deg) +
            "; allowed: a latitude of -90 to 90, a longitude and a convergence of -180 to 180");
    geo::MapPlace out;
    out.lat_deg = lat_deg;
    out.lon_deg = lon_deg;
    out.convergence_deg = convergence_deg;
    return out;
}

}  // namespace terravox::solar
