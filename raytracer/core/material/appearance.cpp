#include "raytracer/core/material/appearance.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"
#include "common/util/toml_file.hpp"
#include "raytracer/core/material/texture_list.hpp"

namespace terravox::material {
namespace {

constexpr voxel::Rgb8 kMagenta{0xc2, 0x3f, 0xb4};  // as `unknown`, when the file lacks that, too
using KindName = std::pair<std::string_view, Kind>;
constexpr std::array kKinds = {KindName{"solid", Kind::kSolid}, KindName{"leaves", Kind::kLeaves},
                               KindName{"water", Kind::kWater}, KindName{"glass", Kind::kGlass}};

std::string text(double number) {
    return util::number_text(number, 6);
}
std::string range(double low, double high) {
    return text(low) + " to " + text(high);
}

/// Reads the fields of one material.
class Fields {
public:
    Fields(const toml::table& table, std::string name, const std::filesystem::path& file)
        : m_table(table), m_name(std::move(name)), m_file(file) {}

    void number(std::string_view field, double low, double high, float& out) const {
        if (const toml::node* node = m_table.get(field))
            out = static_cast<float>(in_range(field, *node, low, high));
    }
    void flag(std::string_view field, bool& out) const {
        const toml::node* node = m_table.get(field);
        if (node == nullptr)
            return;
        if (!node->is_boolean())
            fail(field, util::toml_value(*node), "true or false");
        out = node->as_boolean()->get();
    }
    void light(std::string_view field, double high, voxel::Colour& out) const {
        const toml::node* node = m_table.get(field);
        if (node == nullptr)
            return;
        const toml::array* list = node->as_array();
        if (list == nullptr || list->size() != 3)
            fail(field,
                 list != nullptr ? std::to_string(list->size()) + " numbers"
                                 : util::toml_value(*node),
                 "[r, g, b], each " + range(0, high));
        out = {static_cast<float>(in_range(field, *list->get(0), 0, high)),
               static_cast<float>(in_range(field, *list->get(1), 0, high)),
               static_cast<float>(in_range(field, *list->get(2), 0, high))};
    }
    template <class List, class Value>
    void word(std::string_view field, const List& words, Value& out) const {
        const toml::node* node = m_table.get(field);
        if (node == nullptr)
            return;
        const auto text = node->value_exact<std::string>();
        std::string allowed;
        for (const auto& [name, value] : words) {
            if (text && name == *text) {
                out = value;
                return;
            }
            allowed += (allowed.empty() ? "" : ", ") + std::string(name);
        }
        fail(field, util::toml_value(*node), allowed);
    }
    void colour(voxel::Colour& out) const {
        const toml::node* node = m_table.get("colour");
        if (node == nullptr)
            fail("colour", "missing", "\"#rrggbb\"");
        const auto text = node->value_exact<std::string>();
        const auto rgb = text ? voxel::rgb8_from_hex(*text) : std::nullopt;
        if (!rgb)
            fail("colour", util::toml_value(*node), "\"#rrggbb\"");
        out = voxel::to_linear(*rgb);
    }
    void check_names() const {
        for (const auto& [field, value] : m_table)
            if (!voxel::is_appearance_field(field.str()))
                throw util::UsageError(said(std::string(field.str()) + " is no field; allowed: " +
                                            voxel::appearance_fields()));
    }

private:
    double in_range(std::string_view field, const toml::node& node, double low, double high) const {
        const auto value = node.is_number() ? node.value<double>() : std::nullopt;
        if (!value || !(*value >= low && *value <= high))
            fail(field, util::toml_value(node), range(low, high));
        return *value;
    }
    [[noreturn]] void fail(std::string_view field, const std::string& value,
                           const std::string& allowed) const {
        throw util::UsageError(said(std::string(field) + " = " + value + "; allowed: " + allowed));
    }
    [[nodiscard]] std::string said(const std::string& what) const {
        return "read the materials " + m_file.string() + ": [" + m_name + "] " + what;
    }
    const toml::table& m_table;
    std::string m_name;
    const std::filesystem::path& m_file;
};

MaterialAppearance read_appearance(const Fields& fields) {
    std::vector<std::pair<std::string_view, int>> names;
    for (const Texture& texture : textures())
        names.emplace_back(texture.name, static_cast<int>(names.size()));
    MaterialAppearance appearance;
    fields.check_names();
    fields.colour(appearance.colour);
    fields.number("variation", 0, 1, appearance.variation);
    fields.word("kind", kKinds, appearance.kind);
    fields.word("texture", names, appearance.texture);
    fields.number("roughness", 0, 1, appearance.roughness);
    fields.number("index", 1, 4, appearance.index);
    fields.light("absorption", 1000, appearance.absorption_per_m);
    fields.light("glow", 1, appearance.glow);
    fields.light("emission", 1000, appearance.emission);
    fields.flag("reflects", appearance.reflects);
    return appearance;
}

std::function<void(const std::string&)> failing(const std::filesystem::path& file) {
    return [file](const std::string& what) {
        throw util::UsageError("read the materials " + file.string() + ": " + what);
    };
}

/// The table of a file for the materials that it does not name.
constexpr std::string_view kDefault = "default";

MaterialFile to_materials(const toml::table& root, const std::filesystem::path& file) {
    const auto fail = failing(file);
    for (const auto& [name, node] : root) {
        const auto known = voxel::material_from_name(name.str());
        if ((!known || *known == voxel::Material::kAir) && name.str() != kDefault)
            fail("[" + std::string(name.str()) + "] is no material");
        if (!node.is_table())
            fail("[" + std::string(name.str()) +
                 "] is no table; allowed: { colour = \"#rrggbb\", ... }");
    }
    MaterialFile out;
    constexpr auto kUnknown = static_cast<std::size_t>(voxel::Material::kUnknown);
    for (std::size_t i = 1; i < out.appearances.size(); ++i) {
        const std::string name(voxel::material_name(static_cast<voxel::Material>(i)));
        const toml::table* table = root[name].as_table();
        const bool is_default = table == nullptr;
        if (is_default)
            table = root[kDefault].as_table();
        if (table != nullptr) {
            const std::string title(is_default ? kDefault : name);
            out.appearances[i] = read_appearance(Fields(*table, title, file));
        } else {
            out.missing.push_back(name);
            if (i == kUnknown)
                out.appearances[i].colour = voxel::to_linear(kMagenta);
        }
    }
    for (const std::string& name : out.missing) {
        MaterialAppearance& appearance =
            out.appearances[static_cast<std::size_t>(*voxel::material_from_name(name))];
        appearance.colour = out.appearances[kUnknown].colour;
    }
    return out;
}

}  // namespace

std::filesystem::path find_materials(const std::string& name) {
    namespace fs = std::filesystem;
    constexpr std::string_view kPrefix = "materials-";
    constexpr std::string_view kEnding = ".toml";
    const fs::path folder = util::config_dir();
    if (name.empty())
        return folder / "materials.toml";
    const bool is_path = name.ends_with(kEnding);
    const fs::path file =
        is_path ? fs::path(name) : folder / (std::string(kPrefix) + name + std::string(kEnding));
    std::error_code ignored;
    if ((is_path || name.find('/') == std::string::npos) && fs::is_regular_file(file, ignored))
        return file;
    std::vector<std::string> known;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        const std::string found = entry.path().filename().string();
        if (found.starts_with(kPrefix) && found.ends_with(kEnding))
            known.push_back(
                found.substr(kPrefix.size(), found.size() - kPrefix.size() - kEnding.size()));
    }
    std::sort(known.begin(), known.end());
    std::string allowed;
    for (const std::string& one : known)
        allowed += one + ", ";
    throw util::UsageError("find the materials '" + name + "': no such file; allowed: " + allowed +
                           "or a path to a .toml file");
}

MaterialFile read_materials(const std::filesystem::path& file) {
    return to_materials(util::read_toml(file, failing(file)), file);
}

MaterialFile parse_materials(const std::string& text, const std::string& name) {
    return to_materials(util::parse_toml(text, name, failing(name)), name);
}

}  // namespace terravox::material
