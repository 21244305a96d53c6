#include <array>
#include <utility>

#include "tests/bench/accuracy/errors.hpp"
#include "tests/bench/accuracy/measures.hpp"

namespace terravox::bench {
namespace {

constexpr std::array<std::pair<int, int>, 4> kSides{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};

voxel::Material material_at(std::span<const FoundRun> runs, int y) noexcept {
    for (const FoundRun& run : runs)
        if (y >= run.y0 && y < run.y1)
            return run.material;
    return voxel::Material::kAir;
}

}  // namespace

void measure_facades(const VoxelField& found, Readings& readings) {
    const Area& area = found.area();
    Share leaves;
    for (int row = 0; row < area.height; ++row)
        for (int column = 0; column < area.width; ++column)
            for (const FoundRun& run : found.runs(area.index(column, row)))
                for (const auto& [dc, dr] : kSides) {
                    if (!is_building(run.material) || !area.holds(column + dc, row + dr))
                        continue;
                    const auto beside = found.runs(area.index(column + dc, row + dr));
                    for (int y = run.y0; y < run.y1 && !beside.empty(); ++y)
                        if (const auto m = material_at(beside, y);
                            m == voxel::Material::kAir || voxel::is_plant(m))
                            leaves.add(voxel::is_plant(m));
                }
    readings.add("facades: faces in leaves", "share", leaves.value(), at_most(0.01));
}

void measure_crowns(const VoxelField& found, Readings& readings) {
    double trunks = 0;
    double crowns = 0;
    for (std::size_t i = 0; i < found.area().size(); ++i) {
        const auto crown = [](voxel::Material m) {
            return m == voxel::Material::kMediumVegetation || m == voxel::Material::kHighVegetation;
        };
        crowns += found.highest(i, crown) != nullptr ? 1 : 0;
        for (const FoundRun& run : found.runs(i))
            trunks += run.material == voxel::Material::kTrunk ? run.y1 - run.y0 : 0;
    }
    readings.add("trunk voxels per column with a crown", "", trunks / crowns);
}

}  // namespace terravox::bench
