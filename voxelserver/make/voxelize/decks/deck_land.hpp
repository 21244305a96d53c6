#pragma once

#include <cstdint>
#include <limits>

#include "voxelserver/make/voxelize/columns/window.hpp"
#include "voxelserver/make/voxelize/steps/water_fill.hpp"

namespace terravox::voxelize {

/// What is seen of a column in the search for decks without a bridge class.
enum class LandKind : std::uint8_t {
    kNotEvaluated,
    kUnknown,  ///< nothing, or only plants and wires: the surface is hidden
    kGround,
    kDeck,   ///< a deck that its class names
    kThing,  ///< no ground; the lowest return is unclassified or of an object: perhaps a deck
    kWater,
    kBuilt,
};
struct LandSample {
    float height = kNoHeight;  ///< voxels; NaN when unknown
    LandKind kind = LandKind::kNotEvaluated;
};

/// The surface of a window's columns, each evaluated at its first query. Not thread-safe; the
/// window must outlive it.
class DeckLand {
public:
    /// @param water nullptr = water only where it was seen
    DeckLand(const Window& window, const ClassTable& classes, WaterAccess* water)
        : m_window(window), m_classes(classes), m_water(water) {}

    /// @param x, z in [-64, 128)
    [[nodiscard]] const LandSample& at(int x, int z) {
        LandSample& s = m_samples.at(x, z);
        if (s.kind == LandKind::kNotEvaluated)
            s = evaluate(x, z);
        return s;
    }

private:
    [[nodiscard]] LandSample evaluate(int x, int z);
    [[nodiscard]] float body_level(int x, int z);

    const Window& m_window;
    const ClassTable& m_classes;
    WaterAccess* m_water;
    Grid<LandSample, Window::kMargin> m_samples;
    // The last queried cell: columns of a cell follow each other.
    std::int32_t m_cell_x = std::numeric_limits<std::int32_t>::min();
    std::int32_t m_cell_z = 0;
    float m_cell_level = kNoHeight;
};

}  // namespace terravox::voxelize
