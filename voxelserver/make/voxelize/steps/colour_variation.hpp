#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"
#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/steps/buildings.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxel {
class ByteWriter;
}

namespace terravox::voxelize {

/// Colours that buildings and trees of one material have, from which each takes one by a number
/// from its place. They are typical, not measured. Immutable, thread-safe.
class Tints {
public:
    /// Reads config/tints/<id>.toml. A path to a .toml file works too.
    /// @throws UsageError for an unknown id or a bad file, naming field, value and allowed range
    [[nodiscard]] static Tints load(const std::string& id_or_path);

    /// @param number of a building or tree; equal ones have equal colours
    /// @return nullopt for a material without colours
    [[nodiscard]] std::optional<voxel::Rgb8> of(voxel::Material material,
                                                std::uint64_t number) const noexcept;

    /// Adds all values that results depend on, for a fingerprint.
    void add_values(voxel::ByteWriter& out) const;

private:
    double m_brightness = 0;  ///< each colour is up to this share brighter or darker
    std::array<std::vector<voxel::Rgb8>, voxel::kMaterialCount> m_colours;
};

/// A number in which every bit depends on the place and the seed.
[[nodiscard]] std::uint64_t number_of_place(std::int32_t x, std::int32_t z,
                                            std::uint64_t seed) noexcept;

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
