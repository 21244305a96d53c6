#include "voxelserver/make/voxelize/steps/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "voxelserver/make/voxelize/points/brightness.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"

namespace terravox::voxelize {
namespace {

using imagery::Group;
using voxel::Material;

/// The input lists of specialization, made from the columns of a patch.
struct Lists {
    std::vector<Group> group = std::vector<Group>(grid::kPatchColumns, Group::kNone);
    std::vector<Material> material = std::vector<Material>(grid::kPatchColumns, Material::kAir);
    std::vector<std::uint8_t> covered = std::vector<std::uint8_t>(grid::kPatchColumns);
    std::vector<std::uint8_t> has_colour = covered;
    std::vector<voxel::Rgb8> colour = std::vector<voxel::Rgb8>(grid::kPatchColumns);
    bool any_colour = false;
    bool any_brightness = false;

    [[nodiscard]] imagery::SurfaceColumns view() const {
        imagery::SurfaceColumns out;
        out.width = grid::kPatchSize;
        out.height = grid::kPatchSize;
        out.group = group;
        out.material = material;
        out.covered = covered;
        if (any_colour) {
            out.point_colour = colour;
            out.has_point_colour = has_colour;
        }
        return out;
    }
};

// Whether something hangs over the surface, so that an image shows that instead.
bool hidden(const PatchColumns& columns, std::size_t i, double voxel_m) noexcept {
    constexpr double kClear_m = 1.5;  // grass and crops are the surface
    if (columns.objects_begin[i + 1] == columns.objects_begin[i])
        return false;
    const Column& c = columns.columns[i];
    const Surface& surface = c.built_upon() ? c.roof : c.ground;
    const std::int32_t top = columns.objects[columns.objects_begin[i + 1] - 1].y;
    return !surface.seen() ||
           (static_cast<double>(top) - static_cast<double>(surface.height)) * voxel_m > kClear_m;
}

Lists make_lists(const PatchColumns& columns, const ClassTable& classes, Group ground,
                 double voxel_m) {
    Lists out;
    for (std::size_t i = 0; i < grid::kPatchColumns; ++i) {
        const Column& c = columns.columns[i];
        const Surface* seen = &c.ground;
        Material otherwise = Material::kGround;
        out.group[i] = ground;
        if (c.built_upon()) {
            out.group[i] = Group::kBuilding;
            seen = &c.roof;
            otherwise = Material::kRoof;
        } else if (c.water.seen() && c.water_points > c.ground_points) {
            out.group[i] = Group::kWater;
            seen = &c.water;
            otherwise = Material::kWater;
        }
        out.material[i] = seen->seen() ? classes.meaning[seen->source_class].material : otherwise;
        out.covered[i] = c.deck.seen() || hidden(columns, i, voxel_m) ? 1 : 0;
        out.any_brightness = out.any_brightness || c.ground.brightness > 0;
        if (seen->seen() && seen->has_colour) {
            out.colour[i] = seen->colour;
            out.has_colour[i] = 1;
            out.any_colour = true;
        }
    }
    return out;
}

// Whether an image or a point shows the colour of a column's surface.
bool shows_colour(const Window& window, const PatchAppearance* appearance, int x, int z) noexcept {
    const auto i = static_cast<std::size_t>((z & 63) * grid::kPatchSize + (x & 63));
    if (appearance != nullptr && !appearance->raster.empty() &&
        (appearance->raster.flags[i] & imagery::Raster::kColour) != 0)
        return true;
    const Column& c = window.column(x, z);
    return c.built_upon() ? c.roof.has_colour : c.ground.has_colour;
}

}  // namespace

SurfaceStep::SurfaceStep(const imagery::Orthophotos* images, PhotoLights* lights,
                         const ClassTable& classes, const Settings& settings, bool dry,
                         double voxel_m, std::size_t memory_bytes, util::StageTimes& times)
    : m_images(images),
      m_lights(lights),
      m_classes(classes),
      m_times(times),
      m_ground(dry ? Group::kDryGround : Group::kGround),
      m_guesses(settings.steps.material_guesses),
      m_guess_settings(settings.material_guesses),
      m_voxel_m(voxel_m),
      m_appearances(memory_bytes) {
    if (!settings.steps.specialization)
        return;
    m_map = std::make_unique<imagery::ColourMap>(imagery::ColourMap::load(settings.palette));
    if (settings.steps.neighbourhood_filters)
        m_filters = imagery::load_filters(settings.palette);
    m_margin = Margined<Material>::kMargin + imagery::measure_margin(m_filters, voxel_m);
    m_finds_water = images != nullptr && !dry && settings.water.from_orthophoto &&
                    settings.steps.water_equalization;
}

std::shared_ptr<const PatchAppearance> SurfaceStep::patch_appearance(grid::PatchKey key,
                                                                     const PatchColumns& columns) {
    return m_appearances.get(
        key,
        [&] {
            auto out = std::make_shared<PatchAppearance>();
            if (m_lights != nullptr) {
                out->raster = m_lights->albedo(key);
            } else if (m_images != nullptr) {
                const util::StageTimes::Scope timed(m_times, "orthophoto load");
                out->raster =
                    m_images->read(key.x0(), key.z0(), grid::kPatchSize, grid::kPatchSize);
            }
            if (!m_map || !columns.any)
                return out;
            const util::StageTimes::Scope timed(m_times, std::string(kSpecialization.name));
            const Lists lists = make_lists(columns, m_classes, m_ground, m_voxel_m);
            if (!out->raster.empty() || lists.any_colour || (m_guesses && lists.any_brightness))
                out->surface = imagery::specialize(lists.view(), out->raster, *m_map);
            if (m_guesses && lists.any_brightness)
                guess_ground(columns, lists.covered, m_guess_settings, out->surface);
            return out;
        },
        [](const auto& l) { return l->memory_bytes(); });
}

PatchAppearances SurfaceStep::appearances(const Window& window) {
    constexpr int kMiddle = 4;
    PatchAppearances out;
    for (int i = 0; i < 9; ++i)
        if (i == kMiddle || m_map)
            out[static_cast<std::size_t>(i)] =
                patch_appearance({window.middle.px + i % 3 - 1, window.middle.pz + i / 3 - 1},
                                 *window.patches[static_cast<std::size_t>(i)]);
    return out;
}

// Row by row, in the three segments that lie in one patch each.
imagery::Grid SurfaceStep::joined(const PatchAppearances& appearances) const {
    imagery::Grid grid;
    grid.width = grid::kPatchSize + 2 * m_margin;
    grid.height = grid.width;
    grid.margin = m_margin - Margined<Material>::kMargin;  // the rest is used by the filters
    const auto side = static_cast<std::size_t>(grid.width);
    grid.material.assign(side * side, Material::kAir);
    grid.flags.assign(side * side, 0);
    for (int z = -m_margin; z < grid::kPatchSize + m_margin; ++z)
        for (const auto& [from, to] : {std::pair{-m_margin, 0},
                                       {0, grid::kPatchSize},
                                       {grid::kPatchSize, grid::kPatchSize + m_margin}}) {
            const imagery::Grid& source =
                appearances[static_cast<std::size_t>(((z >> 6) + 1) * 3 + (from >> 6) + 1)]
                    ->surface;
            if (source.material.empty())
                continue;
            const auto first = (z & 63) * grid::kPatchSize + (from & 63);
            const auto at = (z + m_margin) * grid.width + from + m_margin;
            std::copy_n(source.material.begin() + first, to - from, grid.material.begin() + at);
            if (!source.flags.empty())
                std::copy_n(source.flags.begin() + first, to - from, grid.flags.begin() + at);
        }
    return grid;
}

SurfaceAppearance SurfaceStep::surface(const Window& window,
                                       const PatchAppearances& appearances) const {
    SurfaceAppearance out;
    out.own = appearances[4];
    Margined<char>::each([&](int x, int z) {
        const auto& around =
            appearances[static_cast<std::size_t>(((z >> 6) + 1) * 3 + (x >> 6) + 1)];
        out.guessed.at(x, z) = shows_colour(window, around.get(), x, z) ? 0 : 1;
    });
    const bool any = std::any_of(
        appearances.begin(), appearances.end(),
        [](const auto& appearance) { return appearance && !appearance->surface.material.empty(); });
    if (!any)
        return out;
    imagery::Grid grid = joined(appearances);
    if (!m_filters.empty())
        imagery::apply_filters(grid, m_filters, m_voxel_m);
    Margined<Material>::each([&](int x, int z) {
        const Material m =
            grid.material[static_cast<std::size_t>((z + m_margin) * grid.width + x + m_margin)];
        // A roof takes a roof's material, the ground any other. Water is determined by the bodies:
        // a wet-looking spot alone is not water.
        const bool fits =
            window.built(x, z) ? voxel::is_roof(m) : !voxel::is_roof(m) && m != Material::kWater;
        if (fits)
            out.material.at(x, z) = m;
    });
    return out;
}

void SurfaceStep::mark_wet(grid::PatchKey key, const PatchColumns& columns, int cell_voxels,
                           water::CellPatch& cells) {
    const auto appearance = patch_appearance(key, columns);
    if (appearance->raster.empty() || appearance->surface.material.empty())
        return;
    std::vector<std::uint8_t> shown(grid::kPatchColumns);
    for (std::size_t i = 0; i < shown.size(); ++i)
        shown[i] = (appearance->raster.flags[i] & imagery::Raster::kColour) != 0 &&
                           columns.columns[i].ground.seen()
                       ? 1
                       : 0;
    const auto wet = imagery::looks_wet(appearance->surface.material, shown, grid::kPatchSize,
                                        grid::kPatchSize, cell_voxels);
    for (std::size_t i = 0; i < wet.size(); ++i)
        cells.cells[i].looks_wet = wet[i] != 0;
}

namespace {

double measure_share(std::uint8_t brightness) noexcept {
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
            return m_of_building[compute_index(building)].material(m_settings);
        RoofEvidence around;
        for (int dz = -1; dz <= 1; ++dz)
            for (int dx = -1; dx <= 1; ++dx)
                around.add(m_of_cell[cell_index(find_cell(x) + dx, find_cell(z) + dz)]);
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

    static constexpr int find_cell(int x) noexcept { return (x - kFirst) / kCell; }
    static constexpr std::size_t cell_index(int cx, int cz) noexcept {
        return static_cast<std::size_t>(cz * kCells + cx);
    }

    [[nodiscard]] float height(int x, int z, float otherwise) const noexcept {
        return m_window.built(x, z) ? m_window.column(x, z).roof.height : otherwise;
    }

    [[nodiscard]] std::size_t compute_index(const Building* building) const noexcept {
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
            m_of_building[compute_index(building)].add(own);
        else
            m_of_cell[cell_index(find_cell(x), find_cell(z))].add(own);
    }

    const Window& m_window;
    const Buildings& m_buildings;
    const Settings::MaterialGuesses& m_settings;
    std::vector<RoofEvidence> m_of_building;  ///< by compute_index()
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
        const double brightness = measure_share(column.ground.brightness);
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
