#include "voxelserver/make/voxelize/points/class_table.hpp"

#include <algorithm>
#include <functional>
#include <string_view>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/numbers.hpp"
#include "common/util/toml_file.hpp"

namespace terravox::voxelize {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<const char*, Role>, 8> kRoles = {{{"drop", Role::kDrop},
                                                                 {"ground", Role::kGround},
                                                                 {"water", Role::kWater},
                                                                 {"building", Role::kBuilding},
                                                                 {"vegetation", Role::kVegetation},
                                                                 {"bridge", Role::kBridge},
                                                                 {"object", Role::kObject},
                                                                 {"surface", Role::kSurface}}};

using Fail = std::function<void(const std::string&)>;

/// A class code; -1: none.
int to_code(std::string_view text) {
    const auto code = util::parse_number<int>(text);
    return code && *code >= 0 && *code <= 255 && text.front() != '-' ? *code : -1;
}

ClassMeaning read_meaning(const toml::node& node, const std::string& name, const Fail& fail) {
    const auto* entry = node.as_table();
    if (entry == nullptr)
        fail("[class." + name + "] is not a table");
    util::allow_only(*entry, "[class." + name + "] ", {"role", "material", "tiers"}, fail);
    if (entry->contains("tiers") && !(*entry)["tiers"].is_boolean())
        fail("[class." + name + "] tiers is not true or false");
    ClassMeaning meaning;
    meaning.known = true;
    const std::string role = (*entry)["role"].value_or(std::string());
    const auto found =
        std::find_if(kRoles.begin(), kRoles.end(), [&](const auto& r) { return role == r.first; });
    if (found == kRoles.end())
        fail("[class." + name + "] role = '" + role +
             "'; allowed: drop, ground, water, building, vegetation, bridge, object, surface");
    meaning.role = found->second;
    const std::string material = (*entry)["material"].value_or(std::string("air"));
    const auto parsed = voxel::material_from_name(material);
    if (!parsed || (*parsed == voxel::Material::kAir && meaning.role != Role::kDrop &&
                    meaning.role != Role::kSurface))
        fail("[class." + name + "] material = '" + material +
             "'; allowed: a material of materials.toml");
    meaning.material = *parsed;
    meaning.tiers = (*entry)["tiers"].value_or(meaning.role == Role::kSurface);
    return meaning;
}

std::optional<std::bitset<256>> read_codes(const toml::table& meant, const char* field,
                                           const Fail& fail) {
    if (!meant.contains(field))
        return std::nullopt;
    const auto* codes = meant[field].as_array();
    std::bitset<256> out;
    for (std::size_t i = 0; codes != nullptr && i < codes->size(); ++i) {
        const auto code = (*codes)[i].value_exact<std::int64_t>();
        if (!code || *code < 0 || *code > 255)
            fail(std::string("[meant] ") + field + " = " + util::toml_value((*codes)[i]) +
                 "; allowed: 0 to 255");
        out.set(static_cast<std::size_t>(*code));
    }
    if (out.none())
        fail(std::string("[meant] ") + field + " is no list of classes");
    return out;
}

Meant read_meant(const toml::table& meant, const Fail& fail) {
    util::allow_only(meant, "[meant] ", {"crs", "extent", "with", "without"}, fail);
    Meant out;
    const auto* systems = meant["crs"].as_array();
    for (std::size_t i = 0; systems != nullptr && i < systems->size(); ++i)
        if (const auto crs = (*systems)[i].value_exact<std::string>())
            out.crs.push_back(*crs);
    if (systems == nullptr || out.crs.empty() || out.crs.size() != systems->size())
        fail("[meant] crs is no list of texts");
    if (meant.contains("extent")) {
        const auto* extent = meant["extent"].as_array();
        if (extent == nullptr || extent->size() != out.extent.size())
            fail("[meant] extent is no list of four numbers: west, south, east, north");
        for (std::size_t i = 0; i < out.extent.size(); ++i)
            if (const auto number = (*extent)[i].value<double>())
                out.extent[i] = *number;
            else
                fail("[meant] extent = " + util::toml_value((*extent)[i]) +
                     "; allowed: four numbers");
    }
    out.with = read_codes(meant, "with", fail);
    out.without = read_codes(meant, "without", fail);
    return out;
}

void apply(const fs::path& file, ClassTable& table, int depth) {
    const Fail fail = [&](const std::string& what) {
        throw util::UsageError("read the class table {}: {}", file.string(), what);
    };
    constexpr int kMaxExtends = 8;
    if (depth > kMaxExtends)
        fail("'extends' is circular");
    const toml::table root = util::read_toml(file, fail);
    util::allow_only(root, "", {"title", "extends", "crs", "class", "meant"}, fail);
    for (const char* name : {"title", "extends", "crs"})
        if (root.contains(name) && !root[name].is_string())
            fail(std::string(name) + " is no text");
    if (const auto base = root["extends"].value<std::string>()) {
        const fs::path parent = util::base_file(file, *base, "classes");
        if (parent.empty())
            fail("extends = '" + *base + "'; allowed: a table next to it, or " +
                 util::toml_ids(util::config_dir() / "classes"));
        apply(parent, table, depth + 1);
    }
    table.title = root["title"].value_or(table.title);
    if (const auto crs = root["crs"].value<std::string>())
        table.crs = *crs;
    for (const char* name : {"class", "meant"})
        if (root.contains(name) && !root[name].is_table())
            fail(std::string(name) + " is no table; allowed: [" + name + "]");
    // What its base is meant for is not what it is meant for.
    table.meant = root.contains("meant") ? read_meant(*root["meant"].as_table(), fail) : Meant{};
    if (const auto* classes = root["class"].as_table())
        for (const auto& [key, node] : *classes) {
            const std::string name(key.str());
            const int code = to_code(name);
            if (code < 0)
                fail("[class." + name + "]; allowed: 0 to 255");
            table.meaning[static_cast<std::size_t>(code)] = read_meaning(node, name, fail);
        }
}

}  // namespace

ClassTable load_class_table(const std::string& id_or_path, Unnamed unnamed) {
    ClassTable table;
    table.id = id_or_path;
    apply(util::find_toml(id_or_path, "classes", "class table"), table, 0);
    if (unnamed == Unnamed::kGuessed)
        for (ClassMeaning& meaning : table.meaning)
            if (!meaning.known)
                meaning = {Role::kSurface, voxel::Material::kAir, true, false};
    return table;
}

const std::vector<ClassTable>& shipped_class_tables() {
    // Once for the process: a survey may have thousands of files with the same unknown class.
    static const std::vector<ClassTable> tables = [] {
        std::vector<ClassTable> out;
        for (const std::string& id : util::toml_id_list(util::config_dir() / "classes")) {
            try {
                out.push_back(load_class_table(id));
            } catch (const util::Error&) {
                // Only a table that is chosen with --classes has to be readable.
                continue;
            }
        }
        return out;
    }();
    return tables;
}

std::string tables_that_name(const std::bitset<256>& codes) {
    std::string out;
    for (const ClassTable& table : shipped_class_tables()) {
        bool all = true;
        for (std::size_t c = 0; c < codes.size(); ++c)
            all = all && (!codes[c] || table.meaning[c].known);
        if (all)
            out += (out.empty() ? "" : ", ") + table.id;
    }
    return out;
}

}  // namespace terravox::voxelize
