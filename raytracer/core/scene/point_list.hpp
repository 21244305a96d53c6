#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace terravox::scene {

/// Points of a world, voxels of level 0: x east, y up, z south.
struct PointList {
    static constexpr std::size_t kMaxPoints = 1024;
    static constexpr double kFarthest = 1e9;  ///< of a coordinate, either way
    static constexpr const char* kAllowed =
        "up to 1024 points x,y,z in voxels, with ';' between them";

    std::vector<std::array<double, 3>> points;

    /// @param text "1,2,3;4.5,6,-7"; empty: no point
    /// @return nullopt for anything else, for more than kMaxPoints, and beyond kFarthest
    [[nodiscard]] static std::optional<PointList> parse(const std::string& text);
    /// In the form that parse() takes; the same numbers to the last bit.
    [[nodiscard]] std::string text() const;
    friend bool operator==(const PointList&, const PointList&) = default;
};

}  // namespace terravox::scene
