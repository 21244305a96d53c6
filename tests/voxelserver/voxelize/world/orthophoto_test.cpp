#include <gdal_priv.h>

#include <fstream>
#include <numbers>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

struct Colour {
    int r;
    int g;
    int b;
};
/// A colour for every place: smooth, so that resampling changes it little, and warm, so that
/// nothing looks like water.
Colour colour_at(double east, double north) {
    return {static_cast<int>(120 + east), static_cast<int>(220 - north), 60};
}

struct Image {
    int width = 100;
    int height = 100;
    std::array<double, 6> geo{};  ///< GDAL's order
    std::string crs = kCrs;
    GDALDataType type = GDT_Byte;
    bool palette = false;
    bool grey = false;
    bool nodata_corner = false;
};

/// Writes a GeoTIFF whose pixels have the colours of the places they show. @param to_place pixel
/// coordinates to metres east, north
template <class ToPlace>
void write(const fs::path& file, const Image& image, const ToPlace& to_place) {
    geo::start_gdal();
    const int bands = image.palette || image.grey ? 1 : 3;
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    GDALDatasetUniquePtr out(driver->Create(file.string().c_str(), image.width, image.height, bands,
                                            image.type, nullptr));
    REQUIRE(out);
    auto geo = image.geo;
    out->SetGeoTransform(geo.data());
    if (!image.crs.empty())
        out->SetSpatialRef(&geo::Crs::from_text(image.crs).ogr());
    GDALColorTable table(GPI_RGB);
    for (short i = 0; i < 256; ++i) {
        const GDALColorEntry entry{static_cast<short>(255 - i), i, 77, 255};
        table.SetColorEntry(i, &entry);
    }
    for (int b = 0; b < bands; ++b) {
        std::vector<std::uint16_t> pixels;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) {
                const auto [east, north] = to_place(x + 0.5, y + 0.5);
                const Colour c = colour_at(east, north);
                int v = std::clamp(b == 0 ? c.r : b == 1 ? c.g : c.b, 1, 255);
                if (image.type == GDT_UInt16)
                    v *= 257;
                if (image.nodata_corner && x < image.width / 2 && y < image.height / 2)
                    v = 0;
                pixels.push_back(static_cast<std::uint16_t>(v));
            }
        GDALRasterBand* band = out->GetRasterBand(b + 1);
        if (image.palette)
            band->SetColorTable(&table);
        if (image.nodata_corner)
            band->SetNoDataValue(0);
        REQUIRE(band->RasterIO(GF_Write, 0, 0, image.width, image.height, pixels.data(),
                               image.width, image.height, GDT_UInt16, 0, 0, nullptr) == CE_None);
    }
}

/// A plain of 100 x 100 m.
class Plain {
public:
    Plain() {
        Cloud cloud;
        cloud.cover(0, 0, 100, 100, 0.5, 2, [](double, double) { return 20.5; });
        cloud.write(m_folder.path() / "plain.laz");
    }
    [[nodiscard]] fs::path image(const std::string& name = "image.tif") const {
        return m_folder.path() / name;
    }
    [[nodiscard]] OpenWorld open() const {
        auto options = OpenWorld::with(m_folder.path() / "plain.laz");
        options.orthophotos = {image()};
        options.photo = "raw";  // such colours are not those of nature
        return OpenWorld(options);
    }

private:
    TemporaryFolder m_folder;
};

struct Compared {
    int coloured = 0;
    int bare = 0;
    int wrong = 0;
    std::string details;
};

std::string text_of(Colour c) {
    return std::to_string(c.r) + " " + std::to_string(c.g) + " " + std::to_string(c.b);
}

/// Compares every column's colour with that of its place.
template <class Inside, class Wanted>
Compared compare(OpenWorld& world, const Inside& inside, const Wanted& wanted, int tolerance) {
    Compared out;
    for (double n = 0.5; n < 100; ++n)
        for (double e = 0.5; e < 100; ++e) {
            const int where = inside(e, n);  // 1 inside, 0 outside, -1 at the edge: either is right
            if (where < 0)
                continue;
            const auto v = world.top_voxel(voxel_x(e), voxel_z(n));
            if (!v)
                throw std::runtime_error("no voxel in a column of the plain");
            if (!v->has_colour()) {
                ++out.bare;
                if (where == 1 && ++out.wrong <= 3)
                    out.details += "\n  " + std::to_string(e) + " m east, " + std::to_string(n) +
                                   " m north: no colour";
                continue;
            }
            ++out.coloured;
            const Colour c = wanted(e, n);
            const bool near = std::abs(v->colour.r - c.r) <= tolerance &&
                              std::abs(v->colour.g - c.g) <= tolerance &&
                              std::abs(v->colour.b - c.b) <= tolerance;
            if ((where == 0 || !near) && ++out.wrong <= 3)
                out.details += "\n  " + std::to_string(e) + " m east, " + std::to_string(n) +
                               " m north: " + text_of({v->colour.r, v->colour.g, v->colour.b}) +
                               (where == 0 ? " outside the image" : "") + ", expected " +
                               text_of(c);
        }
    return out;
}

