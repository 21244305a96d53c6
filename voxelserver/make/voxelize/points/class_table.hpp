#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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

/// What becomes of codes that a table does not define.
enum class Unnamed : std::uint8_t {
    kGuessed,  ///< like points that were never classified
    kMarked,   ///< visible objects of the material `unknown`
};

/// Where a table is meant, for files of which nobody says so.
struct Meant {
    std::vector<std::string> crs;             ///< of the files; empty: nowhere
    std::array<double, 4> extent{};           ///< west, south, east, north there; zeros: everywhere
    std::optional<std::bitset<256>> with;     ///< if some point is of one of these classes
    std::optional<std::bitset<256>> without;  ///< and none of these
};

/// The meaning of all 256 class codes for one source of data.
struct ClassTable {
    std::string id;
    std::string title;
    std::optional<std::string> crs;  ///< for files that carry none
    std::array<ClassMeaning, 256> meaning;
    Meant meant;
};

/// Reads config/classes/<id>.toml, following `extends`. A path to a .toml file works too.
/// @throws UsageError for an unknown id (listing the available ones); Error for a bad file, naming
/// field, value and allowed range
[[nodiscard]] ClassTable load_class_table(const std::string& id_or_path,
                                          Unnamed unnamed = Unnamed::kGuessed);

/// The tables of config/classes that can be read, by id. They are read once.
[[nodiscard]] const std::vector<ClassTable>& shipped_class_tables();

/// The ids of the tables in config/classes that define all of these class codes, separated by ", ";
/// empty: none does. Tables that cannot be read are left out; they are read once.
[[nodiscard]] std::string tables_that_name(const std::bitset<256>& codes);

}  // namespace terravox::voxelize
