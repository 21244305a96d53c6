#include "raytracer/core/scene/point_list.hpp"

#include <charconv>
#include <cmath>
#include <string_view>

namespace terravox::scene {
namespace {

/// Takes a number and what follows it from the front of a text.
/// @return nullopt for no number, for one out of range, and where another character follows
std::optional<double> take_number(std::string_view& text, char after) {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [at, failed] = std::from_chars(text.data(), end, value);
    if (failed != std::errc{} || !(std::abs(value) <= PointList::kFarthest))
        return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(at - text.data()));
    if (text.empty())
        return after == '\0' ? std::optional(value) : std::nullopt;
    if (text.front() != after)
        return std::nullopt;
    text.remove_prefix(1);
    return value;
}

}  // namespace

std::optional<PointList> PointList::parse(const std::string& text) {
    PointList out;
    std::string_view rest = text;
    while (!rest.empty()) {
        const bool is_last = rest.find(';') == std::string_view::npos;
        const auto x = take_number(rest, ',');
        const auto y = x ? take_number(rest, ',') : std::nullopt;
        const auto z = y ? take_number(rest, is_last ? '\0' : ';') : std::nullopt;
        if (!z || out.points.size() == kMaxPoints || (!is_last && rest.empty()))
            return std::nullopt;
        out.points.push_back({*x, *y, *z});
    }
    return out;
}

std::string PointList::text() const {
    std::string out;
    std::array<char, 40> digits{};
    for (const std::array<double, 3>& point : points)
        for (std::size_t a = 0; a < 3; ++a) {
            const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), point[a]);
            if (!out.empty())
                out += a == 0 ? ';' : ',';
            out.append(digits.data(), end.ptr);
        }
    return out;
}

}  // namespace terravox::scene
