#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "voxelserver/data/imagery/colour_map.hpp"
#include "voxelserver/data/imagery/filters.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"
#include "voxelserver/data/imagery/specialization.hpp"
#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/buildings.hpp"
#include "voxelserver/make/voxelize/steps/photo_lights.hpp"

namespace terravox::voxelize {

/// What the columns of one patch look like from above, each by itself; index z * 64 + x. Immutable.
struct PatchAppearance {
    imagery::Raster raster;  ///< empty without images
    /// Materials before the filters; empty when no colour is known or the step is switched off.
    imagery::Grid surface;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return sizeof *this + raster.colour.size() * sizeof(voxel::Rgb8) + raster.nir.size() +
               raster.red.size() + raster.flags.size() +
               raster.image.size() * sizeof(std::uint32_t) + surface.material.size() +
               surface.flags.size();
    }
};

/// Appearances of the patches of a window; index as of Window::patches. nullptr = not evaluated.
using PatchAppearances = std::array<std::shared_ptr<const PatchAppearance>, 9>;

/// What the surface of a patch looks like from above, its neighbours taken into account.
struct SurfaceAppearance {
    Margined<voxel::Material> material{voxel::Material::kAir};  ///< kAir = the class's own
    /// 1 = neither an image nor a point shows its colour: a material is a guess.
    Margined<char> guessed{1};
    std::shared_ptr<const PatchAppearance> own;
    /// @return nullptr where no image shows the column; x, z in [0, 64)
    [[nodiscard]] const voxel::Rgb8* colour(int x, int z) const noexcept {
        if (!own || own->raster.empty())
            return nullptr;
        const auto i = static_cast<std::size_t>(z * grid::kPatchSize + x);
        return (own->raster.flags[i] & imagery::Raster::kColour) != 0 ? &own->raster.colour[i]
                                                                      : nullptr;
    }
};

/// Steps "specialization" and "neighbourhood filters". A patch's appearance is cached, as its
/// neighbours and the search for water need it, too; the time of making it counts as "orthophoto
/// load" and "specialization", whatever it is needed for. Thread-safe.
class SurfaceStep {
public:
    /// @param images nullptr = none
    /// @param lights of the images; nullptr = their colours are used as they are
    /// @param dry the survey has a class for water, so dark ground is not taken for water
    /// @throws UsageError, Error for a bad palette
    SurfaceStep(const imagery::Orthophotos* images, PhotoLights* lights, const ClassTable& classes,
                const Settings& settings, bool dry, double voxel_m, std::size_t memory_bytes,
                util::StageTimes& times);

    /// Step "specialization": the appearances of all nine patches; without the step, only the
    /// middle's image.
    [[nodiscard]] PatchAppearances appearances(const Window& window);

    /// Step "neighbourhood filters": the appearances of nine patches put together, and filtered
    /// unless the step is switched off.
    [[nodiscard]] SurfaceAppearance surface(const Window& window,
                                            const PatchAppearances& appearances) const;

    /// Whether cells are to be searched for water at all.
    [[nodiscard]] bool finds_water() const noexcept { return m_finds_water; }
    /// Sets `looks_wet` of the cells of a patch, from its own columns alone.
    void mark_wet(grid::PatchKey key, const PatchColumns& columns, int cell_voxels,
                  water::CellPatch& cells);

private:
    [[nodiscard]] std::shared_ptr<const PatchAppearance> patch_appearance(
        grid::PatchKey key, const PatchColumns& columns);
    [[nodiscard]] imagery::Grid joined(const PatchAppearances& appearances) const;

    const imagery::Orthophotos* m_images;
    PhotoLights* m_lights;
    const ClassTable& m_classes;
    util::StageTimes& m_times;
    imagery::Group m_ground;
    bool m_guesses;
    Settings::MaterialGuesses m_guess_settings;
    double m_voxel_m;
    std::unique_ptr<imagery::ColourMap> m_map;  // nullptr = the step is switched off
    imagery::Filters m_filters;
    int m_margin = 2;
    bool m_finds_water = false;
    util::Cache<grid::PatchKey, PatchAppearance, grid::PatchKeyHash> m_appearances;
};

}  // namespace terravox::voxelize

/// Step "material guesses": what surfaces of unknown colour are probably made of.
///
/// At the wavelengths of airborne scanners (1064 and 1550 nm), asphalt, slate and metal return
/// little light; clay tiles, dry soil and plants much. Ref: Song et al., "Assessing the possibility
/// of land-cover classification using LiDAR intensity data", ISPRS 2002.
namespace terravox::voxelize {

/// Guesses the material of open ground from its brightness, for columns that no image and no point
/// shows the colour of. Each column by itself; the neighbourhood filters clean the result.
/// @param covered not 0: something hangs over the column (SurfaceColumns)
/// @param surface of the patch, as specialize() made it
void guess_ground(const PatchColumns& columns, std::span<const std::uint8_t> covered,
                  const Settings::MaterialGuesses& settings, imagery::Grid& surface);

/// Guesses the material of roofs of unknown colour from their shape and brightness: one material
/// for a whole building, or for the surroundings where it is too wide. A class that names a
/// material keeps it.
void guess_roofs(const Window& window, const ClassTable& classes, const Buildings& buildings,
                 const Settings::MaterialGuesses& settings, SurfaceAppearance& surface);

}  // namespace terravox::voxelize
