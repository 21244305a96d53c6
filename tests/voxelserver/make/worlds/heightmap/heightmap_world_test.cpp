#include "voxelserver/make/worlds/heightmap/heightmap_world.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <thread>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/common/voxel/synthetic_world.hpp"
#include "tests/voxelserver/make/worlds/heightmap/heightmap_voxels.hpp"
#include "tests/voxelserver/make/worlds/heightmap/raster_files.hpp"

using namespace terravox;
using namespace terravox::heightmap;
using namespace terravox::voxel;
using terravox::test::contains;
using terravox::test::open;
using terravox::test::RasterSpec;
using terravox::test::same_box;
using terravox::test::Voxels;
using terravox::test::write_heights;

namespace {

double hilly(int x, int y) {
    return 300 + 40 * std::sin(x * 0.05) + 25 * std::cos(y * 0.08 + x * 0.01);
}

}  // namespace

TEST_CASE("a heightmap's voxels lie where the raster's cells are", "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    RasterSpec spec;
    const auto world = open({write_heights(folder.path() / "a.tif", spec, hilly)});
    CHECK(world->info().crs == "EPSG:3794");
    CHECK(world->info().centre.has_value());
    CHECK(world->info().bounds.min[0] == 460'000);
    CHECK(world->info().bounds.max[0] == 460'100);
    CHECK(world->info().bounds.min[2] == -101'080);
    CHECK(world->info().bounds.max[2] == -101'000);
    CHECK(world->info().framed.empty());
    Voxels voxels(*world);
    for (int y = 0; y < spec.height; ++y)
        for (int x = 0; x < spec.width; ++x) {
            const std::int32_t vx = 460'000 + x;
            const std::int32_t vz = -101'080 + y;
            const std::int32_t expected =
                static_cast<std::int32_t>(std::floor(static_cast<float>(hilly(x, y))));
            const auto top = voxels.top(vx, vz);
            if (!top || *top != expected)
                FAIL_CHECK("cell " << x << ", " << y << ": top " << (top ? *top : -1)
                                   << ", expected " << expected);
        }
    CHECK(!voxels.top(459'999, -101'050));
    CHECK(!voxels.top(460'100, -101'050));
    CHECK(!voxels.top(460'050, -101'081));
    CHECK(!voxels.top(460'050, -101'000));
    // Rock down to the floor, nothing below it.
    const std::int32_t floor = world->info().bounds.min[1];
    CHECK(voxels.at(460'050, floor, -101'050)->material == Material::kRock);
    CHECK(!voxels.at(460'050, floor - 1, -101'050));
    CHECK(floor <= 300 - 65 - 8);
}

TEST_CASE("equal heights on a voxel's boundary make a flat face", "[raytracer][heightmap]") {
    struct Case {
        const char* name;
        double cell;
        double voxel_m;
        double height;
        std::int32_t y;
    };
    const auto c = GENERATE(values<Case>({
        {"cells as voxels", 1, 1, 100, 100},
        {"finer voxels", 1, 0.25, 100, 400},
        {"finer voxels, not a fraction of the cell", 1, 0.3, 99, 330},
        {"coarser voxels", 1, 5, 100, 20},
        {"coarser voxels, cells that do not fit", 0.7, 2.5, 100, 40},
        {"below the sea", 10, 1, -3, -3},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::TemporaryFolder folder;
        RasterSpec spec;
        spec.geo[1] = c.cell;
        spec.geo[5] = -c.cell;
        const auto world = open(
            {write_heights(folder.path() / "flat.tif", spec, [&](int, int) { return c.height; })},
            c.voxel_m);
        Voxels voxels(*world);
        const auto& b = world->info().bounds;
        for (std::int32_t z = b.min[2] + 1; z < b.max[2] - 1; z += 3)
            for (std::int32_t x = b.min[0] + 1; x < b.max[0] - 1; x += 3)
                if (const auto top = voxels.top(x, z); !top || *top != c.y)
                    FAIL_CHECK("column " << x << ", " << z << ": top " << (top ? *top : -999999)
                                         << ", expected " << c.y);
    }
}

TEST_CASE("between cells heights are linear, and of many cells the mean",
          "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    // A plane that rises by one metre for each metre east, in cells of 4 m: between their middles
    // it stays that plane.
    RasterSpec coarse;
    coarse.geo[1] = 4;
    coarse.geo[5] = -4;
    const auto plane = open({write_heights(folder.path() / "plane.tif", coarse,
                                           [](int x, int) { return 4 * x + 2.25; })});
    Voxels fine(*plane);
    for (std::int32_t x = 2; x < 398; ++x)
        CHECK(fine.top(460'000 + x, -101'000 + 40) ==
              x);  // the plane's height at the middle: x + 0.75
    // Steps of 8 m in cells of 1 m: a voxel of 4 m over two halves is the mean.
    RasterSpec steps;
    const auto stepped = open({write_heights(folder.path() / "steps.tif", steps,
                                             [](int x, int) { return x < 50 ? 40.0 : 48.0; })},
                              4);
    Voxels means(*stepped);
    CHECK(means.top(115'000 + 11, -25'260) == 10);
    CHECK(means.top(115'000 + 12, -25'260) == 11);  // two columns of 40 m, two of 48 m
    CHECK(means.top(115'000 + 13, -25'260) == 12);
}

TEST_CASE("where a raster has no value there is nothing", "[raytracer][heightmap]") {
    struct Case {
        const char* name;
        GDALDataType type;
        std::optional<double> nodata;
        double none;
    };
    const auto c = GENERATE(values<Case>({
        {"declared", GDT_Float32, -32768, -32768},
        {"declared, the lowest float", GDT_Float32, -3.4028234663852886e38, -3.4028234663852886e38},
        {"no number", GDT_Float32, std::nullopt, std::nan("")},
        {"a height that would be possible", GDT_Int16, 0, 0},
        {"undeclared, by custom", GDT_Float32, std::nullopt, -9999},
        {"undeclared, beyond the Earth", GDT_Float64, std::nullopt, 1e20},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::TemporaryFolder folder;
        RasterSpec spec;
        spec.type = c.type;
        spec.nodata = c.nodata;
        spec.overviews = {2};
        const auto hole = [](int x, int y) { return x >= 20 && x < 60 && y >= 30 && y < 50; };
        const auto world = open({write_heights(folder.path() / "a.tif", spec, [&](int x, int y) {
            return hole(x, y) ? c.none : 200.0 + x / 10;
        })});
        CHECK(world->info().bounds.min[1] > 150);
        for (const int level : {0, 1}) {
            Voxels voxels(*world, level);
            for (int y = 0; y < spec.height >> level; ++y)
                for (int x = 0; x < spec.width >> level; ++x) {
                    const bool air = !voxels.top((460'000 >> level) + x, (-101'080 >> level) + y);
                    if (air != hole(x << level, y << level))
                        FAIL_CHECK("level " << level << ", cell " << x << ", " << y
                                            << (air ? " is air" : " is solid"));
                }
        }
    }
}

TEST_CASE("a heightmap's boxes are the same in any order and fit at their edges",
          "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    RasterSpec spec;
    spec.width = 300;
    spec.height = 260;
    spec.options = {"TILED=YES", "BLOCKXSIZE=64", "BLOCKYSIZE=64"};
    spec.overviews = GENERATE(std::vector<int>{}, std::vector<int>{2, 4, 8});
    const double voxel_m = GENERATE(0.5, 3.0);
    const auto file = write_heights(folder.path() / "a.tif", spec, hilly);
    const auto first = open({file}, voxel_m);
    const auto second = open({file}, voxel_m);
    for (int level = 0; level < first->info().levels; ++level) {
        const BoxRange range = boxes_over(first->info().bounds, level);
        std::vector<BoxKey> keys;
        for (auto by = range.min.by; by < range.max.by; ++by)
            for (auto bz = range.min.bz; bz < range.max.bz; ++bz)
                for (auto bx = range.min.bx; bx < range.max.bx; ++bx)
                    keys.push_back({level, bx, by, bz});
        std::map<BoxKey, std::shared_ptr<const Box>> boxes;
        for (const BoxKey& key : keys)
            boxes[key] = first->box(key);
        std::vector<std::thread> threads;  // and by several at once
        std::atomic<int> differing{0};
        for (std::size_t t = 0; t < 3; ++t)
            threads.emplace_back([&, t] {
                for (std::size_t i = keys.size(); i-- > 0;)
                    if (i % 3 == t && !same_box(boxes.at(keys[i]), second->box(keys[i])))
                        ++differing;
            });
        for (std::thread& thread : threads)
            thread.join();
        INFO("voxels of " << voxel_m << " m, level " << level);
        CHECK(differing == 0);
        // Hidden faces across edges: the outermost voxels of a box that stand higher than the
        // neighbour's have looks.
        Voxels voxels(*first, level);
        int compared = 0;
        for (auto bx = range.min.bx + 1; bx < range.max.bx; ++bx)
            for (auto z = range.min.bz * 64; z < range.max.bz * 64; ++z) {
                const auto west = voxels.top(bx * 64 - 1, z);
                const auto east = voxels.top(bx * 64, z);
                if (!west || !east)
                    continue;
                for (auto y = std::min(*west, *east) + 1; y <= std::max(*west, *east); ++y) {
                    const BoxKey key{level, *west > *east ? bx - 1 : bx, floor_div(y, 256),
                                     floor_div(z, 64)};
                    const auto& box = boxes.at(key);
                    const int lx = *west > *east ? 63 : 0;
                    const int ly = y - key.by * 256;
                    const int lz = z - key.bz * 64;
                    const TreeCell& root = box->cells()[static_cast<std::size_t>(ly >> 6)];
                    if (!(root.detail >> child_bit(lx >> 4, ly >> 4 & 3, lz >> 4) & 1))
                        FAIL_CHECK("a face that can be seen has no looks");
                    ++compared;
                }
            }
        if (level == 0)
            CHECK(compared > 10);
    }
}

TEST_CASE("coarse levels of a heightmap have the heights of the fine one",
          "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    RasterSpec spec;
    spec.width = 1024;
    spec.height = 1024;
    spec.overviews = GENERATE(std::vector<int>{}, std::vector<int>{2, 4, 8, 16});
    const auto world = open({write_heights(folder.path() / "a.tif", spec, hilly)});
    CHECK(world->info().levels >= 5);
    Voxels fine(*world);
    for (int level = 1; level < world->info().levels; ++level) {
        Voxels coarse(*world, level);
        const std::int32_t side = 1 << level;
        double error = 0;
        double worst = 0;
        int count = 0;
        for (int i = 0; i < 60; ++i) {
            const std::int32_t x = (460'000 >> level) + 1 + i * 7 % ((1024 >> level) - 2);
            const std::int32_t z = (-101'080 >> level) + 1 + i * 11 % ((1024 >> level) - 2);
            double mean = 0;
            int samples = 0;
            for (std::int32_t dz = 0; dz < side; ++dz)
                for (std::int32_t dx = 0; dx < side; ++dx) {
                    mean += fine.top(x * side + dx, z * side + dz).value() + 1;
                    ++samples;
                }
            const double difference = (coarse.top(x, z).value() + 1.0) * side - mean / samples;
            error += difference;
            worst = std::max(worst, std::abs(difference));
            ++count;
        }
        INFO("level " << level << ", mean difference " << error / count << ", largest " << worst);
        CHECK(worst <= 0.5 * side + 1.5);
        CHECK(std::abs(error / count) < 0.25 * side + 0.5);
    }
}

TEST_CASE("rasters that adjoin make one heightmap without a step, the finer one first",
          "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    const auto slope = [](double east, double north) {
        return 500 + 0.3 * (east - 460'000) + 0.2 * (north - 101'000);
    };
    const auto part = [&](const char* name, double x0, double y1, int width, int height,
                          double cell, double lift) {
        RasterSpec spec;
        spec.width = width;
        spec.height = height;
        spec.geo = {x0, cell, 0, y1, 0, -cell};
        return write_heights(folder.path() / name, spec, [&](int x, int y) {
            return slope(x0 + (x + 0.5) * cell, y1 - (y + 0.5) * cell) + lift;
        });
    };
    const auto west = part("west.tif", 460'000, 101'080, 50, 40, 2, 0);
    const auto east = part("east.tif", 460'100, 101'080, 50, 40, 2, 0);
    const auto both = open({west, east});
    const auto turned = open({east, west});
    CHECK(both->info().bounds.max[0] == 460'200);
    CHECK(both->info().bounds == turned->info().bounds);
    Voxels a(*both), b(*turned);
    for (std::int32_t x = 460'001; x < 460'199; ++x)
        for (const std::int32_t z : {-101'079, -101'040, -101'002}) {
            const auto expected =
                static_cast<std::int32_t>(std::floor(slope(x + 0.5, -z - 0.5) + 1e-4));
            if (a.top(x, z) != expected)
                FAIL_CHECK("column " << x << ", " << z << ": top " << a.top(x, z).value_or(-1)
                                     << ", expected " << expected);
            if (a.top(x, z) != b.top(x, z))
                FAIL_CHECK("column " << x << ", " << z << " depends on the order of the rasters");
        }
    // A finer one in the middle, 30 m higher, counts where it is.
    const auto fine = part("fine.tif", 460'060, 101'060, 40, 40, 1, 30);
    const auto three = open({west, fine, east});
    Voxels c(*three);
    CHECK(c.top(460'080, -101'040) ==
          static_cast<std::int32_t>(std::floor(slope(460'080.5, 101'039.5) + 30)));
    CHECK(c.top(460'040, -101'040) == a.top(460'040, -101'040));
}

TEST_CASE("units of heights, scales and the floor are as the options say",
          "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    RasterSpec feet;
    feet.unit = "ft";
    const auto plain =
        write_heights(folder.path() / "plain.tif", {}, [](int, int) { return 1000.0; });
    const auto in_feet =
        open({write_heights(folder.path() / "ft.tif", feet, [](int, int) { return 1000.0; })});
    CHECK(Voxels(*in_feet).top(460'050, -101'050) == 304);
    HeightmapOptions options;
    options.rasters = {plain};
    options.height_unit_m = 0.5;
    options.base_m = 100;
    const auto world = open_heightmap_world(options);
    Voxels voxels(*world);
    CHECK(voxels.top(460'050, -101'050) == 500);
    CHECK(voxels.at(460'050, 100, -101'050));
    CHECK(!voxels.at(460'050, 99, -101'050));
    options.base_m = 900;  // above the ground: a sheet
    const auto sheet = open_heightmap_world(options);
    Voxels thin(*sheet);
    CHECK(thin.top(460'050, -101'050) == 500);
    CHECK(!thin.at(460'050, 490, -101'050));
}

TEST_CASE("steep ground is rock, an orthophoto's colours lie on their columns",
          "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    RasterSpec spec;
    const auto raster = write_heights(folder.path() / "a.tif", spec, [](int x, int) {
        return x < 50 ? 100.0 : 100.0 + 2 * (x - 50);
    });
    RasterSpec image;
    image.width = 200;
    image.height = 160;
    image.geo[1] = 0.5;
    image.geo[5] = -0.5;
    image.type = GDT_Byte;
    image.bands = 3;
    // Green in the west half, red in the east one, a blue column of 1 m at x = 10.
    image.value = [](int x, int, int band) {
        if (x / 2 == 10)
            return band == 2 ? 200 : 10;
        return x < 100 ? (band == 1 ? 180 : 40) : (band == 0 ? 190 : 30);
    };
    const auto photo = folder.path() / "photo.tif";
    write_image(photo, image);
    const auto bare = open({raster});
    Voxels plain(*bare);
    CHECK(plain.at(460'020, 100, -101'040)->material == Material::kGrass);
    CHECK(!plain.at(460'020, 100, -101'040)->has_colour());
    CHECK(plain.at(460'070, plain.top(460'070, -101'040).value(), -101'040)->material ==
          Material::kRock);
    CHECK(plain.at(460'000, 98, -101'040)->material == Material::kSoil);  // at the cut
    HeightmapOptions options;
    options.rasters = {raster};
    options.orthophotos = {photo};
    const auto world = open_heightmap_world(options);
    Voxels voxels(*world);
    CHECK(voxels.at(460'020, 100, -101'040)->colour == Rgb8{40, 180, 40});
    CHECK(voxels.at(460'020, 100, -101'040)->material == Material::kGrass);
    CHECK(voxels.at(460'010, 100, -101'040)->colour == Rgb8{10, 10, 200});
    CHECK(voxels.at(460'009, 100, -101'040)->colour == Rgb8{40, 180, 40});
    CHECK(voxels.at(460'011, 100, -101'040)->colour == Rgb8{40, 180, 40});
    CHECK(voxels.at(460'070, voxels.top(460'070, -101'040).value(), -101'040)->colour ==
          Rgb8{190, 30, 30});
    Voxels coarse(*world, 1);
    CHECK(coarse.at(230'002, coarse.top(230'002, -50'520).value(), -50'520)->colour ==
          Rgb8{40, 180, 40});
    CHECK(coarse.at(230'040, coarse.top(230'040, -50'520).value(), -50'520)->colour ==
          Rgb8{190, 30, 30});
}
