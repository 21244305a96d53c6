#include "raytracer/analyse/report/band_style.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>

#include "common/voxel/material.hpp"

namespace terravox::analyse {
namespace {

using map::Rgba8;

using Anchors = std::span<const Rgba8>;

constexpr Rgba8 rgb(std::uint8_t r, std::uint8_t g, std::uint8_t b) noexcept {
    return {r, g, b, 255};
}

constexpr Rgba8 kHeightAnchors[] = {rgb(62, 122, 74), rgb(164, 184, 103), rgb(222, 205, 140),
                                    rgb(163, 120, 82), rgb(245, 243, 240)};
// Perceptually even. Ref: viridis and inferno, Smith and van der Walt, 2015 (public domain).
constexpr Rgba8 kMuchAnchors[] = {rgb(68, 1, 84), rgb(59, 82, 139), rgb(33, 145, 140),
                                  rgb(94, 201, 98), rgb(253, 231, 37)};
constexpr Rgba8 kWarmAnchors[] = {rgb(0, 0, 4), rgb(87, 16, 110), rgb(188, 55, 84),
                                  rgb(249, 142, 9), rgb(252, 255, 164)};
constexpr Rgba8 kAroundAnchors[] = {rgb(226, 217, 226), rgb(98, 118, 186), rgb(47, 20, 54),
                                    rgb(178, 84, 82), rgb(226, 217, 226)};
constexpr Rgba8 kGreyAnchors[] = {rgb(0, 0, 0), rgb(255, 255, 255)};

Anchors choose_anchors(Ramp ramp) noexcept {
    switch (ramp) {
        case Ramp::kHeights: return kHeightAnchors;
        case Ramp::kMuch: return kMuchAnchors;
        case Ramp::kWarm: return kWarmAnchors;
        case Ramp::kAround: return kAroundAnchors;
        case Ramp::kGrey:
        case Ramp::kClasses:
        case Ramp::kMaterials: break;
    }
    return kGreyAnchors;
}

struct Category {
    int number;
    std::string_view name;
    Rgba8 colour;
};

// Ref: ASPRS LAS specification 1.4, standard point classes.
constexpr Category kLidarClasses[] = {
    {0, "never classified", rgb(170, 170, 170)},
    {1, "unclassified", rgb(200, 200, 200)},
    {2, "ground", rgb(176, 137, 104)},
    {3, "low vegetation", rgb(188, 221, 138)},
    {4, "medium vegetation", rgb(116, 182, 90)},
    {5, "high vegetation", rgb(40, 120, 60)},
    {6, "building", rgb(205, 80, 70)},
    {7, "low point", rgb(120, 60, 140)},
    {9, "water", rgb(70, 130, 200)},
    {10, "rail", rgb(90, 90, 100)},
    {11, "road surface", rgb(125, 125, 135)},
    {13, "wire, guard", rgb(240, 190, 70)},
    {14, "wire, conductor", rgb(230, 160, 40)},
    {15, "transmission tower", rgb(200, 120, 30)},
    {16, "wire connector", rgb(220, 140, 60)},
    {17, "bridge deck", rgb(150, 110, 160)},
    {18, "high noise", rgb(160, 80, 180)},
};

const Category* lidar_class(int number) noexcept {
    for (const Category& category : kLidarClasses)
        if (category.number == number)
            return &category;
    return nullptr;
}

// Colours without an order, far apart for neighbours: by steps of the golden ratio around the
// circle of hues, at two lightnesses.
Rgba8 colour_by_number(int number) noexcept {
    constexpr double kGolden = 0.6180339887498949;
    const double hue = 6 * (number * kGolden - std::floor(number * kGolden));
    const double high = number % 2 == 0 ? 220 : 160;
    const double low = number % 2 == 0 ? 110 : 60;
    const auto channel = [&](double offset) {
        const double at = std::fmod(hue + offset, 6);
        const double share = std::clamp(std::abs(at - 3) - 1, 0.0, 1.0);
        return static_cast<std::uint8_t>(low + (high - low) * share);
    };
    return rgb(channel(0), channel(4), channel(2));
}

std::uint8_t mixed(std::uint8_t a, std::uint8_t b, double share) noexcept {
    return static_cast<std::uint8_t>(std::lround(a + (static_cast<double>(b) - a) * share));
}

}  // namespace

Rgba8 colour_at(Ramp ramp, double share) noexcept {
    const Anchors anchors = choose_anchors(ramp);
    const auto last = static_cast<double>(anchors.size() - 1);
    const double at = std::clamp(share, 0.0, 1.0) * last;
    const auto below = static_cast<std::size_t>(std::min(std::floor(at), last - 1));
    const double rest = at - static_cast<double>(below);
    const Rgba8& a = anchors[below];
    const Rgba8& b = anchors[below + 1];
    return rgb(mixed(a.r, b.r, rest), mixed(a.g, b.g, rest), mixed(a.b, b.b, rest));
}

Rgba8 colour_of_category(Ramp ramp, int number) noexcept {
    const Category* category = ramp == Ramp::kClasses ? lidar_class(number) : nullptr;
    return category != nullptr ? category->colour : colour_by_number(std::abs(number));
}

std::string name_of_category(Ramp ramp, int number) {
    if (ramp == Ramp::kClasses) {
        const Category* category = lidar_class(number);
        return category != nullptr ? std::string(category->name)
                                   : "class " + std::to_string(number);
    }
    std::string name(voxel::material_name(static_cast<voxel::Material>(number)));
    std::replace(name.begin(), name.end(), '_', ' ');
    return name;
}

}  // namespace terravox::analyse
