#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/tints.hpp"
#include "voxelserver/make/voxelize/steps/buildings.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxelize {

/// A number in which every bit depends on the place and the seed.
[[nodiscard]] std::uint64_t number_of_place(std::int32_t x, std::int32_t z,
                                            std::uint64_t seed) noexcept;

/// The building and the tree of each column, as numbers from their places.
struct PlaceNumbers {
    static constexpr std::uint64_t kNone = 0;
    const Tints* tints = nullptr;  ///< nullptr = colours are not varied
    std::vector<HouseNumber> houses;
    Margined<std::int16_t> house_index{-1};  ///< of houses; -1: house() is nullptr
    Margined<std::uint64_t> tree{kNone};

    /// @return nullptr where no building is; where it is too wide to be known as one, and the tints
    /// say nothing of these
    [[nodiscard]] const HouseNumber* house(int x, int z) const noexcept;
};

/// Step "colour variation": which building and which tree each column belongs to. A closed gap of a
/// roof belongs to the building that it takes its appearance from.
[[nodiscard]] PlaceNumbers number_places(const Window& window, const ClassTable& classes,
                                         const Buildings& buildings, const Margined<Roof>& roofs,
                                         const Margined<Crown>& crowns, const Tints& tints,
                                         double voxel_m);

}  // namespace terravox::voxelize
