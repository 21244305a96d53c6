#pragma once

#include <optional>
#include <string>

namespace terravox::scene {

/// The edge of a tile: pixels, or a share of the picture's width.
struct TileSize {
    static constexpr int kMax_px = 4096;
    static constexpr double kMin_percent = 0.1;
    static constexpr double kMax_percent = 100;
    static constexpr const char* kAllowed =
        "1 to 4096 pixels, or 0.1% to 100% of the picture's width";

    int px = 64;         ///< 1 to kMax_px; ignored when percent is not 0
    double percent = 0;  ///< of the picture's width

    /// @param text "64" or "5%"; numbers as in C++
    /// @return nullopt for anything else, and out of range
    [[nodiscard]] static std::optional<TileSize> parse(const std::string& text);
    /// In the form that parse() takes.
    [[nodiscard]] std::string text() const;
    /// In a picture of this width: whole pixels, the nearest to the share, 1 to kMax_px.
    [[nodiscard]] int in_picture(int width_px) const noexcept;
    friend bool operator==(const TileSize&, const TileSize&) = default;
};

}  // namespace terravox::scene
