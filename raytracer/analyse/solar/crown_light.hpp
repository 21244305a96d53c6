#pragma once

#include <string>

#include "common/geo/lat_lon.hpp"

namespace terravox::solar {

/// Share of light that a crown lets through, by the month: trees have leaves from April to October,
/// south of the equator from October to April.
class CrownLight {
public:
    /// @param text with leaves, and without: "0.03,0.45"; one number for both
    /// @throws UsageError unless each is 0 to 1
    CrownLight(const std::string& text, const geo::LatLon& place);

    /// @param month 1 to 12
    [[nodiscard]] double share(int month) const noexcept;

private:
    double m_with_leaves = 0;
    double m_without_leaves = 0;
    bool m_is_south = false;
};

}  // namespace terravox::solar
