#pragma once

#include <terravox/terravox.hpp>

#include <atomic>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace terravox::test {

inline constexpr std::uint8_t kGrass = 4;
inline constexpr std::uint8_t kRoof = 9;

/// Hills of grass, and a tower of roofs that begins in the air, in a block around the origin.
class Hills final : public VoxelSource {
public:
    static constexpr std::int32_t kSide = 150;
    static constexpr std::int32_t kTowerTop = 300;

    explicit Hills(std::string crs = "") : m_crs(std::move(crs)) {}

    /// Upper face of the ground.
    static std::int32_t ground(std::int32_t x, std::int32_t z) {
        return 20 + static_cast<std::int32_t>(10 * std::sin(x / 17.0) * std::cos(z / 23.0));
    }
    static bool is_tower(std::int32_t x, std::int32_t y, std::int32_t z) {
        return x >= 5 && x < 12 && z >= -9 && z < -3 && y >= 60 && y < kTowerTop;
    }
    static std::int32_t top(std::int32_t x, std::int32_t z) {
        return is_tower(x, kTowerTop - 1, z) ? kTowerTop : ground(x, z);
    }

    [[nodiscard]] WorldInfo info() const override {
        WorldInfo out;
        out.title = "hills";
        out.block = {0, {-kSide, 0, -kSide}, {kSide, kTowerTop, kSide}};
        out.voxel_m = 0.5;
        out.crs = m_crs;
        return out;
    }

    bool fill(const std::array<std::int32_t, 3>& corner, std::span<Voxel> voxels) override {
        if (m_fails)
            throw std::runtime_error("no box today");
        ++m_boxes;
        bool any = false;
        for (std::int32_t z = 0; z < kWidth; ++z)
            for (std::int32_t x = 0; x < kWidth; ++x)
                any = fill_column(corner, x, z, voxels) || any;
        return any;
    }

    void fail(bool fails = true) noexcept { m_fails = fails; }
    [[nodiscard]] int boxes() const noexcept { return m_boxes; }

private:
    static bool fill_column(const std::array<std::int32_t, 3>& corner, std::int32_t dx,
                            std::int32_t dz, std::span<Voxel> voxels) {
        const std::int32_t x = corner[0] + dx;
        const std::int32_t z = corner[2] + dz;
        if (x < -kSide || x >= kSide || z < -kSide || z >= kSide)
            return false;
        const std::int32_t ground_y = ground(x, z);
        bool any = false;
        for (std::int32_t dy = 0; dy < kHeight; ++dy) {
            const bool tower = is_tower(x, corner[1] + dy, z);
            if (corner[1] + dy >= ground_y && !tower)
                continue;
            const auto number = static_cast<std::size_t>((dy * kWidth + dz) * kWidth + dx);
            voxels[number].material = tower ? kRoof : kGrass;
            any = true;
        }
        return any;
    }

    const std::string m_crs;
    std::atomic<bool> m_fails{false};
    std::atomic<int> m_boxes{0};
};

/// A slope of points, one on each square metre.
class SlopePoints final : public PointSource {
public:
    static constexpr int kSide = 64;

    [[nodiscard]] std::string crs() const override { return "EPSG:3794"; }
    bool next(std::vector<Point>& batch) override {
        if (m_row == kSide)
            return false;
        for (int column = 0; column < kSide; ++column) {
            Point point;
            point.x = 462000.5 + column;
            point.y = 101000.5 + m_row;
            point.z = 300.5 + column / 4;
            point.classification = 2;
            batch.push_back(point);
        }
        ++m_row;
        return true;
    }

private:
    int m_row = 0;
};

}  // namespace terravox::test
