#pragma once

#include <array>
#include <filesystem>

#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/material/texture_pool.hpp"
#include "raytracer/core/material/windows.hpp"

namespace terravox::material {

/// The tilt of a water surface at a point: trains of waves, ruffled in patches. Smooth over the
/// whole world and independent of the voxel size; waves too short for a pixel are left out.
/// @param x_m, z_m east and south, metres, within 1e8 of the origin
/// @param footprint_m edge of what a pixel covers, metres
/// @return x and z of the normal whose y is 1; each usually below 0.06
[[nodiscard]] std::array<float, 2> water_tilt(double x_m, double z_m, double footprint_m) noexcept;

/// Appearance of materials: their overall properties, and the textures on the faces of voxels.
/// Textures are drawn at construction, which takes some milliseconds. Immutable and safe to share
/// between threads; a pure function of its arguments.
class MaterialTable {
public:
    /// Reads config/materials.toml; warns once about missing materials.
    /// @throws Error as material::read_materials
    explicit MaterialTable(const std::filesystem::path& file) : MaterialTable(checked(file)) {}
    explicit MaterialTable(const material::MaterialAppearances& appearances);

    /// The look of a material. A number that is no material is treated like `unknown`; air is
    /// black.
    [[nodiscard]] const MaterialAppearance& appearance(voxel::Material material) const noexcept {
        return m_entries[to_number(material)].appearance;
    }
    /// The texture at a point. Texels stay square blocks up close; with distance they fade to their
    /// mean, whose colour is the material's own, so that distance changes no colour. Coarser levels
    /// have only the mean; leaves of level n are as dense as the 2^n voxels in a row that they
    /// represent.
    [[nodiscard]] Texel texel(voxel::Material material, const FacePoint& at) const noexcept;

    /// For tests and the sheet of textures.
    [[nodiscard]] const material::TexturePool& pool() const noexcept { return m_pool; }
    [[nodiscard]] const material::PaintedFace& painted(voxel::Material material,
                                                       core::Face face) const noexcept {
        return m_entries[to_number(material)].faces[find_side(face)];
    }

private:
    struct Entry {
        MaterialAppearance appearance;
        std::array<material::PaintedFace, 3> faces;  ///< side, bottom, top
        voxel::Colour own{1, 1, 1};
        bool windows = false;
        bool waves = false;
    };
    static material::MaterialAppearances checked(const std::filesystem::path& file);
    [[nodiscard]] static std::size_t to_number(voxel::Material material) noexcept {
        const auto number = static_cast<std::size_t>(material);
        return number < voxel::kMaterialCount ? number
                                              : static_cast<std::size_t>(voxel::Material::kUnknown);
    }
    [[nodiscard]] static std::size_t find_side(core::Face face) noexcept {
        return core::to_axis(face) != 1 ? 0 : face == core::Face::kTop ? 2 : 1;
    }

    material::TexturePool m_pool;
    material::Windows m_windows;
    std::array<Entry, voxel::kMaterialCount> m_entries;
};

}  // namespace terravox::material
