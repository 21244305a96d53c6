#include "raytracer/analyse/solar/energy.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "common/util/numbers.hpp"
#include "common/util/text.hpp"
#include "raytracer/analyse/solar/light_sums.hpp"
#include "raytracer/analyse/solar/sky_light.hpp"

namespace terravox::solar {
namespace {

/// Points of a spiral: each has the same height of the half sphere, and so the same solid angle.
std::vector<core::Vec3> sky_directions(int count) {
    constexpr double kGoldenAngle = 2.39996322972865332;
    std::vector<core::Vec3> out;
    out.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        const double y = (i + 0.5) / count;
        const det::SinCos azimuth = det::sin_cos(i * kGoldenAngle);
        const double level = std::sqrt(1 - y * y);
        out.push_back({level * azimuth.cos, y, level * azimuth.sin});
    }
    return out;
}

}  // namespace

Energy make_energy(const scene::Scene& scene, const geo::MapPlace* place, double height_m) {
    if (!scene.analysis.light.empty()) {
        Energy given = parse_light(scene.analysis.light);
        given.sky = sky_directions(scene.analysis.directions);
        return given;
    }
    if (place == nullptr)
        throw util::UsageError(
            "light the sky: the world has no place on Earth; allowed: worlds "
            "with a CRS");
    const std::array<double, 12> linke = parse_linke(scene.analysis.linke);
    LightSums sums(scene, *place);
    each_sun_step(scene, *place, [&](const SunStep& step) {
        const double haze = linke[static_cast<std::size_t>(step.clock.month - 1)];
        sums.add(step, clear_sky(step.sun.altitude_deg, haze, height_m, day_number(step.clock)),
                 step.hours);
    });
    Energy out = sums.take();
    out.sky = sky_directions(scene.analysis.directions);
    return out;
}

namespace {

// Of a period of 200 years in the desert, and some more.
constexpr double kMax = 1e6;

constexpr const char* kAllowed =
    "isotropic,horizon,through_crowns;x,y,z,beam,around_sun,hours,through_crowns;... with up to "
    "4096 directions of unit length above the horizon, finite light that is not negative, and "
    "shares of "
    "0 to 1";

void append(std::string& out, char before, double value) {
    if (before != '\0')
        out += before;
    out += util::number_text(static_cast<float>(value));
}

/// Takes `count` numbers of at most kMax from the front of a text, up to the next ';' or its end.
template <std::size_t kCount>
std::optional<std::array<double, kCount>> take(std::string_view& text) {
    std::array<double, kCount> out{};
    for (std::size_t i = 0; i < kCount; ++i) {
        const auto value = util::take_number<float>(text);
        if (!value || !(std::abs(static_cast<double>(*value)) <= kMax))
            return std::nullopt;
        out[i] = static_cast<double>(*value);
        const bool is_last = i + 1 == kCount;
        if (is_last && text.empty())
            return out;
        if (!util::take(text, is_last ? ';' : ','))
            return std::nullopt;
    }
    // What follows ';' is another entry.
    return text.empty() ? std::nullopt : std::optional(out);
}

bool is_share(double value) noexcept {
    return value >= 0 && value <= 1;
}

std::optional<LightDirection> take_direction(std::string_view& text) {
    const auto found = take<7>(text);
    if (!found)
        return std::nullopt;
    const auto& [x, y, z, beam, around_sun, hours, through_crowns] = *found;
    constexpr double kRounding = 1e-5;
    const double length = std::sqrt(x * x + y * y + z * z);
    if (!(std::abs(length - 1) <= kRounding) || !(y > 0) || beam < 0 || around_sun < 0 ||
        hours < 0 || !is_share(through_crowns))
        return std::nullopt;
    return LightDirection{core::normalized({x, y, z}), beam, around_sun, hours, through_crowns};
}

[[noreturn]] void refuse(const std::string& text) {
    constexpr std::size_t kShown = 80;
    throw util::UsageError("light the sky: analysis.light = '" + text.substr(0, kShown) +
                           (text.size() > kShown ? "...'" : "'") + "; allowed: " + kAllowed);
}

}  // namespace

std::string to_text(const Energy& light) {
    if (light.sun.size() > kMaxListedDirections)
        throw util::UsageError("sum up the light: " + std::to_string(light.sun.size()) +
                               " directions; allowed: up to " +
                               std::to_string(kMaxListedDirections) +
                               ", by a larger analysis.bin_deg");
    std::string out;
    append(out, '\0', light.isotropic);
    append(out, ',', light.horizon);
    append(out, ',', light.through_crowns);
    for (const LightDirection& from : light.sun) {
        append(out, ';', from.to.x);
        for (const double value :
             {from.to.y, from.to.z, from.beam, from.around_sun, from.hours, from.through_crowns})
            append(out, ',', value);
    }
    return out;
}

Energy parse_light(const std::string& text) {
    std::string_view rest = text;
    const auto even = take<3>(rest);
    if (!even || even->front() < 0 || !is_share(even->back()))
        refuse(text);
    Energy out;
    out.isotropic = (*even)[0];
    out.horizon = (*even)[1];
    out.through_crowns = (*even)[2];
    while (!rest.empty()) {
        const auto direction = take_direction(rest);
        if (!direction || out.sun.size() == kMaxListedDirections)
            refuse(text);
        out.sun.push_back(*direction);
    }
    return out;
}

}  // namespace terravox::solar
