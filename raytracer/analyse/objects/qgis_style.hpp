#pragma once

#include <string>
#include <vector>

#include "raytracer/analyse/objects/object_sums.hpp"

namespace terravox::analyse {

/// A style of QGIS (QML) that colours objects by their field kwh_m2, in steps from the least to the
/// most of them, and writes their field kwh on them.
[[nodiscard]] std::string qgis_style(const std::vector<ObjectFacts>& objects);

}  // namespace terravox::analyse
