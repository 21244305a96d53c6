// Colours of images on the ground. What images are read, and which are refused, is tested with
// imagery.
#include <numbers>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/geo_image.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

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

enum class Kind { kPlain, kPalette, kGrey, k16Bits, kWithoutCrs, kWithGap };

/// A square of pixels, turned clockwise about its north-western corner.
struct Photo {
    Kind kind = Kind::kPlain;
    double pixel_m = 1;
    double east = 0;  ///< of the corner
    double north = 100;
    double side_m = 100;
    double turned_deg = 0;

    [[nodiscard]] double sine() const { return std::sin(turned_deg * std::numbers::pi / 180); }
    [[nodiscard]] double cosine() const { return std::cos(turned_deg * std::numbers::pi / 180); }
    [[nodiscard]] int pixels() const {
        return static_cast<int>(std::ceil(side_m / pixel_m)) / 2 * 2;
    }

    /// Its pixels have the colours of the places they show; the north-western quarter may lack
    /// them.
    void write(const fs::path& file) const {
        const double s = sine() * pixel_m;
        const double c = cosine() * pixel_m;
        GeoImage image;
        image.width = image.height = pixels();
        image.geo = {kEast0 + east, c, -s, kNorth0 + north, -s, -c};
        image.palette = kind == Kind::kPalette;
        if (kind == Kind::kPalette || kind == Kind::kGrey)
            image.bands = 1;
        if (kind == Kind::k16Bits)
            image.type = GDT_UInt16;
        if (kind == Kind::kWithoutCrs)
            image.crs.clear();
        if (kind == Kind::kWithGap)
            image.nodata = 0;
        write_geo_image(file, image, [&](int x, int y, int band) {
            if (kind == Kind::kWithGap && x < pixels() / 2 && y < pixels() / 2)
                return 0;
            const Colour shown = colour_at(east + c * (x + 0.5) - s * (y + 0.5),
                                           north - s * (x + 0.5) - c * (y + 0.5));
            const int value = std::clamp(band == 0   ? shown.r
                                         : band == 1 ? shown.g
                                                     : shown.b,
                                         1, 255);
            return kind == Kind::k16Bits ? value * 257 : value;
        });
    }
    [[nodiscard]] Colour wanted(double e, double n) const {
        const Colour c = colour_at(e, n);
        return kind == Kind::kPalette ? Colour{255 - c.r, c.r, 77}
               : kind == Kind::kGrey  ? Colour{c.r, c.r, c.r}
                                      : c;
    }
    /// How far within the image a place lies, metres; below 0: outside, or in its gap.
    [[nodiscard]] double depth_m(double e, double n) const {
        const double x = cosine() * (e - east) - sine() * (n - north);
        const double y = -sine() * (e - east) - cosine() * (n - north);
        const double all = pixels() * pixel_m;
        const double depth = std::min({x, y, all - x, all - y});
        return kind == Kind::kWithGap ? std::min(depth, std::max(x, y) - all / 2) : depth;
    }
};

}  // namespace

TEST_CASE("an orthophoto's colours land in their columns, and nowhere else",
          "[voxelserver][voxelize][ortho]") {
    // near_edge_m: within this of an edge a column may have a colour or not.
    struct Case {
        const char* name;
        Photo photo;
        double near_edge_m;
        int tolerance;
        int coloured;
    };
    const auto c = GENERATE(values<Case>({
        {"pixels of 0.2 m", {.pixel_m = 0.2}, 0, 2, 10'000},
        {"pixels of 4 m", {.pixel_m = 4, .side_m = 104}, 0, 4, 10'000},
        {"of a part of the land", {.east = 25.3, .north = 70.6, .side_m = 40}, 0, 2, 1600},
        {"turned by 30 degrees",
         {.east = 45, .north = 85, .side_m = 50, .turned_deg = 30},
         1.5,
         5,
         1500},
        {"with a palette", {.kind = Kind::kPalette}, 0, 2, 10'000},
        {"grey", {.kind = Kind::kGrey}, 0, 2, 10'000},
        {"of 16 bits", {.kind = Kind::k16Bits}, 0, 2, 10'000},
        {"without a CRS: taken to be the survey's", {.kind = Kind::kWithoutCrs}, 0, 2, 10'000},
        {"with fine pixels without data", {.kind = Kind::kWithGap, .pixel_m = 0.5}, 1, 4, 7000},
        {"with coarse pixels without data", {.kind = Kind::kWithGap, .pixel_m = 1.6}, 1, 4, 7000},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        Cloud plain;
        plain.cover(0, 0, 100, 100, 0.5, 2, [](double, double) { return 20.5; });
        plain.write(folder.path() / "plain.laz");
        c.photo.write(folder.path() / "image.tif");
        auto options = OpenWorld::with(folder.path() / "plain.laz");
        options.orthophotos = {folder.path() / "image.tif"};
        options.photo = "raw";  // such colours are not those of nature
        OpenWorld world(options);
        int coloured = 0;
        int wrong = 0;
        for (double n = 0.5; n < 100; ++n)
            for (double e = 0.5; e < 100; ++e) {
                const auto voxel = world.top_voxel(voxel_x(e), voxel_z(n));
                REQUIRE(voxel);
                const double depth_m = c.photo.depth_m(e, n);
                const bool has_colour = voxel->has_colour();
                coloured += has_colour ? 1 : 0;
                const Colour wanted = c.photo.wanted(e, n);
                const bool near = std::abs(voxel->colour.r - wanted.r) <= c.tolerance &&
                                  std::abs(voxel->colour.g - wanted.g) <= c.tolerance &&
                                  std::abs(voxel->colour.b - wanted.b) <= c.tolerance;
                if (std::abs(depth_m) < c.near_edge_m ||
                    (has_colour == (depth_m > 0) && (near || !has_colour)))
                    continue;
                if (++wrong <= 3)
                    UNSCOPED_INFO(e << " m east, " << n << " m north: " << int{voxel->colour.r}
                                    << " " << int{voxel->colour.g} << " " << int{voxel->colour.b});
            }
        CHECK(wrong == 0);
        CHECK(coloured >= c.coloured);
    }
}
