#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "common/util/error.hpp"
#include "raytracer/analyse/solar/far_horizon.hpp"

namespace terravox::solar {
namespace {

// Worlds are within 2^31 voxels.
constexpr double kMaxPlace = 4e9;

/// Takes a number from the front of a text.
template <class Number>
std::optional<Number> take(std::string_view& text) {
    Number out{};
    const auto [at, failed] = std::from_chars(text.data(), text.data() + text.size(), out);
    if (failed != std::errc{})
        return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(at - text.data()));
    return out;
}

/// Takes a character from the front of a text.
/// @return whether it is there
bool take(std::string_view& text, char wanted) noexcept {
    if (text.empty() || text.front() != wanted)
        return false;
    text.remove_prefix(1);
    return true;
}

/// "number,number;"
template <class Number>
std::optional<std::array<Number, 2>> take_pair(std::string_view& text) {
    const auto first = take<Number>(text);
    if (!first || !take(text, ','))
        return std::nullopt;
    const auto second = take<Number>(text);
    if (!second || !take(text, ';'))
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
    while (!take(text, ';')) {
        if (!out.empty() && !take(text, ','))
            return std::nullopt;
        const auto distance = take<std::int32_t>(text);
        if (!distance || !take(text, ','))
            return std::nullopt;
        const auto height = take<std::int32_t>(text);
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

std::string text_of(const FarHorizon::Lattice& lattice, const std::vector<FarHorizon::Tops>& tops) {
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

FarHorizon far_horizon_of(const std::string& text, double voxel_m) {
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
