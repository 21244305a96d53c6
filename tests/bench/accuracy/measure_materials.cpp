#include <array>
#include <cstdio>

#include "tests/bench/accuracy/errors.hpp"
#include "tests/bench/accuracy/measures.hpp"

namespace terravox::bench {
namespace {

using survey::TrueKind;
using voxel::Material;

using Counts = std::array<std::array<std::size_t, voxel::kMaterialCount>, survey::kTrueKindCount>;

bool is_bare(Material m) {
    using enum Material;
    return m == kRock || m == kSoil || m == kGround || m == kGrass || m == kSand || m == kSnow ||
           m == kRoad || m == kConcrete || m == kRail;
}

/// What a kind may be shown as.
bool right(TrueKind kind, Material m) {
    using enum Material;
    switch (kind) {
        case TrueKind::kGrass:
            return m == kGrass || m == kGround || m == kLowVegetation ||
                   m == kSoil;  // crops are low vegetation
        case TrueKind::kBare:
            return m == kGround || m == kRock || m == kSoil || m == kSand || m == kConcrete;
        case TrueKind::kRoad: return m == kRoad || m == kConcrete;
        case TrueKind::kGravelRoad:
            return m == kRoad || m == kConcrete || m == kGround || m == kSand || m == kSoil;
        case TrueKind::kWater: return m == kWater;
        case TrueKind::kTree: return voxel::is_plant(m);
        case TrueKind::kRoofRed: return m == kOrangeRoof;
        case TrueKind::kRoofGrey: return m == kGreyRoof;
        case TrueKind::kRoofPale: return m == kFlatRoof || m == kConcrete;
        case TrueKind::kRoofCopper:
            return m == kRoof || m == kGreyRoof || m == kFlatRoof;  // no material of its own
        case TrueKind::kBridge: return m == kBridge;
        case TrueKind::kWire: return m == kWire;
        case TrueKind::kPylon: return m == kTower;
    }
    return false;
}

/// The coarse question: ground, water, plant, building, bridge or mast.
bool right_group(TrueKind kind, Material m) {
    switch (kind) {
        case TrueKind::kGrass: return is_bare(m) || m == Material::kLowVegetation;
        case TrueKind::kBare:
        case TrueKind::kRoad:
        case TrueKind::kGravelRoad: return is_bare(m);
        case TrueKind::kRoofRed:
        case TrueKind::kRoofGrey:
        case TrueKind::kRoofPale:
        case TrueKind::kRoofCopper: return is_building(m);
        default: return right(kind, m);
    }
}

bool alike_around(const TruthPlace& truth, int column, int row) {
    const TrueKind kind = truth.columns[truth.area.index(column, row)].kind;
    for (int dr = -1; dr <= 1; ++dr)
        for (int dc = -1; dc <= 1; ++dc)
            if (truth.area.holds(column + dc, row + dr) &&
                truth.columns[truth.area.index(column + dc, row + dr)].kind != kind)
                return false;
    return true;
}

/// A row for each true kind: how many columns, and which share of them is shown as what (1 % and
/// more).
std::string make_table(const Counts& counts) {
    std::string out =
        "true kind x material of the highest voxel, share of the kind's columns (right ones in "
        "bold)\n\n";
    out += "| true kind | columns | found |\n|---|---:|---|\n";
    for (std::size_t k = 1; k < counts.size(); ++k) {
        std::size_t sum = 0;
        for (const std::size_t n : counts[k])
            sum += n;
        if (sum == 0)
            continue;
        const auto kind = static_cast<TrueKind>(k);
        std::string cells;
        for (std::size_t m = 0; m < counts[k].size(); ++m) {
            const double share = static_cast<double>(counts[k][m]) / static_cast<double>(sum);
            if (share < 0.01)
                continue;
            const auto material = static_cast<Material>(m);
            std::array<char, 32> percent{};
            std::snprintf(percent.data(), percent.size(), " %.0f %%", 100 * share);
            const std::string mark = right(kind, material) ? "**" : "";
            cells += (cells.empty() ? "" : ", ") + mark +
                     std::string(voxel::material_name(material)) + percent.data() + mark;
        }
        out += "| " + std::string(to_name(kind)) + " | " + std::to_string(sum) + " | " + cells +
               " |\n";
    }
    return out;
}

}  // namespace

void measure_materials(const TruthPlace& truth, const VoxelField& found, Readings& readings) {
    Counts counts{};
    Share wrong;
    Share wrong_group;
    Share wrong_inside;
    Share missing;
    std::array<Share, survey::kTrueKindCount> by_kind;
    for (int row = 0; row < truth.area.height; ++row)
        for (int column = 0; column < truth.area.width; ++column) {
            const std::size_t i = truth.area.index(column, row);
            const TrueKind kind = truth.columns[i].kind;
            const auto runs = found.runs(i);
            missing.add(runs.empty());
            const Material m = runs.empty() ? Material::kAir : runs.back().material;
            ++counts[static_cast<std::size_t>(kind)][static_cast<std::size_t>(m)];
            wrong.add(!right(kind, m));
            wrong_group.add(!right_group(kind, m));
            by_kind[static_cast<std::size_t>(kind)].add(!right(kind, m));
            if (alike_around(truth, column, row))
                wrong_inside.add(!right(kind, m));
        }
    readings.add("surface: wrong material", "share", wrong.value());
    readings.add("surface: wrong material, a column or more inside", "share", wrong_inside.value());
    readings.add("surface: wrong group of materials", "share", wrong_group.value());
    readings.add("surface: columns without voxels", "share", missing.value());
    for (std::size_t k = 1; k < by_kind.size(); ++k)
        if (by_kind[k].asked > 0)
            readings.add(
                "surface: wrong material, " + std::string(to_name(static_cast<TrueKind>(k))),
                "share", by_kind[k].value());
    readings.note(make_table(counts));
}

}  // namespace terravox::bench
