#include "raytracer/analyse/solar/sky_light.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "common/util/numbers.hpp"

namespace terravox::solar {
namespace {

constexpr double kRad = det::kPi / 180;
constexpr double kSolarConstant_w_m2 = 1367;
constexpr double kScaleHeight_m = 8434.5;

/// Optical thickness of clean dry air, by the air mass.
double rayleigh_thickness(double mass) noexcept {
    if (mass > 20)
        return 1 / (10.4 + 0.718 * mass);
    return 1 / (6.6296 + mass * (1.7513 + mass * (-0.1202 + mass * (0.0065 - mass * 0.00013))));
}

/// Share of the extraterrestrial light that comes from the sky.
double diffuse_share(double sine, double linke) noexcept {
    const double zenith = -0.015843 + linke * (0.030543 + linke * 0.0003797);
    double a0 = 0.26463 + linke * (-0.061581 + linke * 0.0031408);
    if (a0 * zenith < 0.002)
        a0 = 0.002 / zenith;
    const double a1 = 2.0402 + linke * (0.018945 - linke * 0.011161);
    const double a2 = -1.3025 + linke * (0.039231 + linke * 0.0085079);
    return zenith * (a0 + sine * (a1 + sine * a2));
}

}  // namespace

double extraterrestrial_w_m2(int day_of_year) noexcept {
    constexpr double kDays = 365.25;
    const double angle = 2 * det::kPi * day_of_year / kDays;
    return kSolarConstant_w_m2 * (1 + 0.03344 * det::cos(angle - 0.048869));
}

double air_mass(double altitude_deg) noexcept {
    return 1 /
           (det::sin(altitude_deg * kRad) + 0.50572 * det::pow(altitude_deg + 6.07995, -1.6364));
}

Irradiance clear_sky(double altitude_deg, double linke, double height_m, int day_of_year) noexcept {
    const double outside = extraterrestrial_w_m2(day_of_year);
    const double mass = air_mass(altitude_deg) * det::exp(-height_m / kScaleHeight_m);
    const double beam = outside * det::exp(-0.8662 * linke * mass * rayleigh_thickness(mass));
    const double diffuse = outside * diffuse_share(det::sin(altitude_deg * kRad), linke);
    return {beam, std::max(diffuse, 0.0)};
}

std::array<double, 12> parse_linke(const std::string& text) {
    constexpr std::size_t kMonths = 12;
    std::vector<double> found;
    std::string_view rest = text;
    while (found.size() <= kMonths) {
        const auto value = util::take_number<double>(rest);
        if (!value || !(*value >= 1 && *value <= 10))
            break;
        found.push_back(*value);
        if (!util::take(rest, ','))
            break;
    }
    if (!rest.empty() || text.ends_with(',') || (found.size() != 1 && found.size() != kMonths))
        throw util::UsageError("light the sky: analysis.linke = '" + text +
                               "'; allowed: a number of 1 to 10, or twelve separated by commas, "
                               "January first");
    std::array<double, kMonths> out{};
    for (std::size_t m = 0; m < kMonths; ++m)
        out[m] = found.size() == 1 ? found[0] : found[m];
    return out;
}

namespace {

/// A class of skies from overcast to clear, and its coefficients.
struct SkyClass {
    double max_clearness;
    double f1[3];
    double f2[3];
};
constexpr SkyClass kClasses[] = {
    {1.065, {-0.008, 0.588, -0.062}, {-0.060, 0.072, -0.022}},
    {1.230, {0.130, 0.683, -0.151}, {-0.019, 0.066, -0.029}},
    {1.500, {0.330, 0.487, -0.221}, {0.055, -0.064, -0.026}},
    {1.950, {0.568, 0.187, -0.295}, {0.109, -0.152, -0.014}},
    {2.800, {0.873, -0.392, -0.362}, {0.226, -0.462, 0.001}},
    {4.500, {1.132, -1.237, -0.412}, {0.288, -0.823, 0.056}},
    {6.200, {1.060, -1.600, -0.359}, {0.264, -1.127, 0.131}},
    {1e300, {0.678, -0.327, -0.250}, {0.156, -1.377, 0.251}},
};

const SkyClass& find_class(double clearness) noexcept {
    std::size_t i = 0;
    while (clearness >= kClasses[i].max_clearness && i + 1 < std::size(kClasses))
        ++i;
    return kClasses[i];
}

double weighted(const double (&f)[3], double brightness, double zenith) noexcept {
    return f[0] + f[1] * brightness + f[2] * zenith;
}

}  // namespace

SkyLight isotropic_light(const Irradiance& light) noexcept {
    return {light.diffuse, 0, 0};
}

SkyLight perez_light(const Irradiance& light, double altitude_deg,
                     double extraterrestrial_w_m2) noexcept {
    if (light.diffuse <= 0)
        return {};
    constexpr double kRad = det::kPi / 180;
    const double zenith = (90 - altitude_deg) * kRad;
    const double cubed = 1.041 * zenith * zenith * zenith;
    const double clearness = ((light.diffuse + light.beam) / light.diffuse + cubed) / (1 + cubed);
    const double brightness = light.diffuse * air_mass(altitude_deg) / extraterrestrial_w_m2;
    const SkyClass& sky = find_class(clearness);
    const double around_sun = std::max(0.0, weighted(sky.f1, brightness, zenith));
    const double horizon = weighted(sky.f2, brightness, zenith);
    constexpr double kLowest_deg = 5;
    const double sine = det::sin(std::max(altitude_deg, kLowest_deg) * kRad);
    return {light.diffuse * (1 - around_sun), light.diffuse * around_sun / sine,
            light.diffuse * horizon};
}

}  // namespace terravox::solar
