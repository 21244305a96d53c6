#include "voxelserver/data/imagery/colour_map.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "common/util/det_math.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/imagery/palette_file.hpp"

namespace terravox::imagery {
namespace {

/// The contributions of one channel to X/Xn, Y/Yn and Z/Zn.
struct Share {
    double x;
    double y;
    double z;
};

using Shares = std::array<std::array<Share, 256>, 3>;

Shares make_shares() noexcept {
    // Linear sRGB to XYZ; each row is divided by its sum, which is the white point.
    constexpr double kMatrix[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                      {0.2126729, 0.7151522, 0.0721750},
                                      {0.0193339, 0.1191920, 0.9503041}};
    Shares out{};
    for (std::size_t v = 0; v < 256; ++v) {
        const double s = static_cast<double>(v) / 255;
        const double linear = s <= 0.04045 ? s / 12.92 : det::pow((s + 0.055) / 1.055, 2.4);
        for (std::size_t c = 0; c < 3; ++c) {
            const auto part = [&](int row) {
                return linear * kMatrix[row][c] /
                       (kMatrix[row][0] + kMatrix[row][1] + kMatrix[row][2]);
            };
            out[c][v] = {part(0), part(1), part(2)};
        }
    }
    return out;
}

double f(double t) noexcept {
    constexpr double kEdge = 216.0 / 24389;
    constexpr double kSlope = 24389.0 / 27;
    return t > kEdge ? cube_root(t) : (kSlope * t + 16) / 116;
}

}  // namespace

Lab to_lab(voxel::Rgb8 colour) noexcept {
    static const Shares shares = make_shares();
    const Share &r = shares[0][colour.r], &g = shares[1][colour.g], &b = shares[2][colour.b];
    const double x = f(r.x + g.x + b.x);
    const double y = f(r.y + g.y + b.y);
    const double z = f(r.z + g.z + b.z);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

using voxel::Material;
using voxel::Rgb8;

namespace {

constexpr std::size_t kMaxEntries = 512;

}  // namespace

/// Builds a ColourMap from a palette and those that it extends.
class ColourMapLoader {
public:
    ColourMap load(const std::string& id_or_path) {
        const auto files = read_palette(id_or_path);
        for (const PaletteFile& file : files) {
            read_space(file);
            read_candidates(file);
            read_rules(file);
            read_entries(file);
        }
        check(files.back());
        m_map.m_entry_count = m_entries.size();
        m_map.build_sets(m_entries);
        return std::move(m_map);
    }

private:
    void read_space(const PaletteFile& file) {
        if (const auto* node = file.root().get("space")) {
            const auto space = node->value<std::string>().value_or("");
            if (space != "cielab" && space != "rgb")
                file.fail("space = '" + space + "'; allowed: cielab, rgb");
            m_map.m_cielab = space == "cielab";
        }
        m_map.m_lightness_weight =
            file.number(file.root(), "", "lightness_weight", 0.05, 4, m_map.m_lightness_weight);
    }

    void read_candidates(const PaletteFile& file) {
        const auto* node = file.root().get("candidates");
        if (node == nullptr)
            return;
        const auto* table = node->as_table();
        if (table == nullptr)
            file.fail("candidates is no table; allowed: [candidates]");
        file.allow_only(*table, "[candidates] ",
                        {"ground", "dry_ground", "building", "vegetation", "water"});
        const auto set = [&](Group group, const char* name) {
            if (table->contains(name))
                m_map.m_candidates[static_cast<std::size_t>(group)] =
                    file.materials(*table, "[candidates] ", name);
        };
        set(Group::kGround, "ground");
        set(Group::kDryGround, "dry_ground");
        set(Group::kBuilding, "building");
        set(Group::kVegetation, "vegetation");
        set(Group::kWater, "water");
    }

    void read_rules(const PaletteFile& file) {
        const auto rows = file.rows("ndvi");
        if (!rows.empty())
            m_map.m_rules.clear();
        constexpr std::size_t kMaxRules = 16;
        if (rows.size() > kMaxRules)
            file.fail("[[ndvi]] has " + std::to_string(rows.size()) + " rows; allowed: up to 16");
        for (const toml::table* row : rows) {
            const std::string where =
                "[[ndvi]] row " + std::to_string(m_map.m_rules.size() + 1) + " ";
            file.allow_only(*row, where,
                            {"name", "above", "below", "darker_than", "only", "forbids"});
            ColourMap::NdviRule rule;
            rule.above = static_cast<float>(file.number(*row, where, "above", -1, 1, -2));
            rule.below = static_cast<float>(file.number(*row, where, "below", -1, 1, 2));
            rule.darker_than = file.number(*row, where, "darker_than", 0, 100, 1000);
            if (row->contains("only") == row->contains("forbids"))
                file.fail(where + "needs one of: only, forbids");
            rule.only = row->contains("only") ? file.materials(*row, where, "only")
                                              : ~file.materials(*row, where, "forbids");
            m_map.m_rules.push_back(rule);
        }
    }

    void read_entries(const PaletteFile& file) {
        const auto rows = file.rows("entry");
        if (!rows.empty())
            m_entries.clear();
        if (rows.size() > kMaxEntries)
            file.fail("[[entry]] has " + std::to_string(rows.size()) + " rows; allowed: up to 512");
        for (const toml::table* row : rows) {
            const std::string where = "[[entry]] row " + std::to_string(m_entries.size() + 1) + " ";
            file.allow_only(*row, where, {"material", "colour", "note"});
            const std::string text = (*row)["colour"].value_or(std::string());
            const auto colour = parse_hex(text);
            if (!colour)
                file.fail(where + "colour = '" + text + "'; allowed: \"#rrggbb\"");
            m_entries.push_back(
                {file.material(where + "material", (*row)["material"].value_or(std::string())),
                 *colour});
        }
    }

    static std::optional<Rgb8> parse_hex(const std::string& text) {
        if (text.size() != 7 || text[0] != '#' ||
            text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
            return std::nullopt;
        const unsigned long v = std::stoul(text.substr(1), nullptr, 16);
        return Rgb8{static_cast<std::uint8_t>(v >> 16), static_cast<std::uint8_t>(v >> 8 & 255),
                    static_cast<std::uint8_t>(v & 255)};
    }

    void check(const PaletteFile& file) const {
        MaterialSet mapped = 0;
        MaterialSet requested = 0;
        for (const auto& e : m_entries)
            mapped |= to_bit(e.material);
        for (const MaterialSet c : m_map.m_candidates)
            requested |= c;
        for (int m = 0; m < voxel::kMaterialCount; ++m)
            if ((requested & ~mapped & to_bit(static_cast<Material>(m))) != 0)
                file.fail("[candidates] names '" +
                          std::string(voxel::material_name(static_cast<Material>(m))) +
                          "', which no [[entry]] has; allowed: materials with an entry");
        if (requested == 0)
            file.fail(
                "[candidates] is missing or empty; allowed: lists of materials for ground, "
                "dry_ground, building, vegetation, water");
    }

    ColourMap m_map;
    std::vector<ColourMap::Entry> m_entries;
};

ColourMap ColourMap::load(const std::string& id_or_path) {
    return ColourMapLoader().load(id_or_path);
}

ColourMap::Place ColourMap::find_place(Rgb8 colour, double& lightness) const noexcept {
    const Lab lab = to_lab(colour);
    lightness = lab.l;
    if (!m_cielab)
        return {colour.r * 16, colour.g * 16, colour.b * 16};
    const auto steps = [](double v) {
        return static_cast<std::int32_t>(v * 64 + (v < 0 ? -0.5 : 0.5));
    };
    return {steps(lab.l * m_lightness_weight), steps(lab.a), steps(lab.b)};
}

void ColourMap::build_sets(const std::vector<Entry>& entries) {
    m_sets.resize(m_rules.size() + 1);
    for (std::size_t r = 0; r < m_sets.size(); ++r)
        for (std::size_t g = 0; g < kGroupCount; ++g) {
            MaterialSet allowed =
                m_candidates[g] & (r == 0 ? ~MaterialSet{0} : m_rules[r - 1].only);
            if (allowed == 0)
                allowed = m_candidates[g];  // a rule about materials of other groups
            Set& set = m_sets[r][g];
            for (const Entry& e : entries) {
                if ((allowed & to_bit(e.material)) == 0)
                    continue;
                double lightness = 0;
                const Place p = find_place(e.colour, lightness);
                set.x.push_back(p.x);
                set.y.push_back(p.y);
                set.z.push_back(p.z);
                set.material.push_back(e.material);
                set.materials |= to_bit(e.material);
            }
            while (set.material.size() % 4 != 0) {
                set.x.push_back(set.x[0]);
                set.y.push_back(set.y[0]);
                set.z.push_back(set.z[0]);
                set.material.push_back(set.material[0]);
            }
        }
}

const ColourMap::Set& ColourMap::set_for(Group group, float index,
                                         double lightness) const noexcept {
    std::size_t fits = 0;
    for (std::size_t r = 0; r < m_rules.size() && fits == 0;
         ++r)  // every comparison with an unknown index (NaN) is false
        if (index > m_rules[r].above && index < m_rules[r].below &&
            lightness < m_rules[r].darker_than)
            fits = r + 1;
    return m_sets[fits][static_cast<std::size_t>(group)];
}

Material ColourMap::nearest(Rgb8 colour, Group group, float index) const noexcept {
    if (candidates(group) == 0)
        return Material::kAir;
    double lightness = 0;
    const Place p = find_place(colour, lightness);
    const Set& set = set_for(group, index, lightness);
    // Two plain loops, which compilers vectorise; a single loop that tracks the nearest is three
    // times slower.
    std::array<std::int32_t, kMaxEntries + 3> distances;
    const std::size_t count = set.material.size();
    std::int32_t least = std::numeric_limits<std::int32_t>::max();
    for (std::size_t i = 0; i < count; ++i) {
        const std::int32_t dx = p.x - set.x[i];
        const std::int32_t dy = p.y - set.y[i];
        const std::int32_t dz = p.z - set.z[i];
        const std::int32_t d = dx * dx + dy * dy + dz * dz;
        distances[i] = d;
        least = std::min(least, d);
    }
    std::size_t nearest = 0;
    while (distances[nearest] != least)
        ++nearest;
    return set.material[nearest];
}

void ColourMap::add_values(voxel::ByteWriter& out) const {
    out.add(m_cielab);
    out.add(m_lightness_weight);
    for (const MaterialSet c : m_candidates)
        out.add(c);
    out.add(m_rules.size());
    for (const NdviRule& r : m_rules) {
        out.add(r.above);
        out.add(r.below);
        out.add(r.darker_than);
        out.add(r.only);
    }
    for (const auto& by_group : m_sets)
        for (const Set& s : by_group) {
            out.add_all(s.x);
            out.add_all(s.y);
            out.add_all(s.z);
            out.add_all(s.material);
        }
}

Material ColourMap::by_ndvi(Group group, float index) const noexcept {
    // Below no limit that a file may set, so that rules for dark colours do not apply.
    constexpr double kUnknownLightness = 999;
    const Set& set = set_for(group, index, kUnknownLightness);
    const bool single = !set.material.empty() && set.materials == to_bit(set.material.front());
    return single ? set.material.front() : Material::kAir;
}

}  // namespace terravox::imagery
