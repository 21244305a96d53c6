#include "voxelserver/out/export/anvil/export_blocks.hpp"

#include <algorithm>
#include <limits>

#include "common/util/error.hpp"
#include "common/util/toml_file.hpp"

namespace terravox::exports::anvil {

using voxel::Material;

std::int32_t colour_distance(voxel::Rgb8 a, voxel::Rgb8 b) noexcept {
    // Ref: Riemersma, "Colour metric", CompuPhase: a weighted distance in sRGB that approximates
    // CIELUV, without roots.
    const std::int32_t mean_red = (a.r + b.r) / 2;
    const std::int32_t r = a.r - b.r;
    const std::int32_t g = a.g - b.g;
    const std::int32_t blue = a.b - b.b;
    return ((512 + mean_red) * r * r >> 8) + 4 * g * g + ((767 - mean_red) * blue * blue >> 8);
}

BlockId ExportBlocks::painted(Material material, voxel::Rgb8 colour) const noexcept {
    const Choice& choice = m_choices[index(material)];
    BlockId best = choice.plain;
    std::int32_t nearest = std::numeric_limits<std::int32_t>::max();
    for (const BlockId id : choice.paint)
        if (const std::int32_t d = colour_distance(colour, m_all[id].colour); d < nearest) {
            nearest = d;
            best = id;
        }
    return best;
}

std::map<std::string, Material> ExportBlocks::meanings() const {
    std::map<std::string, Material> out;
    for (const ExportBlock& block : m_all)
        out.emplace(block.name, block.material);
    return out;
}

/// Reads export.toml.
class ExportBlocksReader {
public:
    ExportBlocksReader(std::filesystem::path file, const minecraft::BlockTable& colours)
        : m_file(std::move(file)), m_colours(colours) {}

    ExportBlocks read() {
        const toml::table all =
            util::read_toml(m_file, [&](const std::string& what) { fail(what); });
        for (const auto& [key, node] : all) {
            const std::string name(key.str());
            const auto material = voxel::material_from_name(name);
            if (!material || *material == Material::kAir)
                fail("'" + name + "' is no material that blocks stand for");
            if (!node.is_table())
                fail(name + " is no table; allowed: [" + name + "] with block, paint, rooted");
        }
        for (const std::string& name : names_in_order())
            read_material(*voxel::material_from_name(name), name, all[name].as_table());
        return std::move(m_out);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw util::UsageError("read the blocks to export " + m_file.string() + ": " + what);
    }

    // Blocks are numbered in the order in which they are found: by the names of materials.
    [[nodiscard]] static std::vector<std::string> names_in_order() {
        std::vector<std::string> out;
        for (const voxel::MaterialTraits& traits : voxel::kMaterialTraits)
            if (traits.material != Material::kAir)
                out.emplace_back(traits.name);
        std::sort(out.begin(), out.end());
        return out;
    }

    /// @param table  the file's entry for it; null: none
    void read_material(Material material, const std::string& name, const toml::table* table) {
        ExportBlocks::Choice& choice = m_out.m_choices[ExportBlocks::index(material)];
        const toml::table none;
        const toml::table& fields = table != nullptr ? *table : none;
        choice.plain = fields.contains("block")
                           ? block(material, name, to_text(name, *fields.get("block")))
                           : block(material, name, std::string(voxel::find_traits(material).block));
        choice.rooted = choice.plain;
        for (const auto& [key, node] : fields) {
            const std::string field(key.str());
            if (field == "paint") {
                if (!node.is_array())
                    fail("[" + name + "] paint is no list of blocks");
                for (const auto& item : *node.as_array())
                    choice.paint.push_back(block(material, name, to_text(name, item)));
            } else if (field == "rooted") {
                choice.rooted = block(material, name, to_text(name, node));
            } else if (field != "block") {
                fail("[" + name + "] " + field + " is no field; allowed: block, paint, rooted");
            }
        }
    }

    [[nodiscard]] std::string to_text(const std::string& where, const toml::node& node) const {
        const auto text = node.value_exact<std::string>();
        if (!text)
            fail("[" + where + "] holds what is no block; allowed: texts like \"oak_log\"");
        return *text;
    }

    BlockId block(Material material, const std::string& where, const std::string& text) {
        const minecraft::BlockState state = minecraft::block_state_from(
            text, [&](const std::string& what) { fail("[" + where + "] " + what); });
        const minecraft::BlockAppearance look = m_colours.of(state.name, {});
        if (!look.known)
            fail("[" + where + "] '" + state.name + "' is no block of blocks.toml");
        if (look.material == Material::kAir)
            fail("[" + where + "] '" + state.name + "' is air by blocks.toml");
        const auto [meant, fresh] = m_meant.emplace(state.name, material);
        if (!fresh && meant->second != material)
            fail("'" + state.name + "' stands for both " +
                 std::string(voxel::material_name(meant->second)) + " and " + where +
                 "; allowed: one");
        ExportBlock made{"minecraft:" + state.name, {}, material, look.colour};
        for (const minecraft::Condition& c : state.conditions) {
            if (c.values.size() != 1)
                fail("[" + where + "] '" + text + "' leaves " + c.property +
                     " open; allowed: one value");
            made.properties.emplace_back(c.property, c.values.front());
        }
        for (std::size_t i = 1; i < m_out.m_all.size(); ++i)
            if (m_out.m_all[i].name == made.name && m_out.m_all[i].properties == made.properties)
                return static_cast<BlockId>(i);
        if (m_out.m_all.size() >= 4096)
            fail("more than 4095 blocks");
        m_out.m_all.push_back(std::move(made));
        return static_cast<BlockId>(m_out.m_all.size() - 1);
    }

    const std::filesystem::path m_file;
    const minecraft::BlockTable& m_colours;
    std::map<std::string, Material> m_meant;
    ExportBlocks m_out;
};

ExportBlocks ExportBlocks::load(const std::filesystem::path& folder,
                                const minecraft::BlockTable& colours) {
    return ExportBlocksReader(folder / "export.toml", colours).read();
}

}  // namespace terravox::exports::anvil
