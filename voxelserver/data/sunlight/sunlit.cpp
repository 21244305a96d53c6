#include "voxelserver/data/sunlight/sunlit.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"

namespace terravox::sunlight {
namespace {

constexpr double kDegree = det::kPi / 180;

}  // namespace

std::vector<float> horizons(const Surface& surface, double azimuth_deg) {
    const double east = det::sin(azimuth_deg * kDegree);
    const double south = -det::cos(azimuth_deg * kDegree);
    std::vector<float> out(surface.size(), 0.0F);
    struct Step {
        int dx;
        int dz;
        float per_run;
    };
    std::vector<Step> steps;
    for (int step = 1; step <= surface.margin; ++step)
        steps.push_back({static_cast<int>(std::floor(step * east + 0.5)),
                         static_cast<int>(std::floor(step * south + 0.5)),
                         static_cast<float>(1 / (step * surface.cell_m))});
    // Step by step over a row: its cells are independent of each other, and stay in the cache.
    const int count = surface.width - 2 * surface.margin;
    for (int z = surface.margin; z < surface.height - surface.margin; ++z)
        for (const Step& step : steps) {
            const float* own = &surface.top_m[surface.index(surface.margin, z)];
            const float* there =
                &surface.top_m[surface.index(surface.margin + step.dx, z + step.dz)];
            float* horizon = &out[surface.index(surface.margin, z)];
            for (int x = 0; x < count; ++x)
                horizon[x] = std::max(horizon[x], (there[x] - own[x]) * step.per_run);
        }
    return out;
}

Sunlit::Sunlit(double altitude_deg) noexcept {
    constexpr double kHalfSoft_deg = 1;
    const double rise = det::tan(altitude_deg * kDegree);
    m_rise = static_cast<float>(rise);
    m_sharpness = static_cast<float>(0.5 / (kHalfSoft_deg * kDegree * (1 + rise * rise)));
}

Facing::Facing(const Sun& sun) noexcept {
    const double rise = det::tan(sun.altitude_deg * kDegree);
    m_east = static_cast<float>(det::sin(sun.azimuth_deg * kDegree) / rise);
    m_south = static_cast<float>(-det::cos(sun.azimuth_deg * kDegree) / rise);
}

}  // namespace terravox::sunlight
