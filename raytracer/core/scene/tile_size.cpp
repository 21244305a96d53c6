#include "raytracer/core/scene/tile_size.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace terravox::scene {
namespace {

template <class Number>
std::optional<Number> number_in(const std::string& text, std::size_t length) {
    Number value{};
    const char* end = text.data() + length;
    const auto [at, failed] = std::from_chars(text.data(), end, value);
    if (failed != std::errc{} || at != end)
        return std::nullopt;
    return value;
}

}  // namespace

std::optional<TileSize> TileSize::parse(const std::string& text) {
    if (text.ends_with('%')) {
        const auto percent = number_in<double>(text, text.size() - 1);
        if (!percent || !(*percent >= kMin_percent && *percent <= kMax_percent))
            return std::nullopt;
        return TileSize{TileSize{}.px, *percent};
    }
    const auto px = number_in<int>(text, text.size());
    if (!px || *px < 1 || *px > kMax_px)
        return std::nullopt;
    return TileSize{*px, 0};
}

std::string TileSize::text() const {
    if (percent == 0)
        return std::to_string(px);
    std::array<char, 40> digits{};
    return std::string(digits.data(),
                       std::to_chars(digits.data(), digits.data() + digits.size(), percent).ptr) +
           "%";
}

int TileSize::in_picture(int width_px) const noexcept {
    if (percent == 0)
        return px;
    return static_cast<int>(
        std::clamp(std::floor(width_px * percent / 100 + 0.5), 1.0, static_cast<double>(kMax_px)));
}

}  // namespace terravox::scene
