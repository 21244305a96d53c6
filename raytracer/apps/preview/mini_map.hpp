#pragma once

#include <array>

#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/apps/preview/progressive.hpp"

namespace terravox::preview {

/// A small picture of the world straight from above, north up, rendered in spare time.
class MiniMap {
public:
    /// @param edge_px of the longer side
    /// @throws Error for a world that cannot be drawn
    MiniMap(blocks::BlockManager& blocks, const scene::Scene& scene, int edge_px);
    /// Renders the map again, as other boxes may be available now.
    /// @throws Error
    void begin();
    /// Continues until then.
    /// @throws Error
    void work(Progressive::Clock::time_point until);
    [[nodiscard]] bool busy() const noexcept { return m_picture.busy(); }
    [[nodiscard]] const ScreenPicture& screen() const noexcept { return m_screen; }
    /// Counts up whenever screen() changes.
    [[nodiscard]] std::uint64_t version() const noexcept { return m_version; }

    /// Converts level-0 voxels (x east, z south) to fractions of the picture's width and height,
    /// from the upper left corner.
    [[nodiscard]] std::array<double, 2> measure_share(double x, double z) const noexcept {
        return {(x - m_west) / m_width, (z - m_north) / m_height};
    }
    /// The inverse of measure_share().
    [[nodiscard]] std::array<double, 2> find_place(double right, double down) const noexcept {
        return {m_west + right * m_width, m_north + down * m_height};
    }

private:
    double m_west, m_north, m_width, m_height;  ///< level-0 voxels
    scene::Scene m_scene;
    ScreenPicture m_screen;
    std::uint64_t m_version = 0;
    Progressive m_picture;
};

}  // namespace terravox::preview
