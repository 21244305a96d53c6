#include "voxelserver/out/export/vox/vox_palette.hpp"

#include <algorithm>

#include "voxelserver/out/export/vox/few_colours.hpp"

namespace terravox::exports {

using voxel::Material;

void VoxPalette::count(Material material, voxel::Rgb8 colour, bool own) {
    if (own)
        m_groups[group_of(material)].counts.add(colour);
    else
        m_plain[voxel::material_index(material)] = true;
}

void VoxPalette::take(Group& group, Material material, std::size_t max_colours,
                      std::vector<VoxColour>& out) const {
    const auto cells = group.counts.cells();
    const FewColours few = few_colours(cells, max_colours);
    for (std::size_t i = 0; i < cells.size(); ++i)
        group.index_of_cell.emplace(cells[i].key,
                                    static_cast<std::uint8_t>(out.size() + few.of_cell[i] + 1));
    for (const voxel::Rgb8 colour : few.colours)
        out.push_back({colour, material});
}

std::vector<VoxColour> VoxPalette::choose() {
    std::vector<VoxColour> out;
    for (std::size_t m = 0; m < m_plain.size(); ++m) {
        if (!m_plain[m])
            continue;
        const auto material = static_cast<Material>(m);
        out.push_back({m_palette.of(material).colour, group_of(material)});
        m_index_of_plain[m] = static_cast<std::uint8_t>(out.size());
    }
    // Special materials first: the others get what is left, at least 144.
    for (auto& [material, group] : m_groups)
        if (special_in_vox(material))
            take(group, material, kMaxOfSpecial, out);
    if (const auto rest = m_groups.find(Material::kAir); rest != m_groups.end())
        take(rest->second, Material::kAir, kMax - out.size(), out);
    return out;
}

std::uint8_t VoxPalette::index_of(Material material, voxel::Rgb8 colour, bool own) const {
    if (!own)
        return m_index_of_plain[voxel::material_index(material)];
    const Group& group = m_groups.at(group_of(material));
    return group.index_of_cell.at(group.counts.key_of(colour));
}

}  // namespace terravox::exports
