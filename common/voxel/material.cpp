#include "common/voxel/material.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/toml_file.hpp"

namespace terravox::voxel {
namespace {

constexpr std::array<std::string_view, 10> kLookFields = {
    "colour", "variation",  "texture", "kind",     "roughness",
    "index",  "absorption", "glow",    "emission", "reflects"};

}  // namespace

std::optional<Material> material_from_name(std::string_view name) noexcept {
    for (const MaterialTraits& traits : kMaterialTraits)
        if (traits.name == name)
            return traits.material;
    return std::nullopt;
}

std::optional<Rgb8> rgb8_from_hex(std::string_view text) noexcept {
    if (text.size() != 7 || text[0] != '#')
        return std::nullopt;
    std::array<std::uint8_t, 3> out{};
    for (std::size_t i = 0; i < 6; ++i) {
        const char c = text[i + 1];
        int digit = 0;
        if (c >= '0' && c <= '9')
            digit = c - '0';
        else if (c >= 'a' && c <= 'f')
            digit = c - 'a' + 10;
        else if (c >= 'A' && c <= 'F')
            digit = c - 'A' + 10;
        else
            return std::nullopt;
        out[i / 2] = static_cast<std::uint8_t>(out[i / 2] * 16 + digit);
    }
    return Rgb8{out[0], out[1], out[2]};
}

bool is_appearance_field(std::string_view name) noexcept {
    return std::find(kLookFields.begin(), kLookFields.end(), name) != kLookFields.end();
}

std::string appearance_fields() {
    std::string out;
    for (const auto field : kLookFields)
        out += (out.empty() ? "" : ", ") + std::string(field);
    return out;
}

Palette load_palette(const std::filesystem::path& file) {
    const auto fail = [&](const std::string& what) -> void {
        throw util::UsageError("read the materials {}: {}", file.string(), what);
    };
    const toml::table root = util::read_toml(file, fail);
    Palette palette;
    for (std::size_t i = 1; i < palette.entries.size(); ++i) {
        const std::string_view name = kMaterialTraits[i].name;
        const auto entry = root[name];
        const auto text = entry["colour"].value<std::string>();
        if (!text)
            fail("[" + std::string(name) + "] colour is missing; allowed: \"#rrggbb\"");
        const auto colour = rgb8_from_hex(*text);
        if (!colour)
            fail("[" + std::string(name) + "] colour = '" + *text + "'; allowed: \"#rrggbb\"");
        const auto variation = entry["variation"] ? entry["variation"].value<double>() : 0.0;
        if (!variation || !(*variation >= 0 && *variation <= 1))
            fail("[" + std::string(name) + "] variation = " +
                 (variation ? std::to_string(*variation) : "not a number") + "; allowed: 0 to 1");
        palette.entries[i] = {*colour, static_cast<float>(*variation)};
    }
    for (const auto& [name, node] : root) {
        const auto known = material_from_name(name.str());
        if (!known || *known == Material::kAir)
            fail("[" + std::string(name.str()) + "] is no material");
        for (const auto& [field, value] : *node.as_table())
            if (!is_appearance_field(field.str()))
                fail("[" + std::string(name.str()) + "] " + std::string(field.str()) +
                     " is no field; allowed: " + appearance_fields());
    }
    return palette;
}

}  // namespace terravox::voxel
