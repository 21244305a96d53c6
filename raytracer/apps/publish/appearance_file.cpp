#include "raytracer/apps/publish/appearance_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "common/gzip/gzip.hpp"
#include "common/util/det_math.hpp"
#include "common/voxel/material.hpp"
#include "raytracer/core/material/material_table.hpp"
#include "raytracer/core/material/texture_list.hpp"
#include "raytracer/core/material/windows.hpp"
#include "raytracer/core/sky/dome.hpp"
#include "raytracer/core/sky/sky_table.hpp"

namespace terravox::publish {
namespace {

using nlohmann::json;

constexpr std::size_t kMagicBytes = 8;
constexpr char kMagic[kMagicBytes + 1] = "TVXLOOK\n";
constexpr std::uint32_t kVersion = 1;
constexpr double kRad = det::kPi / 180;

// Close together where light changes fast.
constexpr std::array kSkyAltitudes_deg = {-18.0, -12.0, -9.0, -6.0, -4.0, -3.0, -2.0, -1.0,
                                          0.0,   1.0,   2.0,  3.0,  5.0,  8.0,  12.0, 18.0,
                                          25.0,  35.0,  45.0, 60.0, 75.0, 90.0};
constexpr std::array kSunAltitudes_deg = {0.0,  0.25, 0.5,  0.75, 1.0,  1.5,  2.0,  3.0,
                                          4.0,  5.0,  6.0,  8.0,  10.0, 13.0, 16.0, 20.0,
                                          25.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0};
// As in SkyTable: rows at elevations of sine (i / last)^2, columns at azimuths whose half has the
// sine j / last.
constexpr int kSkyRows = 20;
constexpr int kSkyColumns = 13;

/// Half floats, and where the parts of them lie.
class Halves {
public:
    void add(const voxel::Colour& colour) {
        add(colour.r);
        add(colour.g);
        add(colour.b);
    }
    void add(float value) { m_values.push_back(to_half(value)); }
    [[nodiscard]] std::size_t size() const noexcept { return m_values.size(); }
    [[nodiscard]] std::span<const std::uint16_t> values() const noexcept { return m_values; }

private:
    std::vector<std::uint16_t> m_values;
};

json numbers(const voxel::Colour& c) {
    return json::array({c.r, c.g, c.b});
}

json face_json(const material::PaintedFace& face) {
    return {{"first", face.first},       {"ownFirst", face.own_first},
            {"variants", face.variants}, {"turns", static_cast<int>(face.turn)},
            {"metric", face.metric},     {"layered", face.layered},
            {"hasOwn", face.has_own},    {"hasHoles", face.has_holes}};
}

json material_json(const material::MaterialAppearances& all, const material::MaterialTable& table,
                   std::size_t number) {
    const auto material = static_cast<voxel::Material>(number);
    const material::MaterialAppearance& look = all[number];
    const auto textures = material::textures();
    const material::Texture& texture =
        textures[static_cast<std::size_t>(look.texture) % textures.size()];
    const voxel::Colour own = texture.own == voxel::Material::kAir
                                  ? voxel::Colour{1, 1, 1}
                                  : all[static_cast<std::size_t>(texture.own)].colour;
    return {{"name", voxel::material_name(material)},
            {"kind", static_cast<int>(look.kind)},
            {"colour", numbers(look.colour)},
            {"variation", look.variation},
            {"roughness", look.roughness},
            {"index", look.index},
            {"reflects", look.reflects},
            {"absorption_per_m", numbers(look.absorption_per_m)},
            {"glow", numbers(look.glow)},
            {"emission", numbers(look.emission)},
            {"own", numbers(own)},
            {"windows", texture.windows},
            {"waves", texture.waves},
            {"side", face_json(table.painted(material, core::Face::kWest))},
            {"bottom", face_json(table.painted(material, core::Face::kBottom))},
            {"top", face_json(table.painted(material, core::Face::kTop))}};
}

/// A drawing as it lies in the pool: each texel of each mip of each variant.
template <class Add>
void for_each_dot(const material::TexturePool& pool, const material::PaintedFace& face,
                  const Add& add) {
    for (std::uint32_t variant = 0; variant < face.variants; ++variant)
        for (int mip = 0; mip < material::kMips; ++mip) {
            const int size = material::kTexels >> mip;
            for (int t = 0; t < size; ++t)
                for (int s = 0; s < size; ++s)
                    add(pool.dot(face, variant, mip, s, t));
        }
}

/// All drawings of a pool, in its order; the numbers of faces in `material_json` refer to it.
struct Drawings {
    Halves ratio;  ///< red, green, blue, opacity
    Halves own;    ///< red, green, blue, share
};

Drawings list_drawings(const material::MaterialTable& table) {
    std::vector<material::PaintedFace> faces;
    for (std::size_t i = 0; i < voxel::kMaterialCount; ++i)
        for (const core::Face face : {core::Face::kTop, core::Face::kWest, core::Face::kBottom}) {
            const auto& painted = table.painted(static_cast<voxel::Material>(i), face);
            if (painted.variants != 0)
                faces.push_back(painted);
        }
    // A drawing that several faces share is written once, with the greatest number of variants.
    std::sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first < b.first : a.variants > b.variants;
    });
    Drawings out;
    for (const material::PaintedFace& face : faces) {
        constexpr std::size_t kTexel = 4;
        if (face.first * kTexel < out.ratio.size())
            continue;
        for_each_dot(table.pool(), face, [&](const material::Dot& dot) {
            out.ratio.add(dot.ratio);
            out.ratio.add(dot.opacity);
            if (!face.has_own)
                return;
            out.own.add(dot.own);
            out.own.add(dot.share);
        });
    }
    return out;
}

