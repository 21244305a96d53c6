#pragma once

#include <cstdint>

#include "common/voxel/material.hpp"

namespace terravox::imagery {

/// Materials as a bit mask: bit m for material m.
using MaterialSet = std::uint64_t;
static_assert(voxel::kMaterialCount <= 64, "a MaterialSet has a bit for each material");

[[nodiscard]] constexpr MaterialSet bit_of(voxel::Material m) noexcept {
    return MaterialSet{1} << static_cast<unsigned>(m);
}

}  // namespace terravox::imagery
