#include "voxelserver/make/voxelize/steps/material_guesses.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "voxelserver/make/voxelize/points/brightness.hpp"

namespace terravox::voxelize {
namespace {

using voxel::Material;

double share_of(std::uint8_t brightness) noexcept {
    return brightness / BrightnessScale::kBrightGround;
}

/// The sum over roof columns of what decides about their material.
struct RoofEvidence {
    std::uint32_t columns = 0;  ///< of which the slope is known
    std::uint32_t flat = 0;
    std::uint32_t lit = 0;  ///< of which the brightness is known
    std::uint32_t brightness = 0;

    void add(const RoofEvidence& other) noexcept {
        columns += other.columns;
        flat += other.flat;
        lit += other.lit;
        brightness += other.brightness;
    }
    [[nodiscard]] Material material(const Settings::MaterialGuesses& settings) const noexcept {
        if (columns == 0)
            return Material::kAir;
        if (flat >= settings.flat_share * columns)
            return Material::kFlatRoof;
        if (lit == 0)
            return Material::kAir;  // steep, but tiles and slate are alike
        const double mean = brightness / (BrightnessScale::kBrightGround * lit);
        return mean < settings.tiles_from ? Material::kGreyRoof : Material::kOrangeRoof;
    }
};

/// Adds the evidence of columns by building, and by cell for what is too wide to be one.
class RoofGuess {
public:
    RoofGuess(const Window& window, const Buildings& buildings,
              const Settings::MaterialGuesses& settings)
        : m_window(window),
          m_buildings(buildings),
          m_settings(settings),
          m_of_building(buildings.all().size()) {
        window.each_built(-kReach, grid::kPatchSize + kReach, [&](int x, int z) { add(x, z); });
    }

    [[nodiscard]] Material at(int x, int z) const {
        if (const Building* building = m_buildings.at(x, z))
            return m_of_building[index_of(building)].material(m_settings);
        RoofEvidence around;
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx)
                around.add(m_of_cell[cell_index(cell_of(x) + dx, cell_of(z) + dz)]);
        return around.material(m_settings);
    }

private:
    // Cells lie on an absolute grid: a patch's edge is a whole number of them.
    static constexpr int kCell = 8;
    static constexpr int kFirst = -Buildings::kAround;  ///< of the cells
    static constexpr int kLast = grid::kPatchSize + Buildings::kAround;
    static constexpr int kCells = (kLast - kFirst) / kCell;
    static_assert(kFirst % kCell == 0 && grid::kPatchSize % kCell == 0);
    static_assert(Buildings::kAround >= 2 * kCell);  // a cell and the one around a margin of 2
    static constexpr int kReach = Buildings::kAround + Buildings::kWidest;
    static_assert(kReach < Window::kMargin);

    static constexpr int cell_of(int x) noexcept { return (x - kFirst) / kCell; }
    static constexpr std::size_t cell_index(int cx, int cz) noexcept {
        return static_cast<std::size_t>(cz * kCells + cx);
    }

    [[nodiscard]] float height(int x, int z, float otherwise) const noexcept {
        return m_window.built(x, z) ? m_window.column(x, z).roof.height : otherwise;
    }

    [[nodiscard]] std::size_t index_of(const Building* building) const noexcept {
        return static_cast<std::size_t>(building - m_buildings.all().data());
    }

    void add(int x, int z) {
        const Building* const building = m_buildings.at(x, z);
        const bool in_cell = x >= kFirst && z >= kFirst && x < kLast && z < kLast;
        if (building == nullptr && !in_cell)
            return;
        const Surface& roof = m_window.column(x, z).roof;
        RoofEvidence own;
        own.columns = 1;
        const float east = height(x + 1, z, roof.height) - height(x - 1, z, roof.height);
        const float south = height(x, z + 1, roof.height) - height(x, z - 1, roof.height);
        own.flat =
            std::sqrt(east * east + south * south) / 2 < static_cast<float>(m_settings.flat_slope)
                ? 1
                : 0;
        if (roof.brightness != BrightnessScale::kUnknown) {
            own.lit = 1;
            own.brightness = roof.brightness;
        }
        if (building != nullptr)
            m_of_building[index_of(building)].add(own);
        else
            m_of_cell[cell_index(cell_of(x), cell_of(z))].add(own);
    }

    const Window& m_window;
    const Buildings& m_buildings;
    const Settings::MaterialGuesses& m_settings;
    std::vector<RoofEvidence> m_of_building;  ///< by index_of()
    std::array<RoofEvidence, std::size_t{kCells} * kCells> m_of_cell{};
};

}  // namespace

void guess_ground(const PatchColumns& columns, std::span<const std::uint8_t> covered,
                  const Settings::MaterialGuesses& settings, imagery::Grid& surface) {
    for (std::size_t i = 0; i < grid::kPatchColumns; ++i) {
        const Column& column = columns.columns[i];
        const bool open = surface.flags[i] == imagery::Grid::kSilent && covered[i] == 0;
        if (!open || column.built_upon() || !column.ground.seen() ||
            column.ground.brightness == BrightnessScale::kUnknown)
            continue;
        const double brightness = share_of(column.ground.brightness);
        surface.material[i] = brightness < settings.asphalt_below ? Material::kRoad
                              : brightness < settings.bare_below  ? Material::kGround
                                                                  : Material::kGrass;
        surface.flags[i] = 0;
    }
}

void guess_roofs(const Window& window, const ClassTable& classes, const Buildings& buildings,
                 const Settings::MaterialGuesses& settings, SurfaceAppearance& surface) {
    if (!window.any(&PatchColumns::any_roof))
        return;
    const RoofGuess guess(window, buildings, settings);
    Margined<Material>::each([&](int x, int z) {
        if (!window.built(x, z) || surface.guessed.at(x, z) == 0)
            return;
        if (classes.meaning[window.column(x, z).roof.source_class].material != Material::kRoof)
            return;
        if (const Material material = guess.at(x, z); material != Material::kAir)
            surface.material.at(x, z) = material;
    });
}

}  // namespace terravox::voxelize
