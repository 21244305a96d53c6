#include "raytracer/analyse/solar/far_horizon.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "common/util/det_math.hpp"
#include "common/util/error.hpp"
#include "common/util/numbers.hpp"

namespace terravox::solar {
namespace {

constexpr int kBoundsPerSlope = 16;
constexpr int kBounds = 256;  // slopes up to 16: 86 degrees

/// Two neighbours, and how far from the first one to the second a place is.
struct Between {
    int first = 0;
    int second = 0;
    double share = 0;
};

/// @param at place along points of which the first and the last are at `from` and `to`
Between among_points(double at, double from, double to, int count) noexcept {
    if (count < 2 || !(to > from))
        return {};
    const double place = std::clamp((at - from) / (to - from), 0.0, 1.0) * (count - 1);
    const int first = static_cast<int>(place);
    return {first, std::min(first + 1, count - 1), place - first};
}

Between around_circle(double azimuth_deg) noexcept {
    constexpr double kPerDegree = FarHorizon::kAzimuths / 360.0;
    const double place = std::clamp(azimuth_deg, 0.0, 360.0) * kPerDegree;
    const int first = static_cast<int>(place);
    return {first % FarHorizon::kAzimuths, (first + 1) % FarHorizon::kAzimuths, place - first};
}

double mix(double a, double b, double share) noexcept {
    return a + (b - a) * share;
}

double measure_shadow_height(const FarTop& top, double slope) noexcept {
    return top.height_m - slope * top.distance_m;
}

double along(double from, double to, int place, int count) noexcept {
    return count > 1 ? from + (to - from) * place / (count - 1) : (from + to) / 2;
}

}  // namespace

std::size_t FarHorizon::Lattice::points() const noexcept {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
}
double FarHorizon::Lattice::x(int column) const noexcept {
    return along(west, east, column, columns);
}
double FarHorizon::Lattice::z(int row) const noexcept {
    return along(north, south, row, rows);
}

FarHorizon::FarHorizon(const Lattice& lattice, const std::vector<Tops>& tops, double voxel_m)
    : m_lattice(lattice), m_voxel_m(voxel_m), m_bounds(kBounds, kLowest_m) {
    m_begins.reserve(tops.size() + 1);
    for (const Tops& some : tops) {
        m_begins.push_back(static_cast<std::uint32_t>(m_tops.size()));
        m_tops.insert(m_tops.end(), some.begin(), some.end());
    }
    m_begins.push_back(static_cast<std::uint32_t>(m_tops.size()));
    for (int i = 0; i < kBounds; ++i)
        for (const FarTop& top : m_tops) {
            double& bound = m_bounds[static_cast<std::size_t>(i)];
            bound = std::max(bound,
                             measure_shadow_height(top, static_cast<double>(i) / kBoundsPerSlope));
        }
}

double FarHorizon::shadow_height(std::size_t point, int azimuth, double slope) const noexcept {
    const std::size_t index = point * kAzimuths + static_cast<std::size_t>(azimuth);
    double out = kLowest_m;
    for (std::uint32_t i = m_begins[index]; i < m_begins[index + 1]; ++i)
        out = std::max(out, measure_shadow_height(m_tops[i], slope));
    return out;
}

double FarHorizon::shadow_height(core::Vec3 from, double azimuth_deg, double slope) const noexcept {
    const Between x = among_points(from.x, m_lattice.west, m_lattice.east, m_lattice.columns);
    const Between z = among_points(from.z, m_lattice.north, m_lattice.south, m_lattice.rows);
    const Between around = around_circle(azimuth_deg);
    const auto at = [&](int column, int row) {
        const auto point = static_cast<std::size_t>(row * m_lattice.columns + column);
        return mix(shadow_height(point, around.first, slope),
                   shadow_height(point, around.second, slope), around.share);
    };
    const auto along_x = [&](int row) { return mix(at(x.first, row), at(x.second, row), x.share); };
    return mix(along_x(z.first), along_x(z.second), z.share);
}

bool FarHorizon::hides(core::Vec3 from, core::Vec3 to) const noexcept {
    const double level = std::sqrt(to.x * to.x + to.z * to.z);
    if (empty() || !(level > 0))
        return false;
    const double slope = to.y / level;
    const double height_m = from.y * m_voxel_m;
    const double bound = std::clamp(slope * kBoundsPerSlope, 0.0, kBounds - 1.0);
    if (height_m >= m_bounds[static_cast<std::size_t>(bound)])
        return false;
    constexpr double kDegPerRad = 180 / det::kPi;
    const double azimuth_deg = det::atan2(to.x, -to.z) * kDegPerRad;
    return height_m < shadow_height(from, azimuth_deg < 0 ? azimuth_deg + 360 : azimuth_deg, slope);
}

namespace {

// Worlds are within 2^31 voxels.
constexpr double kMaxPlace = 4e9;

/// "number,number;"
template <class Number>
std::optional<std::array<Number, 2>> take_pair(std::string_view& text) {
    const auto first = util::take_number<Number>(text);
    if (!first || !util::take(text, ','))
        return std::nullopt;
    const auto second = util::take_number<Number>(text);
    if (!second || !util::take(text, ';'))
        return std::nullopt;
    return std::array<Number, 2>{*first, *second};
}

std::optional<FarHorizon::Lattice> take_lattice(std::string_view& text) {
    const auto counts = take_pair<int>(text);
    const auto first = take_pair<double>(text);
    const auto last = take_pair<double>(text);
    if (!counts || !first || !last)
        return std::nullopt;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const bool is_count = (*counts)[axis] >= 1 && (*counts)[axis] <= FarHorizon::kMaxAcross;
        const bool are_places = std::abs((*first)[axis]) <= kMaxPlace &&
                                std::abs((*last)[axis]) <= kMaxPlace &&
                                (*first)[axis] <= (*last)[axis];
        if (!is_count || !are_places)
            return std::nullopt;
    }
    return FarHorizon::Lattice{(*counts)[0], (*counts)[1], (*first)[0],
                               (*first)[1],  (*last)[0],   (*last)[1]};
}

/// "distance,height,distance,height;", or ";" alone
std::optional<FarHorizon::Tops> take_tops(std::string_view& text) {
    FarHorizon::Tops out;
    while (!util::take(text, ';')) {
        if (!out.empty() && !util::take(text, ','))
            return std::nullopt;
        const auto distance = util::take_number<std::int32_t>(text);
        if (!distance || !util::take(text, ','))
            return std::nullopt;
        const auto height = util::take_number<std::int32_t>(text);
        const FarTop before = out.empty() ? FarTop{-1, FarHorizon::kLowest_m - 1} : out.back();
        if (!height || *distance <= before.distance_m || *height <= before.height_m ||
            *distance > FarHorizon::kMaxDistance_m || *height > FarHorizon::kHighest_m ||
            out.size() == FarHorizon::kMaxTops)
            return std::nullopt;
        out.push_back({*distance, *height});
    }
    return out;
}

std::optional<std::pair<FarHorizon::Lattice, std::vector<FarHorizon::Tops>>> parse(
    std::string_view text) {
    const auto lattice = take_lattice(text);
    if (!lattice)
        return std::nullopt;
    std::vector<FarHorizon::Tops> tops;
    tops.reserve(lattice->points() * FarHorizon::kAzimuths);
    while (tops.size() < lattice->points() * FarHorizon::kAzimuths) {
        auto some = take_tops(text);
        if (!some)
            return std::nullopt;
        tops.push_back(std::move(*some));
    }
    return text.empty() ? std::optional(std::pair(*lattice, std::move(tops))) : std::nullopt;
}

template <class Number>
void append(std::string& out, Number value, char after) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    out.append(digits.data(), end.ptr);
    out += after;
}

}  // namespace

