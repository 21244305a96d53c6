#include "raytracer/analyse/solar/crown_light.hpp"

#include <charconv>
#include <optional>
#include <string_view>

#include "common/util/error.hpp"

namespace terravox::solar {
namespace {

std::optional<double> share_of(std::string_view text) noexcept {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [at, failed] = std::from_chars(text.data(), end, value);
    if (failed != std::errc{} || at != end || !(value >= 0 && value <= 1))
        return std::nullopt;
    return value;
}

}  // namespace

CrownLight::CrownLight(const std::string& text, const geo::LatLon& place)
    : m_is_south(place.lat_deg < 0) {
    const std::string_view all = text;
    const std::size_t comma = all.find(',');
    const std::optional<double> with = share_of(all.substr(0, comma));
    const std::optional<double> without =
        comma == std::string_view::npos ? with : share_of(all.substr(comma + 1));
    if (!with || !without)
        throw util::UsageError("light the sky: analysis.crown_light = '" + text +
                               "'; allowed: a share of 0 to 1, or two separated by a comma, with "
                               "leaves and without them");
    m_with_leaves = *with;
    m_without_leaves = *without;
}

double CrownLight::share(int month) const noexcept {
    constexpr int kApril = 4;
    constexpr int kOctober = 10;
    const bool has_leaves =
        m_is_south ? month >= kOctober || month <= kApril : kApril <= month && month <= kOctober;
    return has_leaves ? m_with_leaves : m_without_leaves;
}

}  // namespace terravox::solar
