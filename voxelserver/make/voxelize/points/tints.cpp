#include "voxelserver/make/voxelize/points/tints.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/mix.hpp"
#include "common/util/toml_file.hpp"
#include "common/voxel/fingerprint.hpp"

namespace terravox::voxelize {
namespace {

constexpr double kMaxBrightness = 0.5;
constexpr std::size_t kMaxColours = 64;
/// Of each list, those of a district.
constexpr std::uint64_t kDistrictColours = 3;

using Fail = std::function<void(const std::string&)>;

double read_number(const toml::table& table, const std::string& key, double most,
                   const Fail& fail) {
    const auto* node = table.get(key);
    const auto value = node == nullptr ? 0.0 : node->value<double>();
    if (!value || !(*value >= 0 && *value <= most))
        fail(fmt::format("{} is {}; allowed: 0 to {}", key, util::toml_value(*node), most));
    return *value;
}

std::vector<voxel::Rgb8> read_colours(const toml::node& node, const std::string& name,
                                      const Fail& fail) {
    const auto* list = node.as_array();
    if (list == nullptr || list->empty() || list->size() > kMaxColours)
        fail(fmt::format("{} is {}; allowed: a list of 1 to {} colours", name,
                         util::toml_value(node), kMaxColours));
    std::vector<voxel::Rgb8> out;
    for (const auto& item : *list) {
        const auto colour = voxel::rgb8_from_hex(item.value_or(std::string()));
        if (!colour)
            fail(name + " holds " + util::toml_value(item) + "; allowed: \"#rrggbb\"");
        out.push_back(*colour);
    }
    return out;
}

Tints::Region read_region(const toml::node& node, const Fail& fail) {
    const auto* list = node.as_array();
    Tints::Region out{};
    bool is_good = list != nullptr && list->size() == out.size();
    for (std::size_t i = 0; is_good && i < out.size(); ++i) {
        const auto value = (*list)[i].value<double>();
        is_good = value.has_value();
        out[i] = value.value_or(0);
    }
    const auto& [west, south, east, north] = out;
    if (!(is_good && west >= -180 && west < east && east <= 180 && south >= -90 && south < north &&
          north <= 90))
        fail(
            fmt::format("[meant] regions holds {}; allowed: lists of west, south, east, north in "
                        "degrees",
                        list == nullptr ? util::toml_value(node) : "another list"));
    return out;
}

std::vector<Tints::Region> read_regions(const toml::table& meant, const Fail& fail) {
    util::allow_only(meant, "[meant] ", {"regions"}, fail);
    const auto* list = meant["regions"].as_array();
    if (list == nullptr || list->empty())
        fail("[meant] regions is no list of regions");
    std::vector<Tints::Region> out;
    for (const auto& item : *list)
        out.push_back(read_region(item, fail));
    return out;
}

bool holds(const Tints::Region& region, const geo::LatLon& place) noexcept {
    return place.lon_deg >= region[0] && place.lon_deg < region[2] && place.lat_deg >= region[1] &&
           place.lat_deg < region[3];
}

double area(const Tints::Region& region) noexcept {
    return (region[2] - region[0]) * (region[3] - region[1]);
}

voxel::Rgb8 brightened(voxel::Rgb8 colour, double factor) noexcept {
    const auto channel = [&](std::uint8_t v) {
        return static_cast<std::uint8_t>(std::lround(std::clamp(v * factor, 0.0, 255.0)));
    };
    return {channel(colour.r), channel(colour.g), channel(colour.b)};
}

}  // namespace

Tints Tints::load(const std::string& id_or_path) {
    const std::filesystem::path file = util::find_toml(id_or_path, "tints", "tints");
    const auto fail = [&](const std::string& what) {
        throw util::UsageError("read the tints {}: {}", file.string(), what);
    };
    const toml::table root = util::read_toml(file, fail);
    Tints out;
    out.m_id = id_or_path;
    util::allow_only(root, "",
                     {"title", "brightness", "district_share", "wide", "colours", "meant"}, fail);
    out.m_title = root["title"].value_or(std::string());
    out.m_brightness = read_number(root, "brightness", kMaxBrightness, fail);
    out.m_district_share = read_number(root, "district_share", 1, fail);
    if (root.contains("wide") && !root["wide"].is_boolean())
        fail("wide is not true or false");
    out.m_wide = root["wide"].value_or(false);
    if (root.contains("meant") && !root["meant"].is_table())
        fail("meant is no table; allowed: [meant]");
    if (const auto* meant = root["meant"].as_table())
        out.m_regions = read_regions(*meant, fail);
    const auto* colours = root["colours"].as_table();
    if (colours == nullptr)
        fail("colours is no table; allowed: [colours]");
    for (const auto& [key, node] : *colours) {
        const std::string name(key.str());
        const auto material = voxel::material_from_name(name);
        if (!material || *material == voxel::Material::kAir)
            fail("colours." + name + " is no material of materials.toml");
        out.m_colours[voxel::material_index(*material)] =
            read_colours(node, "colours." + name, fail);
    }
    return out;
}

std::optional<voxel::Rgb8> Tints::of(voxel::Material material,
                                     std::uint64_t number) const noexcept {
    return of(material, HouseNumber{number});
}

std::optional<voxel::Rgb8> Tints::of(voxel::Material material,
                                     const HouseNumber& house) const noexcept {
    const auto& colours = m_colours[voxel::material_index(material)];
    if (colours.empty())
        return std::nullopt;
    if (house.typical)
        return colours.front();
    const std::uint64_t salt = static_cast<std::uint64_t>(material) << 56;
    const std::uint64_t dice = util::mix(house.own ^ salt);
    std::uint64_t pick = dice & 0xffffffff;
    if (keeps_to_district(house))
        pick = util::mix(util::mix(house.district ^ salt) + pick % kDistrictColours) & 0xffffffff;
    const double share = static_cast<double>(dice >> 32) / 0x1.0p32;  // [0, 1)
    return brightened(colours[pick % colours.size()], 1 + m_brightness * (2 * share - 1));
}

bool Tints::keeps_to_district(const HouseNumber& house) const noexcept {
    constexpr std::uint64_t kSeed = 3;
    return m_district_share > 0 &&
           static_cast<double>(util::mix(house.own ^ kSeed) >> 32) < m_district_share * 0x1.0p32;
}

void Tints::add_values(voxel::ByteWriter& out) const {
    out.add(m_brightness);
    for (const auto& colours : m_colours) {
        out.add(static_cast<std::uint64_t>(colours.size()));
        for (const voxel::Rgb8& c : colours)
            for (const std::uint8_t channel : {c.r, c.g, c.b})
                out.add(channel);
    }
    // A table without these keeps the fingerprint from before there were districts.
    if (m_district_share > 0 || m_wide) {
        out.add(m_district_share);
        out.add(m_wide);
    }
}

std::vector<Tints> shipped_tints() {
    std::vector<Tints> out;
    for (const std::string& id : util::toml_id_list(util::config_dir() / "tints"))
        out.push_back(Tints::load(id));
    return out;
}

Tints choose_tints(const std::string& wanted, const geo::LatLon& place) {
    if (wanted != kAnyTints)
        return Tints::load(wanted);
    std::optional<Tints> out;
    double smallest = 0;
    for (const Tints& tints : shipped_tints())
        for (const Tints::Region& region : tints.regions())
            if (holds(region, place) && (!out || area(region) < smallest)) {
                smallest = area(region);
                out = tints;
            }
    if (!out)
        return Tints::load("default");
    util::log_info(
        "tints {} ({}), guesses for what has no photograph: the place lies at longitude {:.2f}, "
        "latitude {:.2f}; colour_variation.tints names another table",
        out->id(), out->title(), place.lon_deg, place.lat_deg);
    return *std::move(out);
}

}  // namespace terravox::voxelize
