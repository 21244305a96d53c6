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

}  // namespace terravox::core
