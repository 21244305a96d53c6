#pragma once

#include <cstdint>
#include <span>

#include "voxelserver/data/imagery/filters.hpp"
#include "voxelserver/make/voxelize/columns/window.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/buildings.hpp"
#include "voxelserver/make/voxelize/steps/surface.hpp"

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
