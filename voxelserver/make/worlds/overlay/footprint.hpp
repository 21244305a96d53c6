#pragma once

#include <array>
#include <vector>

namespace terravox::overlay {

/// What a planned object covers on the map: a polygon with holes. Level-0 voxels, x east, z south.
class Footprint {
public:
    using Point = std::array<double, 2>;
    using Ring = std::vector<Point>;

    /// @param rings border and holes, each closed or not; of any direction
    /// @throws std::invalid_argument when nothing lies inside
    explicit Footprint(std::vector<Ring> rings);

    /// Where a line from west to east crosses the borders, sorted.
    [[nodiscard]] std::vector<double> crossings(double z) const;
    /// By the even-odd rule, so that holes are outside.
    /// @param crossings of the line on which the point lies
    [[nodiscard]] static bool is_inside(const std::vector<double>& crossings, double x) noexcept;
    [[nodiscard]] bool contains(double x, double z) const { return is_inside(crossings(z), x); }
    /// A point inside, about in its middle.
    [[nodiscard]] Point middle() const noexcept { return m_middle; }
    [[nodiscard]] Point min() const noexcept { return m_min; }
    [[nodiscard]] Point max() const noexcept { return m_max; }

    [[nodiscard]] const std::vector<Ring>& rings() const noexcept { return m_rings; }

private:
    std::vector<Ring> m_rings;
    Point m_min{};
    Point m_max{};
    Point m_middle{};
};

}  // namespace terravox::overlay
