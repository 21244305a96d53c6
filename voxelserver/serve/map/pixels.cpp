#include "voxelserver/serve/map/pixels.hpp"

#include <algorithm>
#include <cmath>

#include "common/png/png.hpp"
#include "common/util/error.hpp"
#include "common/util/linear_light.hpp"

namespace terravox::map {
namespace {

constexpr std::int64_t kMaxStep = 5;  ///< limit of the difference between neighbours, voxels
constexpr float kStrength = 0.5f;     ///< 1 = the shading of a white landscape, 0 = none
constexpr float kDarkest = 0.6f;
constexpr float kBrightestShade = 1.25f;

}  // namespace

std::uint32_t hill_shade(const TopWindow& window) noexcept {
    const auto rise = [&](std::size_t i) {
        if (window[i]->nothing())
            return 0.0f;
        return static_cast<float>(
            std::clamp(std::int64_t{window[i]->y} - window[4]->y, -kMaxStep, kMaxStep));
    };
    const float to_east =
        ((rise(2) + 2 * rise(5) + rise(8)) - (rise(0) + 2 * rise(3) + rise(6))) / 8;
    const float to_south =
        ((rise(6) + 2 * rise(7) + rise(8)) - (rise(0) + 2 * rise(1) + rise(2))) / 8;
    // The normal is (-to_east, 1, -to_south), the direction to the light (-1, sqrt 2, -1) / 2;
    // normalised by the brightness of level ground.
    const float light = (1 + (to_east + to_south) * 0.70710678f) /
                        std::sqrt(1 + to_east * to_east + to_south * to_south);
    const float shade = std::clamp(1 + kStrength * (light - 1), kDarkest, kBrightestShade);
    return static_cast<std::uint32_t>(shade * static_cast<float>(kFlatShade) + 0.5f);
}

Rgba8 shaded_pixel(const TopWindow& window) noexcept {
    const ColumnTop& top = *window[4];
    if (top.nothing())
        return {};
    if (top.material == voxel::Material::kWater)
        return {top.colour.r, top.colour.g, top.colour.b, 255};
    const std::uint32_t shade = hill_shade(window);
    const auto channel = [&](std::uint8_t v) {
        return util::to_srgb((util::to_linear(v) * shade + kFlatShade / 2) / kFlatShade);
    };
    return {channel(top.colour.r), channel(top.colour.g), channel(top.colour.b), 255};
}

std::string to_png(std::span<const Rgba8> pixels, int width, int height) {
    constexpr int kMaxSide = 8192;
    constexpr int kChannels = 4;
    static_assert(sizeof(Rgba8) == kChannels);
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
        throw util::Error("write a PNG of " + std::to_string(width) + " x " +
                          std::to_string(height) + " pixels: allowed: 1 to " +
                          std::to_string(kMaxSide) + " a side");
    const auto* samples = reinterpret_cast<const std::uint8_t*>(pixels.data());
    return png::encode({samples, pixels.size() * kChannels}, {width, height, kChannels});
}

}  // namespace terravox::map
