#include "voxelserver/data/imagery/palette_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/toml_file.hpp"

namespace terravox::imagery {

namespace fs = std::filesystem;

PaletteFile::PaletteFile(fs::path path)
    : m_path(std::move(path)),
      m_root(util::read_toml(m_path, [this](const std::string& what) { fail(what); })) {}

void PaletteFile::fail(const std::string& what) const {
    throw util::UsageError("read the palette {}: {}", m_path.string(), what);
}

double PaletteFile::number(const toml::table& table, const std::string& where, const char* field,
                           double min, double max, double otherwise) const {
    const auto* node = table.get(field);
    if (node == nullptr)
        return otherwise;
    const std::string allowed = fmt::format("; allowed: {} to {}", min, max);
    const auto value = node->value<double>();
    if (!value || !node->is_number())
        fail(where + field + " is not a number" + allowed);
    if (!(*value >= min && *value <= max))
        fail(where + field + fmt::format(" = {}", *value) + allowed);
    return *value;
}

voxel::Material PaletteFile::material(const std::string& where, const std::string& name) const {
    const auto found = voxel::material_from_name(name);
    if (!found || *found == voxel::Material::kAir)
        fail(where + " = '" + name + "'; allowed: a material of materials.toml");
    return *found;
}

MaterialSet PaletteFile::materials(const toml::table& table, const std::string& where,
                                   const char* field) const {
    const auto* node = table.get(field);
    if (node == nullptr)
        return 0;
    const auto* list = node->as_array();
    if (list == nullptr)
        fail(where + field + " is not a list; allowed: a list of materials of materials.toml");
    MaterialSet bits = 0;
    for (const auto& item : *list) {
        const auto name = item.value<std::string>();
        if (!name)
            fail(where + field +
                 " holds something that is no text; allowed: materials of materials.toml");
        bits |= to_bit(material(where + field, *name));
    }
    return bits;
}

std::vector<const toml::table*> PaletteFile::rows(const char* name) const {
    std::vector<const toml::table*> out;
    const auto* node = m_root.get(name);
    if (node == nullptr)
        return out;
    const auto* list = node->as_array();
    if (list == nullptr || !list->is_homogeneous<toml::table>())
        fail(std::string(name) + " is no list of tables; allowed: [[" + name + "]]");
    for (const auto& item : *list)
        out.push_back(item.as_table());
    return out;
}

void PaletteFile::allow_only(const toml::table& table, const std::string& where,
                             std::initializer_list<std::string_view> fields) const {
    util::allow_only(table, where, fields, [this](const std::string& what) { fail(what); });
}

std::vector<PaletteFile> read_palette(const std::string& id_or_path) {
    constexpr std::size_t kMaxExtends = 8;
    fs::path file = util::find_toml(id_or_path, "palettes", "palette");
    std::vector<PaletteFile> out;
    for (;;) {
        out.emplace_back(file);
        const PaletteFile& last = out.back();
        if (out.size() > kMaxExtends)
            last.fail("'extends' is circular");
        last.allow_only(last.root(), "",
                        {"title", "extends", "space", "lightness_weight", "candidates", "ndvi",
                         "entry", "filter"});
        const auto* extends = last.root().get("extends");
        if (extends == nullptr)
            break;
        const auto base = extends->value<std::string>();
        if (!base)
            last.fail("extends is no text");
        file = util::base_file(file, *base, "palettes");
        if (file.empty())
            last.fail("extends = '" + *base + "'; allowed: a palette next to it, or " +
                      util::toml_ids(util::config_dir() / "palettes"));
    }
    std::reverse(out.begin(), out.end());
    return out;
}

}  // namespace terravox::imagery
