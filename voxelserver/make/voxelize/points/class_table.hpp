#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/voxel/material.hpp"

namespace terravox::voxelize {

/// How points of a class shape the voxels of their column.
enum class Role : std::uint8_t {
    kDrop,        ///< noise: not an object
    kGround,      ///< the terrain's surface
    kWater,       ///< a water surface
    kBuilding,    ///< filled from the roof down to the local ground
    kVegetation,  ///< voxels where the points are
    kBridge,      ///< a deck, open beneath
    kObject,      ///< voxels where the points are
    /// Everything above the ground in one class: vegetation by its height above ground.
    kSurface,
};

/// The meaning of one class code of a source.
struct ClassMeaning {
    Role role = Role::kObject;
    voxel::Material material = voxel::Material::kUnknown;
    bool tiers = false;  ///< vegetation material from the height above ground, not from the class
    bool known = false;  ///< the table defines this code
};

/// The meaning of all 256 class codes for one source of data. Codes that a table does not define
/// stay visible as unknown objects.
struct ClassTable {
    std::string id;
    std::optional<std::string> crs;  ///< for files that carry none
    std::array<ClassMeaning, 256> meaning;
};

/// Reads config/classes/<id>.toml, following `extends`. A path to a .toml file works too.
/// @throws UsageError for an unknown id (listing the available ones); Error for a bad file, naming
/// field, value and allowed range
[[nodiscard]] ClassTable load_class_table(const std::string& id_or_path);

/// The ids of the tables in config/classes that define all of these class codes, separated by ", ";
/// empty: none does. Tables that cannot be read are left out; they are read once.
[[nodiscard]] std::string tables_that_name(const std::bitset<256>& codes);

}  // namespace terravox::voxelize
