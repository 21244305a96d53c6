#pragma once

#include <filesystem>

#include "raytracer/material/look.hpp"
#include "raytracer/material/material_file.hpp"
#include "raytracer/material/texture_pool.hpp"
#include "raytracer/material/windows.hpp"

namespace terravox::material {

/// What materials look like: throughout, and from place to place on the faces of voxels. Textures
/// are drawn at construction, some milliseconds. Immutable and safe to share between threads; a
/// function of its arguments.
class MaterialTable {
public:
    /// Reads config/materials.toml; warns once of materials that it lacks. @throws Error as
    /// material::read_materials
    explicit MaterialTable(const std::filesystem::path& file) : MaterialTable(checked(file)) {}
    explicit MaterialTable(const material::Looks& looks);

    /// A number that is no material is like `unknown`; air is black.
    [[nodiscard]] const Look& look(voxel::Material material) const noexcept {
        return m_entries[number_of(material)].look;
    }
    /// What is drawn at a place. Texels stay square blocks up close; from afar they melt into their
    /// mean, of which the colour is the material's own, so that distance changes no colour. Of
    /// coarser levels there is only the mean; leaves of level n are as dense as the 2^n voxels
    /// behind each other that they stand for.
    [[nodiscard]] Texel texel(voxel::Material material, const FacePoint& at) const noexcept;

    /// For tests and the sheet of textures.
    [[nodiscard]] const material::TexturePool& pool() const noexcept { return m_pool; }
    [[nodiscard]] const material::PaintedFace& painted(voxel::Material material,
                                                       core::Face face) const noexcept {
        return m_entries[number_of(material)].faces[side_of(face)];
    }

private:
    struct Entry {
        Look look;
        std::array<material::PaintedFace, 3> faces;  ///< side, bottom, top
        voxel::Colour own{1, 1, 1};
        bool windows = false, waves = false;
    };
    static material::Looks checked(const std::filesystem::path& file);
    [[nodiscard]] static std::size_t number_of(voxel::Material material) noexcept {
        const auto number = static_cast<std::size_t>(material);
        return number < voxel::kMaterialCount ? number
                                              : static_cast<std::size_t>(voxel::Material::kUnknown);
    }
    [[nodiscard]] static std::size_t side_of(core::Face face) noexcept {
        return core::axis_of(face) != 1 ? 0 : face == core::Face::kTop ? 2 : 1;
    }

    material::TexturePool m_pool;
    material::Windows m_windows;
    std::array<Entry, voxel::kMaterialCount> m_entries;
};

}  // namespace terravox::material
