#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "common/voxel/material.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// Metadata that a file of another format cannot hold about the world that it was made from: its
/// georeference, and the meaning of its blocks. A JSON file next to the other
/// (docs/formats/side-car.md).
struct SideCar {
    /// Its title, place on Earth, size of voxels and terms of use; the rest is the file's matter.
    WorldInfo world;
    /// Voxel of the file plus offset = voxel of the world (of the file's voxel size): easting = (x
    /// + offset[0]) * crs_units_per_voxel, northing = -(z + offset[2]) * crs_units_per_voxel,
    /// height_m = (y + offset[1]) * voxel_m. x east, y up, z south.
    std::array<std::int32_t, 3> offset{};
    /// Material of each block of the file, by name; empty: the file defines them itself.
    std::map<std::string, Material> blocks;
};

/// @param offset as SideCar::offset
/// @param level the level of the world that the file holds
[[nodiscard]] SideCar make_side_car(const WorldInfo& world, int level,
                                    const std::array<std::int32_t, 3>& offset);

/// Writes the file atomically.
/// @throws Error
void write_side_car(const std::filesystem::path& file, const SideCar& car);
/// @param origin names the text in error messages
/// @throws Error naming what is wrong, including an unsupported version and numbers out of range
[[nodiscard]] SideCar side_car_from_json(const std::string& text, const std::string& origin);

}  // namespace terravox::voxel
