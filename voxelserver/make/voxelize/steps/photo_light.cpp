#include "voxelserver/make/voxelize/steps/photo_light.hpp"

#include <algorithm>
#include <cstdint>

#include "common/voxel/bytes.hpp"

namespace terravox::voxelize {
namespace {

using sunlight::Light;

/// To be raised when the layout changes.
constexpr std::uint32_t kVersion = 1;

void put(voxel::ByteWriter& out, const sunlight::Sun& sun) {
    out.add(sun.azimuth_deg);
    out.add(sun.altitude_deg);
}

sunlight::Sun sun_of(voxel::ByteReader& in) {
    const auto azimuth_deg = in.get<double>();
    return {azimuth_deg, in.get<double>()};
}

Light light_of(voxel::ByteReader& in) {
    Light out{};
    for (float& value : out)
        value = in.get<float>();
    return out;
}

bool is_sound(const sunlight::Sun& sun) noexcept {
    return sun.azimuth_deg >= 0 && sun.azimuth_deg <= 360 && sun.altitude_deg > 0 &&
           sun.altitude_deg < 90;
}

bool all_within(const auto& values, float least, float most) noexcept {
    return std::all_of(values.begin(), values.end(),
                       [&](float v) { return v >= least && v <= most; });
}

/// Also false for values that are not numbers.
bool is_sound(const PhotoLight& found) noexcept {
    constexpr float kLeastSky = 0.01F;
    constexpr float kMost = 1e4F;
    constexpr double kMostCorrelation = 1.001;  // rounded
    const sunlight::FlightLight& light = found.light;
    const sunlight::SunEstimate& estimate = found.estimate;
    return (!light.sun || is_sound(*light.sun)) && is_sound(estimate.sun) &&
           estimate.correlation >= -kMostCorrelation && estimate.correlation <= kMostCorrelation &&
           estimate.margin >= 0 && estimate.margin <= 1 && all_within(light.sky, kLeastSky, 1) &&
           all_within(light.veil, 0, 1) && all_within(light.gain, 1 / kMost, kMost) &&
           all_within(light.typical, 0, kMost);
}

}  // namespace

std::string to_bytes(const PhotoLight& found) {
    const sunlight::FlightLight& light = found.light;
    voxel::ByteWriter out;
    out.add(kVersion);
    out.add(static_cast<std::uint8_t>(light.sun.has_value()));
    put(out, light.sun.value_or(sunlight::Sun{}));
    for (const Light& values : {light.sky, light.veil, light.gain})
        for (const float value : values)
            out.add(value);
    for (const float value : light.typical)
        out.add(value);
    put(out, found.estimate.sun);
    out.add(found.estimate.correlation);
    out.add(found.estimate.margin);
    return out.bytes();
}

std::optional<PhotoLight> photo_light_of(std::string_view bytes) {
    voxel::ByteReader in(bytes);
    if (in.get<std::uint32_t>() != kVersion)
        return std::nullopt;
    PhotoLight out;
    const auto has_sun = in.get<std::uint8_t>();
    const sunlight::Sun sun = sun_of(in);
    if (has_sun > 1)
        return std::nullopt;
    if (has_sun == 1)
        out.light.sun = sun;
    for (Light* values : {&out.light.sky, &out.light.veil, &out.light.gain})
        *values = light_of(in);
    for (float& value : out.light.typical)
        value = in.get<float>();
    out.estimate.sun = sun_of(in);
    out.estimate.correlation = in.get<double>();
    out.estimate.margin = in.get<double>();
    return in.finished() && is_sound(out) ? std::optional(out) : std::nullopt;
}

}  // namespace terravox::voxelize