Halves list_panes(const material::Windows& windows) {
    Halves out;
    for (int style = 0; style < material::Windows::kStyles; ++style)
        for (int mip = 0; mip < material::kMips; ++mip) {
            const int size = material::kTexels >> mip;
            for (int t = 0; t < size; ++t)
                for (int s = 0; s < size; ++s) {
                    const material::Windows::Pane& pane = windows.pane(style, mip, s, t);
                    out.add(pane.own);
                    out.add(pane.share);
                    out.add(pane.glass);
                    for (int unused = 0; unused < 3; ++unused)
                        out.add(0.0f);
                }
        }
    return out;
}

Halves find_sky(const sky::Atmosphere& atmosphere, double place_height_m) {
    Halves out;
    const double scale = sky::picture_scale() * det::kPi;
    for (const double altitude_deg : kSkyAltitudes_deg) {
        const sky::Scattering scattering(atmosphere, altitude_deg * kRad);
        for (int row = 0; row < kSkyRows; ++row)
            for (int column = 0; column < kSkyColumns; ++column) {
                const double u = static_cast<double>(row) / (kSkyRows - 1);
                const double v = static_cast<double>(column) / (kSkyColumns - 1);
                const sky::Scattered seen = scattering.seen(place_height_m, u * u, 1 - 2 * v * v);
                out.add(sky::sun_colour(seen.rayleigh, scale));
                out.add(sky::sun_colour(seen.mie, scale));
                out.add(sky::sun_colour(seen.multiple, scale));
            }
    }
    return out;
}

json sky_json(const sky::Atmosphere& atmosphere, const AirOptions& air) {
    const sky::Haze haze(air.turbidity, air.place_height_m, std::nullopt);
    json light = json::array();
    for (const double altitude_deg : kSunAltitudes_deg)
        light.push_back(numbers(sky::in_gamut(sky::sun_colour(
            atmosphere.transmittance(air.place_height_m, det::sin(altitude_deg * kRad)),
            sky::picture_scale()))));
    return {{"altitudes_deg", kSkyAltitudes_deg},
            {"rows", kSkyRows},
            {"columns", kSkyColumns},
            {"sunAltitudes_deg", kSunAltitudes_deg},
            {"sunLight", light},
            {"hazeRayleigh_per_m", numbers(haze.rayleigh_per_m())},
            {"hazeMie_per_m", numbers(haze.mie_per_m())},
            {"night", numbers(sky::kNightLight)},
            {"ground", numbers(sky::ground_colour())}};
}

void append(std::string& to, std::uint32_t value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    to.append(bytes, sizeof value);
}

}  // namespace

std::string appearance_file(const material::MaterialAppearances& appearances,
                            const AirOptions& air) {
    const material::MaterialTable table(appearances);
    const sky::Atmosphere atmosphere(air.turbidity);
    const Drawings drawings = list_drawings(table);
    const Halves panes = list_panes(material::Windows());
    const Halves sky = find_sky(atmosphere, air.place_height_m);

    json facts = {{"sky", sky_json(atmosphere, air)}};
    for (std::size_t i = 0; i < voxel::kMaterialCount; ++i)
        facts["materials"].push_back(material_json(appearances, table, i));
    std::string halves;
    const auto add = [&](const char* name, const Halves& part) {
        facts["arrays"][name] = {{"offset", halves.size()}, {"halves", part.size()}};
        const auto bytes = std::as_bytes(part.values());
        halves.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    add("ratio", drawings.ratio);
    add("own", drawings.own);
    add("panes", panes);
    add("sky", sky);

    std::string text = facts.dump();
    constexpr std::size_t kAlign = 8;
    text.append((kAlign - text.size() % kAlign) % kAlign, ' ');
    std::string out(kMagic, kMagicBytes);
    append(out, kVersion);
    append(out, static_cast<std::uint32_t>(text.size()));
    return gzip::pack(out + text + halves);
}

}  // namespace terravox::publish
