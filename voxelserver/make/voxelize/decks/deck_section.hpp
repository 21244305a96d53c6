#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"
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

/// How far the search for decks reaches, columns. The values add up to what a window allows
/// (bridges.cpp).
struct DeckReach {
    static constexpr int kWidest = 21;  ///< across a deck
    static constexpr int kAcross = 24;  ///< to either side of a column
    static constexpr int kAlong = 28;   ///< to either end
    static constexpr int kGrown = 2;    ///< parapets and gaps, added at the end
};

/// The limits of `[bridges]` and of this search in voxels.
struct DeckLimits {
    DeckLimits(const Settings::Bridges& settings, double voxel_m);
    float drop;
    float above_water;
    float above_land;
    float level;  ///< how much a column may differ from the deck, at the same place
    float slope;  ///< how much more it may differ for each column in between
    /// Greatest step down between two columns of a deck: where the land falls by more, the edge
    /// begins.
    float step;
    float parapet;  ///< how far the deck's edge may rise above it
    float same;     ///< largest difference between the land or water levels on both sides
    int widest;     ///< columns
    /// Columns from the last of the deck to the first low one: one of them is cut by the edge.
    int edge = 2;
    int gap;      ///< widest run of columns without anything seen that is skipped
    int low = 6;  ///< columns beyond an edge that determine how low it is there
};

/// A cut across a deck through one column.
struct DeckSection {
    float height = kNoHeight;   ///< of the deck, voxels
    float below = kNoHeight;    ///< the level between both sides, here
    std::int8_t direction = 0;  ///< index into kDeckDirections
    /// Columns of deck against and along the direction, this one not counted.
    std::int8_t before = 0;
    std::int8_t behind = 0;
    bool over_water = false;  ///< the nearer side is water
    bool near_water = false;  ///< there is water within kAcross on both sides
    bool of_things = false;   ///< no ground class: LandKind::kThing
    [[nodiscard]] int width() const noexcept { return before + behind + 1; }
};

/// Eight directions over half a turn, 22.5 degrees apart; unit vectors (east, south).
inline constexpr std::array<std::array<float, 2>, 8> kDeckDirections = {
    {{1, 0},
     {0.92387953F, 0.38268343F},
     {0.70710678F, 0.70710678F},
     {0.38268343F, 0.92387953F},
     {0, 1},
     {-0.38268343F, 0.92387953F},
     {-0.70710678F, 0.70710678F},
     {-0.92387953F, 0.38268343F}}};

/// Cuts the land across: finds the direction in which a column is narrow and drops off abruptly on
/// both sides, to about the same level.
///
/// Abrupt means that most of the drop lies within two columns of the edge, unlike any slope of
/// earth, and that the land stays low there. Houses, plants that hide the land for more than a few
/// columns, and a rise on one side do not count as an edge. Not thread-safe.
class DeckSections {
public:
    DeckSections(DeckLand& land, const DeckLimits& limits)
        : m_land(land), m_limits(limits), m_index(kNotSearched) {}

    /// The narrowest cut.
    /// @param x, z within kReach of the patch
    /// @return nullptr when the column belongs to no deck; valid until the next call
    [[nodiscard]] const DeckSection* at(int x, int z);
    static constexpr int kReach = Window::kMargin - DeckReach::kAcross;

private:
    struct Side {
        int edge = 0;  ///< columns of deck
        float level = kNoHeight;
        bool water = false;
        bool near_water = false;
        int askew = 0;  ///< steps of 22.5 degrees off the other side's direction
    };
    /// Half of a cross-section: the line from a column in one direction.
    struct Transect {
        int x;
        int z;
        float dx;
        float dz;
        float height;
        bool things;
    };
    [[nodiscard]] const LandSample& sample(const Transect& transect, int steps) {
        return m_land.at(transect.x + rounded(transect.dx, steps),
                         transect.z + rounded(transect.dz, steps));
    }
    [[nodiscard]] static int rounded(float d, int steps) noexcept;
    struct Edge {
        int last = 0;      ///< column of the deck
        float height = 0;  ///< of the deck there, without parapets
    };
    [[nodiscard]] std::optional<Edge> edge(const Transect& transect);
    [[nodiscard]] std::optional<Side> side(const Transect& transect);
    [[nodiscard]] std::optional<Side> opposite(Transect transect, int direction);
    [[nodiscard]] bool water_farther(const Transect& transect, int from);
    [[nodiscard]] std::optional<DeckSection> cut(int x, int z);
    [[nodiscard]] bool joins(const Side& a, const Side& b, DeckSection& out) const;

    static constexpr std::int32_t kNotSearched = -2;
    static constexpr std::int32_t kNone = -1;
    DeckLand& m_land;
    const DeckLimits& m_limits;
    Grid<std::int32_t, kReach> m_index;
    std::vector<DeckSection> m_sections;
};

/// Columns of a patch and a margin, 1 = to be searched by DeckSections.
using DeckSeeds = Grid<char, GroundHeights::kMargin + DeckReach::kGrown>;

/// Columns that may belong to a deck without a bridge class: those between two drops along a row or
/// along a line of columns, no farther apart than a deck is wide. Wherever the land has no such
/// drops this is the only cost of the search for decks, so it reads only the patches' rows of
/// numbers and bits. Every column that DeckSections accepts is among the seeds; voids count as low,
/// since their level is not queried.
/// @return nullopt when there is none
[[nodiscard]] std::optional<DeckSeeds> find_deck_seeds(const Window& window,
                                                       const DeckLimits& limits);

}  // namespace terravox::voxelize
