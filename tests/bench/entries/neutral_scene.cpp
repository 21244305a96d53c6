#include "tests/bench/entries/neutral_scene.hpp"

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox::bench {
namespace {

using voxel::Box;
using voxel::BoxKey;
using voxel::Material;

constexpr std::int32_t kSideBoxes = NeutralScene::kSide / voxel::kBoxSizeX;
static_assert(voxel::kBoxSizeX == voxel::kBoxSizeZ && NeutralScene::kSide % voxel::kBoxSizeX == 0);
static_assert(NeutralScene::kHeight == voxel::kBoxSizeY, "one box on each column of boxes");

Material to_material(std::uint8_t code) noexcept {
    switch (code) {
        case 5: return Material::kHighVegetation;
        case 6: return Material::kRoof;
        case 9: return Material::kWater;
        default: return Material::kGround;
    }
}

/// The first voxel from y on that is another than the one at y.
int run_end(const std::uint8_t* column, int y) noexcept {
    static_assert(std::endian::native == std::endian::little);
    const std::uint64_t same = column[y] * std::uint64_t{0x0101010101010101};
    for (; y + 8 <= NeutralScene::kHeight; y += 8) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, column + y, sizeof eight);
        if (eight != same)
            return y + (std::countr_zero(eight ^ same) >> 3);
    }
    while (y < NeutralScene::kHeight && column[y] == static_cast<std::uint8_t>(same))
        ++y;
    return y;
}

std::shared_ptr<const Box> build_box(const NeutralScene& scene, const BoxKey& key) {
    const int x0 = key.bx * voxel::kBoxSizeX;
    const int z0 = key.bz * voxel::kBoxSizeZ;
    voxel::BoxBuilder builder;
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
            const std::uint8_t* column = scene.column(x0 + x, z0 + z);
            for (int y = 0, end = 0; column != nullptr && y < NeutralScene::kHeight; y = end) {
                end = run_end(column, y);
                if (column[y] != 0)
                    builder.add(x, z, y, end, !see_through(to_material(column[y])));
            }
        }
    return builder.build(key, [&](int x, int y, int z) {
        voxel::VoxelAttr attr;
        attr.source_class = scene.column(x0 + x, z0 + z)[y];
        attr.material = to_material(attr.source_class);
        return attr;
    });
}

std::filesystem::path make_script(const Context& c) {
    return c.data.parent_path() / "bench" / "voxel_scene.py";
}

/// The first Python that has NumPy; empty without one. A Python of one's own in PATH often lacks
/// what the system's has.
std::string python_with_numpy(const Context& c) {
    for (const char* python : {"python3", "/usr/bin/python3"})
        if (c.children.run({python, "-c", "import numpy"}, c.scratch / "numpy.txt").exit_code == 0)
            return python;
    return {};
}

}  // namespace

std::string NeutralScene::missing(const Context& c) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(make_script(c), ignored))
        return "no " + make_script(c).string() + " beside the data (--data)";
    return python_with_numpy(c).empty() ? "no Python with NumPy (Debian package python3-numpy)"
                                        : "";
}

NeutralScene::NeutralScene(const Context& c) : m_voxels(std::size_t{kSide} * kSide * kHeight) {
    const auto raw = c.scratch / "neutral.raw";
    const auto said = c.scratch / "neutral.txt";
    if (!std::filesystem::exists(raw)) {
        const auto outcome =
            c.children.run({python_with_numpy(c), make_script(c).string(), std::to_string(kSide),
                            std::to_string(kSeed), raw.string()},
                           said);
        if (outcome.exit_code != 0)
            throw util::Error("make the neutral scene: exit code " +
                              std::to_string(outcome.exit_code) + ": " + last_line(said));
    }
    std::ifstream file(raw, std::ios::binary);
    if (!file.read(reinterpret_cast<char*>(m_voxels.data()),
                   static_cast<std::streamsize>(m_voxels.size())) ||
        file.peek() != std::ifstream::traits_type::eof())
        throw util::Error("read the neutral scene " + raw.string() + ": not " +
                          std::to_string(m_voxels.size()) + " bytes");
}

NeutralWorld::NeutralWorld(const NeutralScene& scene, int threads)
    : m_boxes(std::size_t{kSideBoxes} * kSideBoxes) {
    m_info.title = "neutral scene";
    m_info.bounds = NeutralScene::bounds();
    thread::parallel_for(m_boxes.size(), threads, [&](std::size_t i) {
        const auto at = static_cast<std::int32_t>(i);
        m_boxes[i] = build_box(scene, {0, at / kSideBoxes, 0, at % kSideBoxes});
    });
}

std::size_t NeutralWorld::index(std::int32_t bx, std::int32_t bz) noexcept {
    const bool inside = bx >= 0 && bx < kSideBoxes && bz >= 0 && bz < kSideBoxes;
    return inside ? static_cast<std::size_t>(bx * kSideBoxes + bz)
                  : std::size_t{kSideBoxes} * kSideBoxes;
}

std::shared_ptr<const Box> NeutralWorld::box(const BoxKey& key) {
    const std::size_t i = index(key.bx, key.bz);
    return key.level == 0 && key.by == 0 && i < m_boxes.size() ? m_boxes[i] : nullptr;
}

voxel::ColumnExtent NeutralWorld::column(int level, std::int32_t bx, std::int32_t bz) {
    return box({level, bx, 0, bz}) ? voxel::ColumnExtent{0, 1} : voxel::ColumnExtent{};
}

std::size_t NeutralWorld::memory_bytes() const noexcept {
    std::size_t out = 0;
    for (const auto& box : m_boxes)
        out += box ? box->memory_bytes() : 0;
    return out;
}

std::array<NeutralView, 3> neutral_views() noexcept {
    constexpr double kN = NeutralScene::kSide;
    return {NeutralView{"bird", {kN * 0.5, 500, -200}, {kN * 0.5, 60, kN * 0.45}, 40},
            NeutralView{"oblique", {kN * 0.1, 220, kN * 0.1}, {kN * 0.6, 60, kN * 0.6}, 60},
            NeutralView{"ground", {kN * 0.5, 190, kN * 0.5}, {kN * 0.9, 150, kN * 0.8}, 70}};
}

core::Vec3 neutral_sun() noexcept {
    return core::normalized({0.5, 0.7, 0.3});
}

}  // namespace terravox::bench
