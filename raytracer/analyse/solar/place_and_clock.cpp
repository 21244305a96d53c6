#include "raytracer/analyse/solar/place_and_clock.hpp"

#include <cmath>

#include "common/util/error.hpp"
#include "common/util/numbers.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/sky/sun.hpp"

namespace terravox::solar {

std::optional<geo::MapPlace> find_place(const scene::Scene& scene,
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

namespace {

constexpr std::int64_t kDay_s = 86'400;
constexpr int kFirstYear = 1900;
constexpr int kLastYear = 2100;

/// A day that is named by a field of the scene.
struct NamedDay {
    std::string text;
    std::string field;
};

std::int64_t to_day(const NamedDay& day) {
    const geo::DateTime date = sky::parse_date(day.text, day.field);
    if (date.year < kFirstYear || date.year > kLastYear)
        throw util::UsageError("place the sun: " + day.field + " = '" + day.text +
                               "'; allowed: years " + std::to_string(kFirstYear) + " to " +
                               std::to_string(kLastYear));
    return geo::days_from_1970(date.year, date.month, date.day);
}

std::int64_t to_seconds(double hours) noexcept {
    constexpr double kHour_s = 3600;
    return std::llround(hours * kHour_s);
}

/// Takes one "OFFSET@INSTANT" from the front of a text.
std::optional<geo::OffsetFrom> take_offset(std::string_view& text) noexcept {
    constexpr double kMaxOffset_h = 24;
    constexpr std::int64_t kMaxInstant_s = std::int64_t{1} << 40;
    const auto hours = util::take_number<double>(text);
    if (!hours || !(std::abs(*hours) <= kMaxOffset_h) || !util::take(text, '@'))
        return std::nullopt;
    const auto instant = util::take_number<std::int64_t>(text);
    if (!instant || *instant <= -kMaxInstant_s || *instant >= kMaxInstant_s)
        return std::nullopt;
    return geo::OffsetFrom{.from_s = *instant, .offset_h = *hours};
}

std::vector<geo::OffsetFrom> parse_offsets(const std::string& text) {
    // Two a year, for all years.
    constexpr std::size_t kMaxOffsets = 1000;
    std::vector<geo::OffsetFrom> out;
    std::string_view rest = text;
    while (out.size() < kMaxOffsets) {
        const auto offset = take_offset(rest);
        if (!offset || (!out.empty() && offset->from_s <= out.back().from_s))
            break;
        out.push_back(*offset);
        if (rest.empty())
            return out;
        if (!util::take(rest, ' '))
            break;
    }
    throw util::UsageError("place the sun: analysis.clock = '" + text.substr(0, 80) +
                           "'; allowed: offsets in hours with their instants, 1@1767135600");
}

}  // namespace

Days list_days(const scene::Scene& scene) {
    const scene::Scene::Analysis& analysis = scene.analysis;
    if (analysis.from.empty() != analysis.to.empty())
        throw util::UsageError(std::string("place the sun: analysis.") +
                               (analysis.from.empty() ? "from" : "to") +
                               " is missing; give both, or none to use sun.date");
    const bool is_day = analysis.from.empty();
    const NamedDay first =
        is_day ? NamedDay{scene.sun.date, "sun.date"} : NamedDay{analysis.from, "analysis.from"};
    const NamedDay last = is_day ? first : NamedDay{analysis.to, "analysis.to"};
    const Days out{to_day(first), to_day(last) + 1};
    if (out.begin >= out.end)
        throw util::UsageError("place the sun: analysis.to = '" + last.text +
                               "'; allowed: a day that is not before analysis.from = '" +
                               first.text + "'");
    return out;
}

Clock::Clock(const scene::Scene& scene, const geo::MapPlace& place) {
    const scene::Scene::Sun& sun = scene.sun;
    if (!scene.analysis.clock.empty()) {
        m_offsets = parse_offsets(scene.analysis.clock);
    } else if (sun.utc_offset_h) {
        m_offsets = {{0, *sun.utc_offset_h}};
    } else if (sun.zone.empty()) {
        m_offsets = {{0, geo::solar_zone_offset_h(place.lon_deg)}};
    } else {
        // Clocks are a day or less from universal time.
        constexpr std::int64_t kAround = 2;
        const Days days = list_days(scene);
        m_offsets = geo::zone_offsets(sun.zone, (days.begin - kAround) * kDay_s,
                                      (days.end + kAround) * kDay_s);
    }
}

double Clock::offset_h(std::int64_t utc_s) const noexcept {
    double out = m_offsets.front().offset_h;
    for (const geo::OffsetFrom& offset : m_offsets) {
        if (offset.from_s > utc_s)
            break;
        out = offset.offset_h;
    }
    return out;
}

std::int64_t Clock::midnight_s(std::int64_t day) const noexcept {
    const std::int64_t local_s = day * kDay_s;
    for (std::size_t i = 0; i + 1 < m_offsets.size(); ++i) {
        const std::int64_t instant = local_s - to_seconds(m_offsets[i].offset_h);
        const std::int64_t after = local_s - to_seconds(m_offsets[i + 1].offset_h);
        // Shown before clocks change, or not at all.
        if (instant < m_offsets[i + 1].from_s || after < m_offsets[i + 1].from_s)
            return instant;
    }
    return local_s - to_seconds(m_offsets.back().offset_h);
}

std::string Clock::text() const {
    std::string out;
    for (const geo::OffsetFrom& offset : m_offsets) {
        out += (out.empty() ? "" : " ") + util::number_text(offset.offset_h) + "@" +
               std::to_string(offset.from_s);
    }
    return out;
}

}  // namespace terravox::solar
