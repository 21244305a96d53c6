#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/world/land.hpp"

namespace terravox::test {

// Codes of the ASPRS table, by what they do.
inline constexpr std::uint8_t kLow = 3;
inline constexpr std::uint8_t kTree = 5;
inline constexpr std::uint8_t kGroundClass = 2;
inline constexpr std::uint8_t kBuilding = 6;
inline constexpr std::uint8_t kWater = 9;
inline constexpr std::uint8_t kWire = 14;
inline constexpr std::uint8_t kBridge = 17;
inline constexpr std::uint8_t kUnsorted = 1;

inline const voxelize::ClassTable& asprs() {
    static const voxelize::ClassTable table = voxelize::load_class_table("asprs");
    return table;
}

/// One return of a column. Height in voxels, to 1/4096; east and south: where in the column, [0,
/// 1).
struct Return {
    double height = 0;
    std::uint8_t source_class = kGroundClass;
    voxel::Rgb8 colour{};
    double east = 0.5;
    double south = 0.5;
};

inline store::VoxelPoint point_at(int x, int z, const Return& r) {
    store::VoxelPoint p;
    constexpr int kOne = 1 << store::VoxelPoint::kPlanBits;
    p.x = static_cast<std::uint16_t>(std::floor((x + r.east) * kOne));
    p.z = static_cast<std::uint16_t>(std::floor((z + r.south) * kOne));
    p.y = static_cast<std::int32_t>(std::floor(r.height * (1 << store::VoxelPoint::kHeightBits)));
    p.source_class = r.source_class;
    p.colour = r.colour;
    return p;
}

/// A land made up by a function that gives the returns of each column by its absolute voxels.
/// Patches come out of column init, as those of files do.
class MadeLand final : public water::CellSource {
public:
    using Returns = std::vector<Return>;
    using ReturnsAt = std::function<void(std::int32_t x, std::int32_t z, Returns& out)>;
    using InSurvey = std::function<bool(std::int32_t x, std::int32_t z)>;

    explicit MadeLand(ReturnsAt returns_at, bool has_colour = false, int cell_voxels = 2)
        : m_returns_at(std::move(returns_at)),
          m_has_colour(has_colour),
          m_cell_voxels(cell_voxels) {}

    /// Elsewhere there is nothing. Default: everywhere.
    void limit(InSurvey in_survey) { m_in_survey = std::move(in_survey); }
    [[nodiscard]] int cell_voxels() const noexcept { return m_cell_voxels; }

    [[nodiscard]] std::shared_ptr<const voxelize::PatchColumns> columns(grid::PatchKey key) {
        auto& made = m_patches[key];
        if (!made)
            made = make(key);
        return made;
    }
    [[nodiscard]] voxelize::Window window(grid::PatchKey middle) {
        voxelize::Window out;
        out.middle = middle;
        for (int i = 0; i < 9; ++i)
            out.patches[static_cast<std::size_t>(i)] =
                columns({middle.px + i % 3 - 1, middle.pz + i / 3 - 1});
        return out;
    }
    [[nodiscard]] std::shared_ptr<const water::CellPatch> cells(std::int32_t px,
                                                                std::int32_t pz) override {
        return std::make_shared<water::CellPatch>(columns({px, pz})->cells);
    }

private:
    [[nodiscard]] std::shared_ptr<const voxelize::PatchColumns> make(grid::PatchKey key) const {
        std::vector<store::VoxelPoint> points;
        Returns returns;
        for (int z = 0; z < grid::kPatchSize; ++z)
            for (int x = 0; x < grid::kPatchSize; ++x) {
                returns.clear();
                if (m_in_survey(key.x0() + x, key.z0() + z))
                    m_returns_at(key.x0() + x, key.z0() + z, returns);
                std::sort(returns.begin(), returns.end(),
                          [](const Return& a, const Return& b) { return a.height < b.height; });
                for (const Return& r : returns)
                    points.push_back(point_at(x, z, r));
            }
        const voxelize::PatchPoints source{points, m_has_colour};
        auto out = voxelize::init_columns({&source, 1}, asprs(), m_cell_voxels);
        for (int z = 0; z < out->cells.side; ++z)
            for (int x = 0; x < out->cells.side; ++x)
                out->cells.cells[static_cast<std::size_t>(z * out->cells.side + x)].covered =
                    m_in_survey(key.x0() + x * m_cell_voxels + m_cell_voxels / 2,
                                key.z0() + z * m_cell_voxels + m_cell_voxels / 2);
        return out;
    }

    ReturnsAt m_returns_at;
    bool m_has_colour;
    int m_cell_voxels;
    InSurvey m_in_survey = [](std::int32_t, std::int32_t) { return true; };
    std::map<grid::PatchKey, std::shared_ptr<const voxelize::PatchColumns>> m_patches;
};

/// A number in [0, 1) that looks random, the same for the same place and seed.
inline double dice(std::int32_t x, std::int32_t z, std::uint32_t seed) noexcept {
    std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^
                      static_cast<std::uint32_t>(z) * 0x85EBCA77U ^ seed * 0xC2B2AE3DU;
    h ^= h >> 15;
    h *= 0x2C1B3C6DU;
    h ^= h >> 12;
    h *= 0x297A2D39U;
    h ^= h >> 15;
    return h / 4294967296.0;
}

}  // namespace terravox::test
