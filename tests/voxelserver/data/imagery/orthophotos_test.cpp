#include "voxelserver/data/imagery/orthophotos.hpp"

#include <thread>

#include "tests/voxelserver/data/imagery/image_files.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"

using namespace terravox;
using namespace terravox::test;
using imagery::Orthophotos;
using imagery::Raster;

namespace {

/// A grey image of one value, `pixel_m` a pixel, over the first 60 m.
ImageFile plain(double pixel_m, int value, const std::string& date = {}) {
    ImageFile image;
    image.width = image.height = static_cast<int>(60 / pixel_m);
    image.geo = {kEast0, pixel_m, 0, kNorth0 + 60, 0, -pixel_m};
    image.date = date;
    image.value = [value](int, int, int) { return value; };
    return image;
}

/// States in a file that values mean value * scale + offset.
void set_scale(const std::filesystem::path& file, double scale, double offset) {
    const GDALDatasetUniquePtr data(GDALDataset::Open(file.c_str(), GDAL_OF_UPDATE));
    REQUIRE(data);
    for (int b = 1; b <= data->GetRasterCount(); ++b) {
        REQUIRE(data->GetRasterBand(b)->SetScale(scale) == CE_None);
        REQUIRE(data->GetRasterBand(b)->SetOffset(offset) == CE_None);
    }
}

std::string at(const Orthophotos& photos, double east, double north) {
    const auto f = frame();
    return column_text(photos.read(voxel_x(f, east), voxel_z(f, north), 1, 1), 0, 0);
}

}  // namespace

TEST_CASE("a column has the mean of a finer image's pixels, weighed by their area",
          "[voxelserver][imagery][ortho]") {
    const double pixel_m = GENERATE(0.1, 0.2, 0.25, 0.5, 1.0);
    INFO(pixel_m << " m a pixel");
    const TemporaryFolder folder;
    ImageFile image;
    image.width = image.height = static_cast<int>(std::lround(20 / pixel_m));
    image.geo = {kEast0, pixel_m, 0, kNorth0 + 20, 0, -pixel_m};
    image.value = noise;
    write_image(folder.path() / "a.tif", image);
    const auto f = frame();
    const Raster raster =
        Orthophotos({folder.path()}, f).read(voxel_x(f, 0), voxel_z(f, 20), 20, 20);
    const int n = static_cast<int>(std::lround(1 / pixel_m));
    int wrong = 0;
    for (int z = 0; z < 20; ++z)
        for (int x = 0; x < 20; ++x) {
            std::array<int, 3> sum{};
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i)
                    for (int b = 0; b < 3; ++b)
                        sum[static_cast<std::size_t>(b)] += noise(x * n + i, z * n + j, b);
            const auto mean = [&](int b) {
                return std::to_string((sum[static_cast<std::size_t>(b)] + n * n / 2) / (n * n));
            };
            if (column_text(raster, x, z) != mean(0) + "," + mean(1) + "," + mean(2) + " -")
                ++wrong;
        }
    CHECK(wrong == 0);
}

TEST_CASE("a coarser image is bilinear between its pixels' centres",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    ImageFile image;
    image.width = 3;
    image.height = 2;
    image.geo = {kEast0, 10, 0, kNorth0 + 20, 0, -10};
    image.value = [](int x, int, int) { return 100 * x; };
    write_image(folder.path() / "a.tif", image);
    const Orthophotos photos({folder.path()}, frame());
    CHECK(at(photos, 0.5, 10) == "0,0,0 -");      // left of the first centre: the edge's value
    CHECK(at(photos, 10.5, 10) == "55,55,55 -");  // centres at 5, 15, 25 m
    CHECK(at(photos, 15.5, 10) == "105,105,105 -");
    CHECK(at(photos, 29.5, 10) == "200,200,200 -");
    CHECK(at(photos, 30.5, 10) == "- -");
}

