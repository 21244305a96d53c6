#pragma once

#include <random>
#include <set>
#include <string>

#include "common/voxel/material.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/common/voxel/array_world.hpp"
#include "voxelserver/out/export/core/job.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::test {

/// An array whose voxels have colours of their own, one of `colours` each; every fifth has none.
class PaintedWorld : public ArrayWorld {
public:
    PaintedWorld(const Coord& min, const Coord& max, std::uint32_t colours)
        : ArrayWorld(min, max), m_colours(colours) {}

    [[nodiscard]] voxel::VoxelAttr attr_at(std::int32_t x, std::int32_t y,
                                           std::int32_t z) const noexcept {
        voxel::VoxelAttr out;
        out.material = at(x, y, z);
        if (hidden(x, y, z))
            return {};
        const auto mixed = [](std::int32_t v, std::uint32_t by) {
            return static_cast<std::uint32_t>(v) * by;
        };
        const std::uint32_t n =
            (mixed(x, 73856093u) ^ mixed(y, 19349663u) ^ mixed(z, 83492791u)) >> 4;
        if (m_colours == 0 || n % 5 == 0)
            return out;
        const std::uint32_t c = (n / 5 % m_colours) * 2654435761u;
        out.colour = {static_cast<std::uint8_t>(c >> 24), static_cast<std::uint8_t>(c >> 16),
                      static_cast<std::uint8_t>(c >> 8)};
        out.flags = voxel::VoxelAttr::kHasColour;
        return out;
    }

    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        const auto plain = ArrayWorld::box(key);
        if (!plain)
            return nullptr;
        std::vector<voxel::VoxelAttr> attrs(plain->attrs().begin(), plain->attrs().end());
        exports::each_voxel(
            *plain,
            [&](int x, int y, int z, const voxel::VoxelAttr& attr) {
                attrs[static_cast<std::size_t>(&attr - plain->attrs().data())] =
                    attr_at(key.bx * voxel::kBoxSizeX + x, key.by * voxel::kBoxSizeY + y,
                            key.bz * voxel::kBoxSizeZ + z);
            },
            [](int, int, int, int) {});
        return voxel::Box::from_arrays(key, plain->cells(), attrs);
    }

private:
    std::uint32_t m_colours;
};

/// Lumps of solid and of see-through materials over edges of boxes in all directions, below zero,
/// too.
inline std::unique_ptr<PaintedWorld> lumps(unsigned seed, std::uint32_t colours,
                                           bool see_through = true) {
    using voxel::Material;
    auto world = std::make_unique<PaintedWorld>(ArrayWorld::Coord{-70, -12, -9},
                                                ArrayWorld::Coord{75, 300, 80}, colours);
    std::mt19937 random(seed);
    const auto pick = [&](int from, int to) {
        return from + static_cast<int>(random() % static_cast<unsigned>(to - from));
    };
    const std::vector<Material> solid = {Material::kRock, Material::kGrass, Material::kWall,
                                         Material::kLamp};
    const std::vector<Material> clear = {Material::kWater, Material::kGlass,
                                         Material::kHighVegetation, Material::kAir};
    world->fill({-70, -12, -9}, {75, pick(-5, 3), 80}, Material::kRock);
    for (int i = 0; i < 60; ++i) {
        const ArrayWorld::Coord low = {pick(-70, 70), i % 3 == 0 ? pick(235, 290) : pick(-12, 70),
                                       pick(-9, 75)};
        const auto& from = see_through && i % 2 == 0 ? clear : solid;
        const ArrayWorld::Coord high = {low[0] + pick(1, 20), low[1] + pick(1, 30),
                                        low[2] + pick(1, 20)};
        world->fill(low, high,
                    from[static_cast<std::size_t>(pick(0, static_cast<int>(from.size())))]);
    }
    for (int i = 0; i < 400; ++i)
        world->set(pick(-70, 75), pick(-12, 300), pick(-9, 80),
                   solid[static_cast<std::size_t>(i) % solid.size()]);
    auto& info = world->editable_info();
    info.title = "lumps";
    info.crs = "EPSG:3794";
    info.attribution = "nobody";
    info.voxel_m = 0.5;
    info.crs_units_per_voxel = 0.5;
    return world;
}

/// A job with all it refers to.
struct ExportJob {
    TemporaryFolder folder;
    voxel::Palette palette =
        voxel::load_palette(std::string(TERRAVOX_SOURCE_DIR) + "/config/materials.toml");
    exports::Meter meter{"exporting", 1, true};
    exports::Job job;
    ExportJob(voxel::World& world, const voxel::VoxelBounds& bounds, const std::string& name,
              int level = 0)
        : job(world, {level, bounds}, folder.path() / name, palette, meter) {}
    ExportJob(voxel::World& world, const std::string& name)
        : ExportJob(world, world.info().bounds, name) {}
};

/// Names of the files in a folder, hidden ones too.
inline std::set<std::string> files_in(const std::filesystem::path& folder) {
    std::set<std::string> out;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        out.insert(entry.path().filename().string());
    return out;
}

}  // namespace terravox::test