constexpr auto kEverywhere = [](double, double) { return 1; };

}  // namespace

TEST_CASE("an orthophoto's colours land in their columns, at any resolution",
          "[voxelserver][voxelize][ortho]") {
    const double pixel_m = GENERATE(0.2, 0.5, 1.0, 1.6, 4.0);
    INFO(pixel_m << " m a pixel");
    const Plain plain;
    Image image;
    image.width = image.height = static_cast<int>(std::ceil(100 / pixel_m));
    image.geo = {kEast0, pixel_m, 0, kNorth0 + 100, 0, -pixel_m};
    write(plain.image(), image,
          [&](double x, double y) { return std::pair(x * pixel_m, 100 - y * pixel_m); });
    auto world = plain.open();
    const auto found = compare(world, kEverywhere, colour_at, pixel_m <= 1 ? 2 : 4);
    INFO(found.details);
    CHECK(found.coloured == 10'000);
    CHECK(found.wrong == 0);
}

TEST_CASE("outside an orthophoto there is no colour", "[voxelserver][voxelize][ortho]") {
    const Plain plain;
    Image image;
    image.width = 40;
    image.height = 30;
    image.geo = {kEast0 + 25.3, 1, 0, kNorth0 + 70.6, 0, -1};
    write(plain.image(), image, [](double x, double y) { return std::pair(25.3 + x, 70.6 - y); });
    auto world = plain.open();
    const auto found = compare(
        world,
        [](double e, double n) { return e > 25.3 && e < 65.3 && n > 40.6 && n < 70.6 ? 1 : 0; },
        colour_at, 2);
    INFO(found.details);
    CHECK(found.coloured == 40 * 30);
    CHECK(found.wrong == 0);
}

TEST_CASE("a rotated orthophoto lands in its columns, and colours nothing outside",
          "[voxelserver][voxelize][ortho]") {
    const Plain plain;
    Image image;
    image.width = image.height = 50;
    const double angle = 30 * std::numbers::pi / 180;
    const double s = std::sin(angle);
    const double c = std::cos(angle);
    // Corner at (45, 85), turned clockwise by 30 degrees.
    image.geo = {kEast0 + 45, c, -s, kNorth0 + 85, -s, -c};
    write(plain.image(), image,
          [&](double x, double y) { return std::pair(45 + c * x - s * y, 85 - s * x - c * y); });
    auto world = plain.open();
    const auto inside = [&](double e, double n) {
        const double x = c * (e - 45) - s * (n - 85);
        const double y = -s * (e - 45) - c * (n - 85);
        const double depth = std::min({x, y, 50 - x, 50 - y});
        return depth > 1.5 ? 1 : depth < -1.5 ? 0 : -1;
    };
    const auto found = compare(world, inside, colour_at, 5);
    INFO(found.details);
    CHECK(found.coloured > 1500);
    CHECK(found.wrong == 0);
}

TEST_CASE("an orthophoto of another system is moved to its place",
          "[voxelserver][voxelize][ortho]") {
    const Plain plain;
    const auto lambert = geo::Crs::from_text(kCrs);
    const auto utm = geo::Crs::from_text("EPSG:32631");
    double x0 = kEast0 + 50;
    double y0 = kNorth0 + 50;
    geo::Transform(lambert, utm).apply({&x0, 1}, {&y0, 1});
    Image image;
    image.crs = "EPSG:32631";
    image.width = image.height = 160;
    image.geo = {x0 - 40, 0.5, 0, y0 + 40, 0, -0.5};
    const geo::Transform back(utm, lambert);
    write(plain.image(), image, [&](double x, double y) {
        double e = x0 - 40 + x * 0.5;
        double n = y0 + 40 - y * 0.5;
        back.apply({&e, 1}, {&n, 1});
        return std::pair(e - kEast0, n - kNorth0);
    });
    auto world = plain.open();
    const geo::Transform there(lambert, utm);
    const auto inside = [&](double e, double n) {
        double x = kEast0 + e;
        double y = kNorth0 + n;
        there.apply({&x, 1}, {&y, 1});
        const double depth = 40 - std::max(std::abs(x - x0), std::abs(y - y0));
        return depth > 1.5 ? 1 : depth < -1.5 ? 0 : -1;
    };
    const auto found = compare(world, inside, colour_at, 5);
    INFO(found.details);
    CHECK(found.coloured > 5000);
    CHECK(found.wrong == 0);
}

TEST_CASE("orthophotos with a palette, in grey, and with 16 bits have their colours",
          "[voxelserver][voxelize][ortho]") {
    const Plain plain;
    Image image;
    image.geo = {kEast0, 1, 0, kNorth0 + 100, 0, -1};
    const auto place = [](double x, double y) { return std::pair(x, 100 - y); };
    SECTION("palette") {
        image.palette = true;
        write(plain.image(), image, place);
        auto world = plain.open();
        CHECK(compare(
                  world, kEverywhere,
                  [](double e, double n) {
                      return Colour{255 - colour_at(e, n).r, colour_at(e, n).r, 77};
                  },
                  2)
                  .wrong == 0);
    }
    SECTION("grey") {
        image.grey = true;
        write(plain.image(), image, place);
        auto world = plain.open();
        CHECK(compare(
                  world, kEverywhere,
                  [](double e, double n) {
                      return Colour{colour_at(e, n).r, colour_at(e, n).r, colour_at(e, n).r};
                  },
                  2)
                  .wrong == 0);
    }
    SECTION("16 bits") {
        image.type = GDT_UInt16;
        write(plain.image(), image, place);
        auto world = plain.open();
        CHECK(compare(world, kEverywhere, colour_at, 2).wrong == 0);
    }
    SECTION("no CRS: taken to be the survey's") {
        image.crs.clear();
        write(plain.image(), image, place);
        auto world = plain.open();
        CHECK(compare(world, kEverywhere, colour_at, 2).wrong == 0);
    }
}

TEST_CASE("pixels without data give no colour, and do not bleed into their neighbours",
          "[voxelserver][voxelize][ortho]") {
    const double pixel_m = GENERATE(0.5, 1.0, 1.6);
    INFO(pixel_m << " m a pixel");
    const Plain plain;
    Image image;
    image.nodata_corner = true;
    image.width = image.height = static_cast<int>(100 / pixel_m) / 2 * 2;
    const double half = image.width / 2 * pixel_m;
    image.geo = {kEast0, pixel_m, 0, kNorth0 + 100, 0, -pixel_m};
    write(plain.image(), image,
          [&](double x, double y) { return std::pair(x * pixel_m, 100 - y * pixel_m); });
    auto world = plain.open();
    const auto inside = [&](double e, double n) {
        const double x = e - half;
        const double y = 100 - half - n;
        if (e > image.width * pixel_m - 1 || n < 100 - image.height * pixel_m + 1)
            return -1;
        if (std::abs(x) < 1 || std::abs(y) < 1)
            return -1;
        return x < 0 && y < 0 ? 0 : 1;
    };
    const auto found = compare(world, inside, colour_at, 4);
    INFO(found.details);
    CHECK(found.wrong == 0);
    CHECK(found.bare > 1000);
}

TEST_CASE("an image that cannot be placed or read is refused, naming it",
          "[voxelserver][voxelize][ortho]") {
    const Plain plain;
    SECTION("no such file") {
        CHECK_THROWS_WITH(plain.open(), contains("image.tif"));
    }
    SECTION("no image") {
        std::ofstream(plain.image()) << "no image";
        CHECK_THROWS_AS(plain.open(), util::Error);
        CHECK_THROWS_WITH(plain.open(),
                          contains("image.tif") && contains("no raster that can be read"));
    }
    SECTION("no place") {
        geo::start_gdal();
        GDALDatasetUniquePtr(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            plain.image().string().c_str(), 4, 4, 3, GDT_Byte, nullptr));
        CHECK_THROWS_WITH(plain.open(), contains("image.tif") && contains("not georeferenced"));
    }
}
