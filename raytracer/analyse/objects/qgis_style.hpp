#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace terravox::analyse {

/// What the features of a styled layer are.
enum class StyledShape : std::uint8_t {
    kPolygon,  ///< labelled with their field kwh
    kLine,
};

/// A style of QGIS (QML) that colours features by their field kwh_m2, in steps from the least to
/// the most of them.
/// @param kwh_m2 of the features that have a value
[[nodiscard]] std::string qgis_style(const std::vector<double>& kwh_m2, StyledShape shape);

}  // namespace terravox::analyse
