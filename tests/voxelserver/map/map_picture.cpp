// Writes map tiles of a place as PNG files, and prints what a box column from above, a tile and a
// PNG cost in CPU time.
#include <CLI/CLI.hpp>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "common/util/program.hpp"
#include "voxelserver/map/finest_tile.hpp"
#include "voxelserver/map/map_tiles.hpp"
#include "voxelserver/map/png.hpp"
#include "voxelserver/map/top_cache.hpp"
#include "voxelserver/voxelize/world/lidar_world.hpp"

namespace {

using namespace terravox;

/// CPU time of the process from then to now.
class Watch {
public:
    [[nodiscard]] double ms() const {
        return static_cast<double>(std::clock() - m_start) * 1000.0 / CLOCKS_PER_SEC;
    }

private:
    std::clock_t m_start = std::clock();
};

std::optional<map::ColumnBoxes> column_of(voxel::World& world, std::int32_t bx, std::int32_t bz) {
    map::ColumnBoxes out;
    const auto extent = world.column(0, bx, bz);
    for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by)
        out.boxes.push_back(world.box({0, bx, by, bz}));
    return out;
}

/// All tiles of one zoom that show something.
void write_zoom(map::MapTiles& tiles, const voxel::WorldInfo& info, int z,
                const std::filesystem::path& folder) {
    const int scale = 256 << (tiles.zooms() - 1 - z);
    const auto tile_of = [&](std::int32_t voxel) { return voxel::floor_div(voxel, scale); };
    for (std::int32_t y = tile_of(info.bounds.min[2]); y <= tile_of(info.bounds.max[2] - 1); ++y)
        for (std::int32_t x = tile_of(info.bounds.min[0]); x <= tile_of(info.bounds.max[0] - 1);
             ++x) {
            const Watch watch;
            const map::Tile tile = tiles.get(z, x, y);
            const double ms = watch.ms();
            const auto file = folder / ("map-" + std::to_string(z) + "-" + std::to_string(x) + "-" +
                                        std::to_string(y) + ".png");
            if (tile.png)
                std::ofstream(file, std::ios::binary) << *tile.png;
            const std::size_t bytes = tile.png ? tile.png->size() : 0;
            std::cout << file.string() << ": " << bytes << " bytes, "
                      << (tile.complete ? "complete, " : "incomplete, ") << ms << " ms\n";
        }
}

/// Figures of one tile whose boxes are at hand.
void measure(voxel::World& world, const map::TopColours& colours, std::int32_t tile_x,
             std::int32_t tile_z) {
    std::vector<map::ColumnBoxes> columns;
    for (int i = 0; i < 16; ++i)
        columns.push_back(*column_of(world, tile_x * 4 + i % 4, tile_z * 4 + i / 4));
    constexpr int kTimes = 50;
    const Watch tops;
    for (int n = 0; n < kTimes; ++n)
        for (const auto& column : columns)
            static_cast<void>(map::make_top(column.boxes, colours));
    std::cout << "box column from above: " << tops.ms() / kTimes / 16 << " ms\n";

    map::TopCache source([&](auto bx, auto bz, bool) { return column_of(world, bx, bz); }, colours,
                         3, std::size_t{256} << 20);
    const auto bounds = voxel::boxes_over(world.info().bounds, 0);
    const voxel::InputExtent reach{bounds.min.bx, bounds.min.bz, bounds.max.bx, bounds.max.bz};
    map::FinestTile tile = map::make_finest_tile(source, reach, tile_x, tile_z, true);
    const Watch shading;
    for (int n = 0; n < kTimes; ++n)
        tile = map::make_finest_tile(source, reach, tile_x, tile_z, true);
    std::cout << "finest tile from box columns at hand: " << shading.ms() / kTimes << " ms\n";
    if (tile.pixels.empty())
        return;
    const Watch encoding;
    for (int n = 0; n < kTimes; ++n)
        static_cast<void>(map::png_of(tile.pixels, map::kTilePx, map::kTilePx));
    std::cout << "its PNG: " << encoding.ms() / kTimes << " ms\n";
}

int run(int argc, char** argv) {
    CLI::App app{"Writes map tiles of a place as PNG files.", "map_picture"};
    voxelize::LidarWorldOptions options;
    std::filesystem::path folder = ".";
    std::vector<int> zooms_out{0, 1, 2};
    app.add_option("files", options.files, "LiDAR files or folders")->required();
    app.add_option("--orthophotos", options.orthophotos, "image files or folders");
    app.add_option("--classes", options.classes, "class table");
    app.add_option("--crs", options.crs, "coordinate system of the files");
    app.add_option("--voxel-m", options.voxel_m, "edge of a voxel, metres");
    app.add_option("--cache", options.cache_dir, "cache folder");
    app.add_option("--out", folder, "folder of the pictures")->capture_default_str();
    app.add_option("--zooms-out", zooms_out, "zooms to write, 0 = the finest")
        ->capture_default_str();
    if (const auto code = util::parse_arguments(app, argc, argv))
        return *code;

    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(options, times);
    const map::TopColours colours{
        voxel::load_palette(std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config/materials.toml")};
    map::TopCache source([&](auto bx, auto bz, bool) { return column_of(*world, bx, bz); }, colours,
                         world->info().levels, std::size_t{256} << 20);
    map::MapTiles tiles(world->info(), source, std::size_t{256} << 20);
    std::filesystem::create_directories(folder);
    for (const int out : zooms_out)
        if (out >= 0 && out < tiles.zooms())
            write_zoom(tiles, world->info(), tiles.zooms() - 1 - out, folder);
    const auto& bounds = world->info().bounds;
    const auto middle = [&](std::size_t axis) {
        return voxel::floor_div(bounds.min[axis] / 2 + bounds.max[axis] / 2, 256);
    };
    measure(*world, colours, middle(0), middle(2));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_program([&] { return run(argc, argv); });
}