TEST_CASE(
    "where images overlap the finer wins, then the newer, then the name; the order of naming says "
    "nothing",
    "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    const auto path = [&](const char* name) { return folder.path() / name; };
    SECTION("finer first") {
        write_image(path("a.tif"), plain(1, 10, "2024:01:01 00:00:00"));
        write_image(path("b.tif"), plain(0.5, 20, "2001:01:01 00:00:00"));
        CHECK(at(Orthophotos({path("a.tif"), path("b.tif")}, frame()), 5, 5) == "20,20,20 -");
        CHECK(at(Orthophotos({path("b.tif"), path("a.tif")}, frame()), 5, 5) == "20,20,20 -");
    }
    SECTION("then newer; no date or a bad one is oldest") {
        write_image(path("a.tif"), plain(1, 10));
        write_image(path("b.tif"), plain(1, 20, "2019:06:01 12:00:00"));
        write_image(path("c.tif"), plain(1, 30, "2021:06:01 12:00:00"));
        write_image(path("d.tif"), plain(1, 40, "some day of 2030  !"));
        CHECK(at(Orthophotos({path("a.tif"), path("b.tif"), path("c.tif"), path("d.tif")}, frame()),
                 5, 5) == "30,30,30 -");
        CHECK(at(Orthophotos({path("d.tif"), path("c.tif"), path("b.tif"), path("a.tif")}, frame()),
                 5, 5) == "30,30,30 -");
        const auto order = Orthophotos({folder.path()}, frame()).order();
        REQUIRE(order.size() == 4);
        CHECK((order[0].filename() == "c.tif" && order[1].filename() == "b.tif" &&
               order[2].filename() == "a.tif" && order[3].filename() == "d.tif"));
    }
    SECTION("then the name, even from other folders") {
        std::filesystem::create_directories(path("x"));
        std::filesystem::create_directories(path("y"));
        write_image(folder.path() / "y" / "a.tif", plain(1, 10));
        write_image(folder.path() / "x" / "b.tif", plain(1, 20));
        CHECK(at(Orthophotos({path("x"), path("y")}, frame()), 5, 5) == "10,10,10 -");
    }
    SECTION("the finer image's gaps are filled by the coarser") {
        auto fine = plain(0.5, 20);
        fine.nodata = 0;
        fine.value = [](int x, int, int) {
            return x < 60 ? 0 : 20;
        };  // the western 30 m have no data
        write_image(path("a.tif"), fine);
        write_image(path("b.tif"), plain(2, 10));
        const Orthophotos photos({folder.path()}, frame());
        CHECK(at(photos, 10, 30) == "10,10,10 -");
        CHECK(at(photos, 50, 30) == "20,20,20 -");
        CHECK(at(photos, 61, 30) == "- -");
    }
}

TEST_CASE("tiles of a mosaic meet without a gap, whatever their edges",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    for (int i = 0; i < 3; ++i) {
        ImageFile image;
        image.width = 67;
        image.height = 300;
        image.geo = {kEast0 + 0.37 + i * 67 * 0.2, 0.2, 0, kNorth0 + 50, 0, -0.2};
        image.value = [i](int x, int, int) {
            return i * 67 + x;
        };  // brighter to the east, by 5 a metre
        write_image(folder.path() / (std::to_string(i) + ".tif"), image);
    }
    const auto f = frame();
    const Raster raster =
        Orthophotos({folder.path()}, f).read(voxel_x(f, 0), voxel_z(f, 40), 42, 20);
    for (int x = 1; x < 40; ++x) {
        const double expected = (x + 0.5 - 0.37) * 5 - 0.5;
        INFO("column " << x << ": " << column_text(raster, x, 7) << ", expected about "
                       << expected);
        REQUIRE(raster.flags[static_cast<std::size_t>(7 * 42 + x)] == Raster::kColour);
        CHECK(std::abs(raster.colour[static_cast<std::size_t>(7 * 42 + x)].r - expected) <= 2.5);
    }
}

TEST_CASE("a nodata value counts only where all colours have it", "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    ImageFile image;
    image.nodata = 0;
    image.value = [](int x, int, int band) {
        return x < 50 ? 0 : band == 0 ? 0 : 90;
    };  // the east is cyan: its red is 0
    SECTION("8 bits") {}
    SECTION("16 bits") {
        image.type = GDT_UInt16;
        image.value = [](int x, int, int band) { return x < 50 || band == 0 ? 0 : 90 * 256; };
    }
    write_image(folder.path() / "a.tif", image);
    const Orthophotos photos({folder.path()}, frame());
    CHECK(at(photos, 10, 50) == "- -");
    CHECK(at(photos, 80, 50) == "0,90,90 -");
}

TEST_CASE("an image of 12 bits in 16 uses its whole range", "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    ImageFile image;
    image.type = GDT_UInt16;
    image.options = {"NBITS=12"};
    image.value = [](int, int, int band) { return 4095 - band * 1000; };
    write_image(folder.path() / "a.tif", image);
    CHECK(at(Orthophotos({folder.path()}, frame()), 10, 50) == "255,193,130 -");
}

