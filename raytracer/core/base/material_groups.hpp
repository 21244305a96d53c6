#pragma once

#include "common/voxel/material.hpp"

namespace terravox::core {

/// Whether a voxel of a material belongs to a building: walls, roofs, and the panels on them.
[[nodiscard]] constexpr bool is_of_building(voxel::Material material) noexcept {
    using voxel::Material;
    switch (material) {
        case Material::kWall:
        case Material::kRoof:
        case Material::kOrangeRoof:
        case Material::kGreyRoof:
        case Material::kFlatRoof:
        case Material::kSolarPanel: return true;
        default: return false;
    }
}

/// Whether a voxel of a material stands for something that is much thinner than the voxel: grass,
/// crops and shrubs, the trunk of a tree, a wire.
[[nodiscard]] constexpr bool is_thin(voxel::Material material) noexcept {
    using voxel::Material;
    return material == Material::kLowVegetation || material == Material::kTrunk ||
           material == Material::kWire;
}

}  // namespace terravox::core
