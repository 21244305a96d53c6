#include "voxelserver/make/voxelize/points/class_table.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
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

void apply(const fs::path& file, ClassTable& table, int depth) {
    const auto fail = [&](const std::string& what) {
        throw util::UsageError("read the class table {}: {}", file.string(), what);
    };
    constexpr int kMaxExtends = 8;
    if (depth > kMaxExtends)
        fail("'extends' is circular");
    const toml::table root = util::read_toml(file, fail);
    util::allow_only(root, "", {"title", "extends", "crs", "class"}, fail);
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
    if (const auto crs = root["crs"].value<std::string>())
        table.crs = *crs;
    if (root.contains("class") && !root["class"].is_table())
        fail("class is no table; allowed: [class]");
    const auto* classes = root["class"].as_table();
    if (classes == nullptr)
        return;
    for (const auto& [key, node] : *classes) {
        const std::string name(key.str());
        const bool number =
            !name.empty() && name.size() <= 3 &&
            std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
        const int code = number ? std::stoi(name) : -1;
        if (code < 0 || code > 255)
            fail("[class." + name + "]; allowed: 0 to 255");
        const auto* entry = node.as_table();
        if (entry == nullptr)
            fail("[class." + name + "] is not a table");
        util::allow_only(*entry, "[class." + name + "] ", {"role", "material", "tiers"}, fail);
        if (entry->contains("tiers") && !(*entry)["tiers"].is_boolean())
            fail("[class." + name + "] tiers is not true or false");
        ClassMeaning meaning;
        meaning.known = true;
        const std::string role = (*entry)["role"].value_or(std::string());
        const auto found = std::find_if(kRoles.begin(), kRoles.end(),
                                        [&](const auto& r) { return role == r.first; });
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
        table.meaning[static_cast<std::size_t>(code)] = meaning;
    }
}

}  // namespace

ClassTable load_class_table(const std::string& id_or_path) {
    ClassTable table;
    table.id = id_or_path;
    apply(util::find_toml(id_or_path, "classes", "class table"), table, 0);
    return table;
}

namespace {

/// The tables of config/classes with the codes that they define.
std::vector<std::pair<std::string, std::bitset<256>>> shipped_tables() {
    std::vector<std::pair<std::string, std::bitset<256>>> out;
    for (const std::string& id : util::toml_id_list(util::config_dir() / "classes")) {
        try {
            const ClassTable table = load_class_table(id);
            std::bitset<256> named;
            for (std::size_t c = 0; c < named.size(); ++c)
                named[c] = table.meaning[c].known;
            out.emplace_back(id, named);
        } catch (const util::Error&) {
            // Only a table that is chosen with --classes has to be readable.
            continue;
        }
    }
    return out;
}

}  // namespace

std::string tables_that_name(const std::bitset<256>& codes) {
    // Once for the process: a survey may have thousands of files with the same unknown class.
    static const std::vector<std::pair<std::string, std::bitset<256>>> tables = shipped_tables();
    std::string out;
    for (const auto& [id, named] : tables)
        if ((codes & ~named).none())
            out += (out.empty() ? "" : ", ") + id;
    return out;
}

}  // namespace terravox::voxelize
