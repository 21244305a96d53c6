#include "voxelserver/tools/survey/building.hpp"

namespace terravox::survey {
namespace {

constexpr double kMerlon_m = 0.9;  ///< height of a battlement

bool separated_along(Vec2 axis, const Building& a, const Building& b, double margin_m) noexcept {
    const auto reach = [&](const Building& x) {
        return std::abs(dot(axis, x.direction)) * (x.half_length_m + margin_m) +
               std::abs(dot(axis, left_of(x.direction))) * (x.half_width_m + margin_m);
    };
    return std::abs(dot(axis, b.centre - a.centre)) > reach(a) + reach(b);
}

}  // namespace

const char* name_of(RoofType type) noexcept {
    constexpr std::array kNames = {"gable", "hip", "flat", "pyramid", "cone"};
    return kNames[static_cast<std::size_t>(type)];
}

const char* name_of(RoofColour colour) noexcept {
    constexpr std::array kNames = {"red", "grey", "pale", "copper"};
    return kNames[static_cast<std::size_t>(colour)];
}

const char* name_of(BuildingUse use) noexcept {
    constexpr std::array kNames = {"house",  "shed",    "farm",    "hotel",  "church",
                                   "castle", "balcony", "carport", "canopy", "passage"};
    return kNames[static_cast<std::size_t>(use)];
}

std::optional<double> Building::top_m(Vec2 p) const noexcept {
    const Vec2 from = p - centre;
    const double along = std::abs(dot(from, direction));
    const double across = std::abs(dot(from, left_of(direction)));
    if (along > half_length_m || across > half_width_m)
        return std::nullopt;
    const double rise = ridge_m - eaves_m;
    switch (roof) {
        case RoofType::kGable: return eaves_m + rise * (1.0 - across / half_width_m);
        case RoofType::kHip: {
            const double to_eaves = std::min(half_width_m - across, half_length_m - along);
            return eaves_m + rise * std::min(1.0, to_eaves / half_width_m);
        }
        case RoofType::kPyramid:
            return eaves_m + rise * (1.0 - std::max(along / half_length_m, across / half_width_m));
        case RoofType::kCone: {
            const double part = length(from) / half_width_m;
            if (part > 1.0)
                return std::nullopt;
            return eaves_m + rise * (1.0 - part);
        }
        case RoofType::kFlat: break;
    }
    const double step = (along + 1000.0) * 0.5;  // merlons and gaps of 2 m each
    return battlements && step - std::floor(step) < 0.5 ? eaves_m + kMerlon_m : eaves_m;
}

std::array<Vec2, 4> Building::corners(double margin_m) const noexcept {
    const Vec2 a = direction * (half_length_m + margin_m);
    const Vec2 b = left_of(direction) * (half_width_m + margin_m);
    return {centre - a - b, centre + a - b, centre + a + b, centre - a + b};
}

std::vector<Vec2> Building::outline() const {
    if (roof != RoofType::kCone) {
        const auto four = corners();
        return {four.begin(), four.end()};
    }
    constexpr double kCos30 = 0.8660254037844386;
    std::vector<Vec2> ring;
    Vec2 arm = direction * half_width_m;
    for (int i = 0; i < 12; ++i) {
        ring.push_back(centre + arm);
        arm = arm * kCos30 + left_of(arm) * 0.5;
    }
    return ring;
}

Box2 Building::bounds() const noexcept {
    Box2 box{centre.x, centre.y, centre.x, centre.y};
    for (const Vec2 corner : corners()) {
        box.x0 = std::min(box.x0, corner.x);
        box.x1 = std::max(box.x1, corner.x);
        box.y0 = std::min(box.y0, corner.y);
        box.y1 = std::max(box.y1, corner.y);
    }
    return box;
}

bool footprints_overlap(const Building& a, const Building& b, double margin_m) noexcept {
    for (const Vec2 axis : {a.direction, left_of(a.direction), b.direction, left_of(b.direction)})
        if (separated_along(axis, a, b, margin_m))
            return false;
    return true;
}

}  // namespace terravox::survey
