#include "voxelserver/make/voxelize/steps/colour_variation.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/util/error.hpp"
#include "common/util/mix.hpp"
#include "common/util/toml_file.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxelize {
namespace {

constexpr double kMaxBrightness = 0.5;
constexpr std::size_t kMaxColours = 64;

}  // namespace

Tints Tints::load(const std::string& id_or_path) {
    const std::filesystem::path file = util::find_toml(id_or_path, "tints", "tints");
    const auto fail = [&](const std::string& what) {
        throw util::UsageError("read the tints {}: {}", file.string(), what);
    };
    const toml::table root = util::read_toml(file, fail);
    Tints out;
    util::allow_only(root, "", {"title", "brightness", "colours"}, fail);
    if (const auto* node = root.get("brightness")) {
        const auto value = node->value<double>();
        if (!value || !(*value >= 0 && *value <= kMaxBrightness))
            fail(fmt::format("brightness is {}; allowed: 0 to {}", util::toml_value(*node),
                             kMaxBrightness));
        out.m_brightness = *value;
    }
    const auto* colours = root["colours"].as_table();
    if (colours == nullptr)
        fail("colours is no table; allowed: [colours]");
    for (const auto& [key, node] : *colours) {
        const std::string name(key.str());
        const auto material = voxel::material_from_name(name);
        const auto* list = node.as_array();
        if (!material || *material == voxel::Material::kAir)
            fail("colours." + name + " is no material of materials.toml");
        if (list == nullptr || list->empty() || list->size() > kMaxColours)
            fail("colours." + name +
                 fmt::format(" is {}; allowed: a list of 1 to {} colours", util::toml_value(node),
                             kMaxColours));
        for (const auto& item : *list) {
            const auto colour = voxel::rgb8_from_hex(item.value_or(std::string()));
            if (!colour)
                fail("colours." + name + " holds " + util::toml_value(item) +
                     "; allowed: \"#rrggbb\"");
            out.m_colours[voxel::material_index(*material)].push_back(*colour);
        }
    }
    return out;
}

std::optional<voxel::Rgb8> Tints::of(voxel::Material material,
                                     std::uint64_t number) const noexcept {
    const auto& colours = m_colours[voxel::material_index(material)];
    if (colours.empty())
        return std::nullopt;
    const std::uint64_t dice = util::mix(number ^ static_cast<std::uint64_t>(material) << 56);
    const voxel::Rgb8 colour = colours[(dice & 0xffffffff) % colours.size()];
    const double share = static_cast<double>(dice >> 32) / 0x1.0p32;  // [0, 1)
    const double factor = 1 + m_brightness * (2 * share - 1);
    const auto channel = [&](std::uint8_t v) {
        return static_cast<std::uint8_t>(std::lround(std::clamp(v * factor, 0.0, 255.0)));
    };
    return voxel::Rgb8{channel(colour.r), channel(colour.g), channel(colour.b)};
}

void Tints::add_values(voxel::ByteWriter& out) const {
    out.add(m_brightness);
    for (const auto& colours : m_colours) {
        out.add(static_cast<std::uint64_t>(colours.size()));
        for (const voxel::Rgb8& c : colours)
            for (const std::uint8_t channel : {c.r, c.g, c.b})
                out.add(channel);
    }
}

std::uint64_t number_of_place(std::int32_t x, std::int32_t z, std::uint64_t seed) noexcept {
    return util::mix(util::mix(static_cast<std::uint32_t>(x) |
                               static_cast<std::uint64_t>(static_cast<std::uint32_t>(z)) << 32) ^
                     seed);
}

namespace {

constexpr std::uint64_t kBuildingSeed = 1;
constexpr std::uint64_t kTreeSeed = 2;

std::uint64_t number(std::int32_t x, std::int32_t z, std::uint64_t seed) noexcept {
    const std::uint64_t out = number_of_place(x, z, seed);
    return out == PlaceNumbers::kNone ? seed : out;
}

}  // namespace

PlaceNumbers number_places(const Window& window, const ClassTable& classes,
                           const Buildings& buildings, const Margined<Roof>& roofs,
                           const Margined<Crown>& crowns, const Tints& tints, double voxel_m) {
    PlaceNumbers out;
    out.tints = &tints;
    if (window.any(&PatchColumns::any_roof)) {
        Margined<char>::each([&](int x, int z) {
            const Roof& roof = roofs.at(x, z);
            if (!roof.seen())
                return;
            const Building* building = buildings.at(x + roof.appearance_dx, z + roof.appearance_dz);
            if (building != nullptr)
                out.building.at(x, z) = number(building->x, building->z, kBuildingSeed);
        });
    }
    if (window.any(&PatchColumns::any_objects)) {
        TreePlaces trees(window, classes, voxel_m);
        Margined<char>::each([&](int x, int z) {
            if (!crowns.at(x, z).seen() && window.objects(x, z).empty())
                return;
            const auto [tree_x, tree_z] = trees.at(x, z);
            out.tree.at(x, z) = number(tree_x, tree_z, kTreeSeed);
        });
    }
    return out;
}

}  // namespace terravox::voxelize
