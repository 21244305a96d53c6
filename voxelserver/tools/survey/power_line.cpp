#include "voxelserver/tools/survey/power_line.hpp"

namespace terravox::survey {
namespace {

constexpr double kSouthOfRiver_m = 208;
constexpr double kSag_m = 4.5;
constexpr double kArmDepth_m = 1.2;

// Masts stand at multiples of the span in x; the line follows the large bends of the river.
Vec2 find_foot(const River& river, std::int64_t number) {
    const double x = static_cast<double>(number) * kPylonSpan_m + 40.0;
    double y = 0;
    for (int k = -2; k <= 2; ++k)
        y += river.centre_y(x + 120.0 * k) / 5.0;
    return {x, y - kSouthOfRiver_m};
}

void add_wires(const Pylon& a, const Pylon& b, PowerLine& line) {
    for (const double side : {-1.0, 0.0, 1.0}) {
        const double drop = side == 0.0 ? 0.0 : 1.0;
        line.wires.push_back({a.at + turn_left(a.along) * (side * kPylonArm_m),
                              b.at + turn_left(b.along) * (side * kPylonArm_m), a.top_m - drop,
                              b.top_m - drop, side == 0.0 ? 0.7 * kSag_m : kSag_m});
    }
}

}  // namespace

double Pylon::half_width_m(double height_m) const noexcept {
    return lerp(1.7, 0.4, std::clamp((height_m - ground_m) / (top_m - ground_m), 0.0, 1.0));
}

bool Pylon::holds(Vec2 p, double height_m) const noexcept {
    const Vec2 from = p - at;
    const double forward = std::abs(dot(from, along));
    const double sideways = std::abs(dot(from, turn_left(along)));
    const bool arm = height_m > top_m - 1.0 - kArmDepth_m && height_m < top_m - 1.0 &&
                     sideways < kPylonArm_m && forward < 0.5;
    const double half = half_width_m(height_m);
    return arm || (forward < half && sideways < half);
}

PowerLine build_power_line(const Terrain& terrain, const Box2& area) {
    PowerLine line;
    const auto first = static_cast<std::int64_t>(std::floor(area.x0 / kPylonSpan_m)) - 1;
    const auto last = static_cast<std::int64_t>(std::floor(area.x1 / kPylonSpan_m)) + 1;
    for (const River& river : terrain.rivers()) {
        const double y = river.centre_y(0.5 * (area.x0 + area.x1));
        if (y < area.y0 - 2 * kRiverSway_m - kSouthOfRiver_m ||
            y > area.y1 + 2 * kRiverSway_m + kSouthOfRiver_m)
            continue;
        std::vector<Pylon> row;
        for (auto i = first; i <= last; ++i) {
            Pylon pylon;
            pylon.at = find_foot(river, i);
            pylon.along = unit(find_foot(river, i + 1) - find_foot(river, i - 1));
            pylon.ground_m = terrain.at(pylon.at).ground_m;
            pylon.top_m = pylon.ground_m + kPylonHeight_m;
            if (!row.empty())
                add_wires(row.back(), pylon, line);
            row.push_back(pylon);
        }
        line.pylons.insert(line.pylons.end(), row.begin(), row.end());
    }
    return line;
}

}  // namespace terravox::survey
