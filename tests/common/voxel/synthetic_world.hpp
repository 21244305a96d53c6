#pragma once

#include <stdexcept>
#include <string>

#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"

namespace terravox::test {

/// Hills of many materials and colours, a lake, and a tower; a function of place alone.
class SyntheticWorld final : public voxel::PyramidWorld {
public:
    explicit SyntheticWorld(const voxel::VoxelBounds& bounds,
                            std::size_t limit_bytes = std::size_t{64} << 20)
        : PyramidWorld(limit_bytes) {
        m_info.title = "synthetic";
        m_info.bounds = bounds;
        m_info.levels = voxel::levels_for(bounds);
        m_info.crs = "EPSG:3794";
        m_info.crs_wkt = "a place";
        m_info.attribution = "nobody";
    }
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    /// One past the highest solid voxel of a column.
    [[nodiscard]] static int find_top(std::int32_t x, std::int32_t z) noexcept {
        if (voxel::floor_div(x, 7) % 5 == 0 && voxel::floor_div(z, 7) % 6 == 0)
            return 290;
        const auto wave = [](std::int32_t v, int period) {
            const int at = static_cast<int>((std::int64_t{v} % period + period) % period);
            return at < period / 2 ? at : period - at;
        };
        return 20 + wave(x, 90) / 2 + wave(z, 130) / 3;
    }
    [[nodiscard]] static voxel::VoxelAttr attr_at(std::int32_t x, int y, std::int32_t z) noexcept {
        voxel::VoxelAttr attr;
        const int top = find_top(x, z);
        attr.material = top > 200     ? voxel::Material::kWall
                        : y < top - 3 ? voxel::Material::kRock
                        : y < 30      ? voxel::Material::kSand
                                      : voxel::Material::kGrass;
        if (y == top - 1 && (x + z) % 3 != 0) {
            attr.flags = voxel::VoxelAttr::kHasColour;
            attr.colour = {static_cast<std::uint8_t>(x * 5), static_cast<std::uint8_t>(y),
                           static_cast<std::uint8_t>(z * 3)};
        }
        return attr;
    }

    int fails_at_bx = 1 << 20,
        breaks_at_bx = 1 << 20;  ///< columns of boxes there: an Error; something worse
    std::atomic<int> made{0};

protected:
    [[nodiscard]] voxel::FineColumn make_column(std::int32_t bx, std::int32_t bz) override {
        ++made;
        if (bx == fails_at_bx)
            throw util::Error("make the column: not today");
        if (bx >= breaks_at_bx)
            throw std::runtime_error("the power is off");
        voxel::FineColumn out;
        out.by_begin = voxel::floor_div(m_info.bounds.min[1], voxel::kBoxSizeY);
        const auto by_end = voxel::floor_div(m_info.bounds.max[1] - 1, voxel::kBoxSizeY) + 1;
        for (std::int32_t by = out.by_begin; by < by_end; ++by)
            out.boxes.push_back(make_box({0, bx, by, bz}));
        return out;
    }

private:
    [[nodiscard]] std::shared_ptr<const voxel::Box> make_box(const voxel::BoxKey& key) const {
        voxel::BoxBuilder builder;
        const std::int32_t x0 = key.bx * voxel::kBoxSizeX;
        const std::int32_t y0 = key.by * voxel::kBoxSizeY;
        const std::int32_t z0 = key.bz * voxel::kBoxSizeZ;
        const auto& b = m_info.bounds;
        for (int x = -1; x <= voxel::kBoxSizeX; ++x)
            for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
                if (x0 + x >= b.min[0] && x0 + x < b.max[0] && z0 + z >= b.min[2] &&
                    z0 + z < b.max[2])
                    builder.add(x, z, b.min[1] - y0,
                                std::min(find_top(x0 + x, z0 + z), b.max[1]) - y0, true);
        return builder.build(key,
                             [&](int x, int y, int z) { return attr_at(x0 + x, y0 + y, z0 + z); });
    }
    voxel::WorldInfo m_info;
};

/// Whether two boxes hold the same; nullptr is air.
inline bool same_box(const std::shared_ptr<const voxel::Box>& a,
                     const std::shared_ptr<const voxel::Box>& b) {
    if (!a || !b)
        return a == b;
    return a->key() == b->key() && a->checksum() == b->checksum();
}

}  // namespace terravox::test