TEST_CASE("bits that a file states count where its scale says nothing of white",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    ImageFile image;
    image.type = GDT_UInt16;
    image.options = {"NBITS=12"};
    image.value = [](int, int, int band) { return 1000 - band * 200; };
    write_image(folder.path() / "a.tif", image);
    const double scale = GENERATE(1.0, 0.01);  // to radiance, say
    set_scale(folder.path() / "a.tif", scale, 0);
    const Warnings warnings;
    const Orthophotos photos({folder.path()}, frame());
    CHECK(at(photos, 10, 50) == "62,50,37 -");
    CHECK(warnings.text().empty());
}

TEST_CASE("a remedy names values as the file stores them", "[voxelserver][imagery][ortho]") {
    struct Case {
        const char* name;
        double scale;
        double offset;
        double value;
        const char* remedy;
    };
    const auto c = GENERATE(values<Case>({
        {"without a scale", 1, 0, 3000, "-scale 0 WHITE 0 255 a.tif NEW.tif\n"},
        {"parts of 1", 1e-4, -0.1, 18'500,
         "-scale 1000 WHITE 0 255 a.tif NEW.tif, where WHITE is as the file stores it: 11000 for "
         "1\n"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        ImageFile image;
        image.type = GDT_UInt16;
        image.value = [&](int, int, int) { return c.value; };
        write_image(folder.path() / "a.tif", image);
        set_scale(folder.path() / "a.tif", c.scale, c.offset);
        const Warnings warnings;
        const Orthophotos photos({folder.path()}, frame());
        CHECK_THAT(warnings.text(), contains(c.remedy));
    }
}

TEST_CASE("one scale for all images whose values are of one sort",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    const auto write = [&](const char* name, double east, GDALDataType type, double value) {
        ImageFile image;
        image.width = image.height = 20;
        image.type = type;
        image.geo = {kEast0 + east, 1, 0, kNorth0 + 20, 0, -1};
        image.value = [=](int, int, int) { return value; };
        write_image(folder.path() / name, image);
    };
    write("dark.tif", 0, GDT_UInt16, 200);  // alone it would be taken for 8 bits
    write("light.tif", 20, GDT_Int16, 3200);
    write("parts.tif", 40, GDT_Float32, 0.5);
    write("bytes.tif", 60, GDT_Byte, 17);
    const Warnings warnings;
    const Orthophotos photos({folder.path()}, frame());
    CHECK(warnings.count("light.tif and 1 more: values from 0 to 3200 are taken for 12 bits: 4095 "
                         "is white") == 1);
    CHECK(warnings.count("") == 1);
    CHECK(at(photos, 10, 10) == "12,12,12 -");
    CHECK(at(photos, 30, 10) == "200,200,200 -");
    CHECK(at(photos, 50, 10) == "128,128,128 -");
    CHECK(at(photos, 70, 10) == "17,17,17 -");
    // Another frame of the same images, with less to read: the same values.
    const Orthophotos coarse({folder.path()}, frame(4), {}, &photos);
    const auto f = frame(4);
    CHECK(column_text(coarse.read(voxel_x(f, 10), voxel_z(f, 10), 1, 1), 0, 0) == "12,12,12 -");
    // Boxes of the dark image alone are others.
    const auto identity = [](const Orthophotos& of) { return of.inputs().at(0).identity; };
    const Orthophotos alone({folder.path() / "dark.tif"}, frame());
    const auto order = photos.order();
    const auto dark = std::find(order.begin(), order.end(), folder.path() / "dark.tif");
    CHECK(identity(alone) !=
          photos.inputs().at(static_cast<std::size_t>(dark - order.begin())).identity);
    CHECK(at(alone, 10, 10) == "200,200,200 -");
}

TEST_CASE("a scale of the bands counts for all images that state it, or for none",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    const auto write = [&](const char* name, double east, double value) {
        ImageFile image;
        image.width = image.height = 20;
        image.type = GDT_UInt16;
        image.scale = 0.0001;
        image.geo = {kEast0 + east, 1, 0, kNorth0 + 20, 0, -1};
        image.value = [=](int, int, int) { return value; };
        write_image(folder.path() / name, image);
    };
    write("dark.tif", 0, 2000);
    write("light.tif", 20, 10'000);
    SECTION("reflectance") {
        const Orthophotos photos({folder.path()}, frame());
        CHECK(at(photos, 10, 10) == "51,51,51 -");
        CHECK(at(photos, 30, 10) == "255,255,255 -");
    }
    SECTION("radiance, by one image alone") {
        write("lighter.tif", 40, 32'000);
        const Orthophotos photos({folder.path()}, frame());
        CHECK(at(photos, 10, 10) == "7,7,7 -");
        CHECK(at(photos, 30, 10) == "39,39,39 -");
        CHECK(at(photos, 50, 10) == "125,125,125 -");
    }
}

TEST_CASE("another frame has the images that the first has, as they were",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    ImageFile image = plain(1, 2000);
    image.type = GDT_UInt16;
    write_image(folder.path() / "a.tif", image);
    const Orthophotos photos({folder.path()}, frame());
    SECTION("one more") {
        image.value = [](int, int, int) { return 60'000; };
        write_image(folder.path() / "b.tif", image);
        CHECK(Orthophotos({folder.path()}, frame(4), {}, &photos).order() == photos.order());
    }
    SECTION("another in its place") {
        image.bands = 1;
        write_image(folder.path() / "a.tif", image);
        CHECK_THROWS_AS(Orthophotos({folder.path()}, frame(4), {}, &photos), voxel::ChangedError);
    }
}

TEST_CASE("a scale that is no scale is refused", "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    ImageFile image = plain(1, 2000);
    image.type = GDT_UInt16;
    image.scale = 0;
    write_image(folder.path() / "a.tif", image);
    CHECK_THROWS_WITH(Orthophotos({folder.path()}, frame()),
                      contains("a.tif") && contains("scale and offset of its values = 0.0"));
}

TEST_CASE("an image of which all that was read is black says so", "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    write_image(folder.path() / "a.tif", plain(1, 0));
    write_image(folder.path() / "b.tif", plain(2, 90));
    const Warnings warnings;
    {
        const Orthophotos photos({folder.path()}, frame());
        (void)at(photos, 10, 10);
    }
    CHECK_THAT(warnings.text(), contains("a.tif: all of it that was read is black"));
}

TEST_CASE("an image is black only if it is so at every size of voxels",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    auto half = plain(1, 0);
    half.value = [](int x, int, int) { return x < 30 ? 0 : 90; };
    write_image(folder.path() / "a.tif", half);
    struct Case {
        const char* name;
        double fine_east;    ///< where the finer ones are read; 0: nowhere
        double coarse_east;  ///< where the coarser ones are
        int warnings;
    };
    const auto c = GENERATE(values<Case>({
        {"read coarse alone", 0, 10, 1},
        {"black in both", 10, 10, 1},
        {"light in the coarse ones", 10, 50, 0},
        {"light in the fine ones", 50, 10, 0},
        {"not read at all", 0, 0, 0},
    }));
    DYNAMIC_SECTION(c.name) {
        const Warnings warnings;
        {
            const Orthophotos fine({folder.path()}, frame());
            const Orthophotos coarse({folder.path()}, frame(4), {}, &fine);
            const auto f = frame(4);
            if (c.fine_east > 0)
                (void)at(fine, c.fine_east, 10);
            if (c.coarse_east > 0)
                (void)coarse.read(voxel_x(f, c.coarse_east), voxel_z(f, 10), 1, 1);
        }
        CHECK(warnings.count("a.tif: all of it that was read is black") == c.warnings);
    }
}

TEST_CASE("of an image that is far too fine an overview is read", "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    auto image = plain(0.05, 100);
    image.value = [](int x, int, int) { return x / 6; };
    write_image(folder.path() / "a.tif", image);
    {
        GDALDatasetUniquePtr data(
            GDALDataset::Open((folder.path() / "a.tif").string().c_str(), GDAL_OF_UPDATE));
        std::array<int, 2> factors{2, 4};
        REQUIRE(data->BuildOverviews("AVERAGE", 2, factors.data(), 0, nullptr, nullptr, nullptr) ==
                CE_None);
        // Marked: so that the test sees which was read.
        std::vector<std::uint8_t> marked(300 * 300, 7);
        REQUIRE(data->GetRasterBand(3)->GetOverview(1)->RasterIO(GF_Write, 0, 0, 300, 300,
                                                                 marked.data(), 300, 300, GDT_Byte,
                                                                 0, 0, nullptr) == CE_None);
    }
    const Orthophotos photos({folder.path()}, frame());
    CHECK(at(photos, 30.5, 30) == "101,101,7 -");  // pixels 610 .. 629, a sixth each
}

TEST_CASE("a rectangle without images gives an empty raster, a far one too",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    write_image(folder.path() / "a.tif", plain(1, 10));
    const Orthophotos photos({folder.path()}, frame());
    CHECK(photos.read(0, 0, 64, 64).empty());
    CHECK(photos.read(-2'000'000'000, 2'000'000'000, 68, 68).empty());
    CHECK(photos.count() == 1);
    CHECK_THROWS_WITH(photos.read(0, 0, 0, 64),
                      contains("0 x 64 columns; allowed: 1 to 65536 each"));
}

TEST_CASE("an image in degrees, in another zone, upside down or turned lands in its place",
          "[voxelserver][imagery][ortho]") {
    const std::string crs =
        GENERATE("EPSG:4326", "EPSG:32631", "EPSG:3857", "EPSG:2154 south up", "EPSG:2154 turned");
    INFO(crs);
    const TemporaryFolder folder;
    const bool same = crs.starts_with(kCrs);
    const double turned = crs == "EPSG:2154 turned" ? 0.5 : 0;
    const auto own = geo::Crs::from_text(same ? kCrs : crs);
    const geo::Transform there(geo::Crs::from_text(kCrs), own),
        back(own, geo::Crs::from_text(kCrs));
    double x0 = kEast0 + 50;
    double y0 = kNorth0 + 50;
    there.apply({&x0, 1}, {&y0, 1});
    const double step = own.geographic() ? 4e-6 : 0.4;
    ImageFile image;
    image.width = image.height = 400;
    image.crs = same ? kCrs : crs;
    const double s = step * std::sin(turned);
    const double down = crs == "EPSG:2154 south up" ? step : -step * std::cos(turned);
    const double across = step * std::cos(turned);
    image.geo = {x0 - 200 * (across - s), across, -s, y0 - 200 * (down - s), -s, down};
    image.value = [&](int x, int y, int band) {  // brightness = metres east, north
        double e = image.geo[0] + (x + 0.5) * across - (y + 0.5) * s;
        double n = image.geo[3] - (x + 0.5) * s + (y + 0.5) * down;
        back.apply({&e, 1}, {&n, 1});
        return std::clamp(static_cast<int>(std::lround(band == 0   ? 2 * (e - kEast0)
                                                       : band == 1 ? 2 * (n - kNorth0)
                                                                   : 50.0)),
                          0, 255);
    };
    write_image(folder.path() / "a.tif", image);
    const auto f = frame();
    const Raster raster =
        Orthophotos({folder.path()}, f).read(voxel_x(f, 0), voxel_z(f, 100), 100, 100);
    REQUIRE(!raster.empty());
    int seen = 0;
    int wrong = 0;
    for (int z = 0; z < 100; ++z)
        for (int x = 0; x < 100; ++x) {
            const auto i = static_cast<std::size_t>(z * 100 + x);
            if (raster.flags[i] == 0)
                continue;
            ++seen;
            const double north = 100 - z - 0.5;
            const double east = x + 0.5;
            if (std::abs(raster.colour[i].r - 2 * east) > 2.01 ||
                std::abs(raster.colour[i].g - 2 * north) > 2.01)
                ++wrong;
        }
    CHECK(seen > 2500);
    CHECK(wrong == 0);
}

TEST_CASE("threads that read side by side get what one gets", "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    ImageFile image;
    image.width = image.height = 800;
    image.geo = {kEast0, 0.25, 0, kNorth0 + 200, 0, -0.25};
    image.value = noise;
    write_image(folder.path() / "a.tif", image);
    const auto f = frame();
    const Orthophotos photos({folder.path()}, f);
    const auto x0 = voxel_x(f, 0);
    const auto z0 = voxel_z(f, 200);
    std::vector<Raster> alone, together(9);
    for (int i = 0; i < 9; ++i)
        alone.push_back(photos.read(x0 + i % 3 * 64 - 2, z0 + i / 3 * 64 - 2, 68, 68));
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < 9; ++i)
            threads.emplace_back([&, i] {
                together[static_cast<std::size_t>(i)] =
                    photos.read(x0 + i % 3 * 64 - 2, z0 + i / 3 * 64 - 2, 68, 68);
            });
    }
    for (std::size_t i = 0; i < 9; ++i) {
        CHECK(alone[i].colour == together[i].colour);
        CHECK(alone[i].flags == together[i].flags);
    }
}

TEST_CASE("more files than a process may open at once are read all the same",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    for (int i = 0; i < 300; ++i) {
        ImageFile image;
        image.width = image.height = 2;
        image.geo = {kEast0 + 2 * i, 1, 0, kNorth0 + 2, 0, -1};
        image.value = [i](int, int, int band) { return band == 0 ? i % 250 : i / 250; };
        write_image(folder.path() / (std::to_string(i) + ".tif"), image);
    }
    const auto f = frame();
    const Orthophotos photos({folder.path()}, f);
    for (int pass = 0; pass < 2; ++pass) {
        const Raster raster = photos.read(voxel_x(f, 0), voxel_z(f, 2), 600, 1);
        int wrong = 0;
        for (int x = 0; x < 600; ++x) {
            const std::string low = std::to_string(x / 2 % 250);
            const std::string high = std::to_string(x / 2 / 250);
            if (column_text(raster, x, 0) != low + "," + high + "," + high + " -")
                ++wrong;
        }
        CHECK(wrong == 0);
    }
}

TEST_CASE("images that lie outside the world are warned of, once",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    const auto f = frame();
    const grid::ColumnRect world{voxel_x(f, 0), voxel_z(f, 60), voxel_x(f, 60), voxel_z(f, 0)};
    const auto image_at = [&](const char* name, double east, const char* crs) {
        ImageFile image = plain(1, 10);
        image.geo[0] += east;
        image.crs = crs;
        write_image(folder.path() / name, image);
    };
    const auto said = [&] {
        const Orthophotos photos({folder.path()}, f);
        const Warnings warnings;
        photos.warn_of_outside(world);
        return warnings.text();
    };
    SECTION("over the world, even by a metre, with or without a CRS") {
        image_at("a.tif", 59, kCrs);
        image_at("b.tif", -59, "");
        image_at("c.tif", 0, kCrs);
        CHECK(said().empty());
    }
    SECTION("a metre outside: where it lies, and where the world") {
        image_at("a.tif", 61, kCrs);
        CHECK_THAT(said(),
                   contains((folder.path() / "a.tif").string() + " covers nothing of the world"));
        CHECK_THAT(said(),
                   contains("it lies at E 770061 to 770121, N 6277000 to 6277060 (EPSG:2154)"));
        CHECK_THAT(said(), contains("the world at E 770000 to 770060, N 6277000 to 6277060"));
        CHECK_THAT(said(), !contains("assumed"));
    }
    SECTION("several: one line for all") {
        image_at("a.tif", 100, kCrs);
        image_at("b.tif", 200, kCrs);
        image_at("c.tif", 300, "");
        const std::string text = said();
        CHECK(std::count(text.begin(), text.end(), '\n') == 1);
        CHECK_THAT(text, contains("c.tif (one of 3 such)") &&
                             contains("(EPSG:2154, assumed: the file names no CRS)"));
    }
    SECTION("some of a folder: a remark when they state where they lie") {
        image_at("a.tif", 0, kCrs);
        image_at("b.tif", 100, kCrs);
        CHECK(said().empty());
        image_at("c.tif", 300, "");
        CHECK_THAT(said(), contains("c.tif (one of 2 such)"));
    }
}

TEST_CASE("images of one size of pixels and one year are a series",
          "[voxelserver][imagery][ortho]") {
    const TemporaryFolder folder;
    const auto f = frame();
    const auto series = [&] {
        std::vector<std::size_t> out;
        for (const Orthophotos::Input& image : Orthophotos({folder.path()}, f).inputs())
            out.push_back(image.series);
        return out;
    };
    write_image(folder.path() / "a.tif", plain(0.5, 10, "2021:06:14 10:30:00"));
    write_image(folder.path() / "b.tif", plain(0.52, 20, "2021:09:01 00:00:00"));
    CHECK(series() == std::vector<std::size_t>{0, 0});
    write_image(folder.path() / "c.tif", plain(0.5, 30, "2019:06:14 10:30:00"));
    write_image(folder.path() / "d.tif", plain(0.5, 40));
    write_image(folder.path() / "e.tif", plain(1, 50, "2021:06:14 10:30:00"));
    // In order of precedence: a (finer, newest), c, d, b, e.
    CHECK(series() == std::vector<std::size_t>{0, 1, 2, 0, 3});
}
