#pragma once

#include <cstdint>

#include "voxelserver/make/voxelize/columns/window.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/steps/building_fill.hpp"
#include "voxelserver/make/voxelize/steps/buildings.hpp"
#include "voxelserver/make/voxelize/steps/tints.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxelize {

/// The building and the tree of each column, as numbers from their places.
struct PlaceNumbers {
    static constexpr std::uint64_t kNone = 0;
    const Tints* tints = nullptr;  ///< nullptr = colours are not varied
    Margined<std::uint64_t> building{
        kNone};  ///< kNone: no building, or too wide to be known as one
    Margined<std::uint64_t> tree{kNone};
};

/// Step "colour variation": which building and which tree each column belongs to. A closed gap of a
/// roof belongs to the building that it takes its appearance from.
[[nodiscard]] PlaceNumbers number_places(const Window& window, const ClassTable& classes,
                                         const Buildings& buildings, const Margined<Roof>& roofs,
                                         const Margined<Crown>& crowns, const Tints& tints,
                                         double voxel_m);

}  // namespace terravox::voxelize