std::string to_text(const FarHorizon::Lattice& lattice, const std::vector<FarHorizon::Tops>& tops) {
    std::string out;
    append(out, lattice.columns, ',');
    append(out, lattice.rows, ';');
    append(out, lattice.west, ',');
    append(out, lattice.north, ';');
    append(out, lattice.east, ',');
    append(out, lattice.south, ';');
    for (const FarHorizon::Tops& some : tops) {
        if (some.empty())
            out += ';';
        for (std::size_t i = 0; i < some.size(); ++i) {
            append(out, some[i].distance_m, ',');
            append(out, some[i].height_m, i + 1 < some.size() ? ',' : ';');
        }
    }
    return out;
}

FarHorizon parse_far_horizon(const std::string& text, double voxel_m) {
    if (text.empty())
        return {};
    const auto parsed = parse(text);
    if (!parsed) {
        constexpr std::size_t kShown = 80;
        throw util::UsageError(
            "look at the horizon: analysis.horizon = '" + text.substr(0, kShown) +
            (text.size() > kShown ? "...'" : "'") +
            "; allowed: columns,rows;west,north;east,south; with 1 to 9 columns and rows of "
            "points, "
            "and for each point and each of 360 azimuths up to 16 tops, distance,height,...; which "
            "rise with their distance of up to 1000000 m, to 10000 m at most");
    }
    return {parsed->first, parsed->second, voxel_m};
}

}  // namespace terravox::solar
