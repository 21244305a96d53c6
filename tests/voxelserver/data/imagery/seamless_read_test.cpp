#include <numbers>
#include <random>

#include "tests/voxelserver/data/imagery/image_files.hpp"

using namespace terravox;
using namespace terravox::test;
using imagery::Orthophotos;
using imagery::Raster;

TEST_CASE("a column reads the same in whatever rectangle it is requested",
          "[voxelserver][imagery][ortho][property]") {
    struct Case {
        const char* name;
        double pixel_m;
        double voxel_m;
        double turned_deg;
        const char* crs;
        bool gaps;
    };
    const auto c = GENERATE(values<Case>({
        {"0.2 m with gaps", 0.2, 1, 0, kCrs, true},
        {"0.37 m", 0.37, 1, 0, kCrs, false},
        {"1 m off the voxels", 1, 1, 0, kCrs, false},
        {"2.5 m", 2.5, 1, 0, kCrs, true},
        {"0.5 m, voxels of 0.25 m", 0.5, 0.25, 0, kCrs, false},
        {"0.3 m, voxels of 4 m", 0.3, 4, 0, kCrs, false},
        {"turned by 17 degrees", 0.4, 1, 17, kCrs, true},
        {"turned, coarse", 2, 1, -40, kCrs, false},
        {"another system", 0.3, 1, 0, "EPSG:32631", false},
        {"another system, coarse", 1.7, 1, 0, "EPSG:3857", true},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        double x0 = kEast0 + 120;
        double y0 = kNorth0 + 120;
        geo::Transform(geo::Crs::from_text(kCrs), geo::Crs::from_text(c.crs))
            .apply({&x0, 1}, {&y0, 1});
        const double a = c.turned_deg * std::numbers::pi / 180;
        const double s = std::sin(a) * c.pixel_m;
        const double k = std::cos(a) * c.pixel_m;
        ImageFile image;
        image.width = static_cast<int>(180 / c.pixel_m);
        image.height = static_cast<int>(150 / c.pixel_m);
        image.crs = c.crs;
        image.geo = {x0 - 90 * std::cos(a) + 75 * std::sin(a) + 0.123, k,  -s,
                     y0 + 90 * std::sin(a) + 75 * std::cos(a) + 0.077, -s, -k};
        image.options = {"TILED=YES", "BLOCKXSIZE=64", "BLOCKYSIZE=64"};
        image.value = [](int x, int y, int band) { return noise(x, y, band) | 1; };
        if (c.gaps) {
            image.nodata = 0;
            image.value = [](int x, int y, int band) {
                return noise(x / 5, y / 7, 9) < 60 ? 0 : noise(x, y, band) | 1;
            };
        }
        write_image(folder.path() / "a.tif", image);
        const auto f = frame(c.voxel_m);
        const Orthophotos photos({folder.path()}, f);
        const int side = static_cast<int>(240 / c.voxel_m);
        const auto zx = voxel_x(f, 0);
        const auto zz = voxel_z(f, 240);
        const Raster whole = photos.read(zx, zz, side, side);
        REQUIRE(!whole.empty());
        int known = 0;
        for (const auto flag : whole.flags)
            known += flag != 0;
        CHECK(known > side * side / 8);
        CHECK(known < side * side);

        const auto seed = GENERATE(take(1, random(0U, 1'000'000U)));
        INFO("seed " << seed);
        std::mt19937 random_numbers(seed);
        const auto pick = [&](int least, int most) {
            return std::uniform_int_distribution<int>(least, most)(random_numbers);
        };
        for (int i = 0; i < 60; ++i) {
            const int w = i % 5 == 0 ? 1 : pick(1, 90);
            const int h = i % 7 == 0 ? 1 : pick(1, 90);
            const int x = pick(-20, side - 1);
            const int z = pick(-20, side - 1);
            const Raster part = photos.read(zx + x, zz + z, w, h);
            for (int dz = 0; dz < h; ++dz)
                for (int dx = 0; dx < w; ++dx) {
                    if (x + dx < 0 || z + dz < 0 || x + dx >= side || z + dz >= side)
                        continue;
                    if (column_text(part, dx, dz) == column_text(whole, x + dx, z + dz))
                        continue;
                    INFO("rectangle " << x << " " << z << " " << w << " x " << h << ", column "
                                      << x + dx << " " << z + dz);
                    REQUIRE(column_text(part, dx, dz) == column_text(whole, x + dx, z + dz));
                }
        }
    }
}
