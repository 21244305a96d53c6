// The seamless property: an area's voxels are the same in whatever blocks and order they are
// requested, and however the points lie in files.
#include <gdal_priv.h>

#include <algorithm>
#include <random>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

constexpr double kWide = 150;
constexpr double kDeep = 130;

/// A lake, a river, houses in rows, a wood, a bridge and a void, all across patches. Dense enough
/// that water is looked for in cells of the same size however the points are dealt.
const Cloud& country() {
    static const Cloud made = [] {
        Cloud cloud;
        std::mt19937 random(4711);
        const auto unit = [&] { return static_cast<double>(random() % 1'000'000) / 1'000'000; };
        const auto ground = [](double e, double n) {
            return 120.3 + 5 * std::sin(e / 41) + 0.03 * n;
        };
        const auto river = [](double e, double n) {
            return std::abs(n - 96 - 8 * std::sin(e / 25)) < 7;
        };
        for (int i = 0; i < 330'000; ++i) {
            const double e = 0.02 + unit() * (kWide - 0.04);
            const double n = 0.02 + unit() * (kDeep - 0.04);
            const double noise = (unit() - 0.5) * 0.12;
            const bool bridge = e > 70 && e < 76 && n > 80 && n < 115;
            const bool house = std::fmod(e, 31) > 20 && std::fmod(n, 43) > 31 && n < 80;
            if (bridge && i % 3 != 0)
                cloud.add(e, n, 128 + noise / 2, 17);
            else if (river(e, n)) {
                if (i % 6 == 0)
                    cloud.add(e, n, 115 - 0.01 * e + noise, 9);
            } else if (std::hypot(e - 45, n - 50) < 17) {
                if (i % 9 == 0)
                    cloud.add(e, n, 117 + noise, 9);
            } else if (house)
                cloud.add(e, n, ground(e, n) + 7 + 0.4 * std::fmod(e, 31) + noise, 6);
            else if (!(e > 128 && e < 140 && n > 20 && n < 30)) {  // a void
                const double crown = std::sin(e / 4) * std::sin(n / 4);
                if (e > 80 && crown > 0.3 && i % 2 == 0)
                    cloud.add(e, n, ground(e, n) + 3 + 11 * crown * unit(), i % 5 == 0 ? 1 : 5);
                else
                    cloud.add(e, n, ground(e, n) + noise, 2);
            }
        }
        return cloud;
    }();
    return made;
}

/// How the country's points lie in files.
void write_one(const fs::path& folder) {
    country().write(folder / "all.laz");
}
void write_cut(const fs::path& folder) {
    for (int i = 0; i < 4; ++i)
        country().write(
            folder / ("part" + std::to_string(i) + ".laz"), kCrs, 6, [&](const Cloud::Point& p) {
                return (p.east < 61.37) == ((i & 1) != 0) && (p.north < 88.81) == ((i & 2) != 0);
            });
}
void write_dealt(const fs::path& folder) {
    for (unsigned i = 0; i < 3; ++i) {
        std::mt19937 random(99);  // the same for each file
        country().write(folder / ("deal" + std::to_string(i) + ".laz"), kCrs, 6,
                        [&](const Cloud::Point&) { return random() % 3 == i; });
    }
}

/// Two images over the country: a coarse one, and a fine one over its middle.
void write_images(const fs::path& folder) {
    geo::start_gdal();
    struct Image {
        const char* name;
        double east;
        double north;
        double pixel_m;
        int width;
        int height;
    };
    for (const Image& image : {Image{"coarse.tif", -10, 140, 0.8, 215, 190},
                               Image{"fine.tif", 30, 100, 0.3, 200, 230}}) {
        GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            (folder / image.name).string().c_str(), image.width, image.height, 3, GDT_Byte,
            nullptr));
        REQUIRE(out);
        std::array<double, 6> geo{kEast0 + image.east, image.pixel_m, 0, kNorth0 + image.north, 0,
                                  -image.pixel_m};
        out->SetGeoTransform(geo.data());
        out->SetSpatialRef(&geo::Crs::from_text(kCrs).ogr());
        for (int b = 0; b < 3; ++b) {
            std::vector<std::uint8_t> pixels;
            for (int y = 0; y < image.height; ++y)
                for (int x = 0; x < image.width; ++x) {
                    const double e = image.east + x * image.pixel_m;
                    const double n = image.north - y * image.pixel_m;
                    pixels.push_back(static_cast<std::uint8_t>(
                        128 + 60 * std::sin(e / (5 + 3 * b)) + 60 * std::cos(n / (9 - 2 * b))));
                }
            REQUIRE(out->GetRasterBand(b + 1)->RasterIO(GF_Write, 0, 0, image.width, image.height,
                                                        pixels.data(), image.width, image.height,
                                                        GDT_Byte, 0, 0, nullptr) == CE_None);
        }
    }
}

/// The files of every layout, and the images, written once.
class Files {
public:
    Files() {
        for (const auto& [name, write] : {std::pair{"one", &write_one},
                                          {"cut", &write_cut},
                                          {"dealt", &write_dealt},
                                          {"images", &write_images}}) {
            fs::create_directory(m_folder.path() / name);
            write(m_folder.path() / name);
        }
    }
    [[nodiscard]] OpenWorld open(const std::string& layout, double voxel_m, bool images) const {
        auto options = OpenWorld::with(m_folder.path() / layout);
        options.voxel_m = voxel_m;
        if (images)
            options.orthophotos = {m_folder.path() / "images"};
        return OpenWorld(options);
    }

private:
    TemporaryFolder m_folder;
};
const Files& files() {
    static const Files made;
    return made;
}

struct Block {
    std::int32_t x0;
    std::int32_t z0;
    std::int32_t x1;
    std::int32_t z1;
};

/// An area cut into blocks of some size, the last ones narrower, in random order.
std::vector<Block> blocks_of(const Block& area, int size, std::mt19937& random) {
    std::vector<Block> out;
    for (std::int32_t z = area.z0; z < area.z1; z += size)
        for (std::int32_t x = area.x0; x < area.x1; x += size)
            out.push_back({x, z, std::min(x + size, area.x1), std::min(z + size, area.z1)});
    std::shuffle(out.begin(), out.end(), random);
    return out;
}

/// What differs between two worlds in a block of columns, from the lowest to the highest voxel;
/// distinguishes the first three.
int differences(OpenWorld& a, OpenWorld& b, const Block& block) {
    int out = 0;
    for (std::int32_t y = a.info().bounds.min[1]; y < a.info().bounds.max[1]; ++y)
        for (std::int32_t z = block.z0; z < block.z1; ++z)
            for (std::int32_t x = block.x0; x < block.x1; ++x)
                if (a.at(x, y, z) != b.at(x, y, z) && ++out <= 3)
                    UNSCOPED_INFO("voxel " << x << " " << y << " " << z << ": "
                                           << (x * a.info().voxel_m - kEast0) << " m east, "
                                           << (-z * a.info().voxel_m - kNorth0) << " m north");
    return out;
}

}  // namespace

TEST_CASE("any area has the same voxels in blocks of any size and order, from files of any cut",
          "[voxelserver][voxelize][seamless]") {
    const double voxel_m = GENERATE(1.0, 0.5, 2.0);
    const bool images = GENERATE(true, false);
    OpenWorld reference = files().open("one", voxel_m, images);
    (void)checksums(reference.world(), all_keys(reference.info(), 0));
    for (const char* layout : {"one", "cut", "dealt"})
        for (unsigned seed = 1; seed <= 2; ++seed) {
            std::mt19937 random(seed * 31 + static_cast<unsigned>(voxel_m * 4));
            OpenWorld world = files().open(layout, voxel_m, images);
            INFO(voxel_m << " m, " << layout << (images ? ", with images" : "") << ", seed "
                         << seed);
            REQUIRE(world.info().bounds == reference.info().bounds);
            REQUIRE(world.world().stats().water_cell_m == reference.world().stats().water_cell_m);
            const auto& bounds = world.info().bounds;
            const int size = std::array{16, 24, 64, 100, 256}[random() % 5];
            const auto side =
                static_cast<std::int32_t>(std::min(130.0, 60 / voxel_m + random() % 60));
            const std::int32_t x0 = bounds.min[0] - 5 + static_cast<std::int32_t>(random() % 60);
            const std::int32_t z0 = bounds.min[2] - 5 + static_cast<std::int32_t>(random() % 60);
            int different = 0;
            for (const Block& block : blocks_of({x0, z0, x0 + side, z0 + side}, size, random))
                different += differences(reference, world, block);
            INFO("columns " << x0 << " " << z0 << " and " << side << " on, in blocks of " << size);
            CHECK(different == 0);
        }
}

TEST_CASE("all boxes of all levels are the same from files of any cut, in any order",
          "[voxelserver][voxelize][seamless]") {
    const double voxel_m = GENERATE(1.0, 0.5, 2.0);
    OpenWorld reference = files().open("one", voxel_m, true);
    std::vector<voxel::BoxKey> keys;
    for (int level = 0; level < std::min(4, reference.info().levels); ++level) {
        const auto more = all_keys(reference.info(), level);
        keys.insert(keys.end(), more.begin(), more.end());
    }
    const Checksums wanted = checksums(reference.world(), keys);
    CHECK(std::count_if(wanted.begin(), wanted.end(), [](const auto& e) { return e.second != 0; }) >
          4);
    unsigned seed = 0;
    for (const char* layout : {"one", "cut", "dealt"}) {
        std::shuffle(keys.begin(), keys.end(), std::mt19937(++seed));
        OpenWorld world = files().open(layout, voxel_m, true);
        INFO(voxel_m << " m, " << layout << ", seed " << seed);
        int different = 0;
        for (const auto& [key, sum] : checksums(world.world(), keys))
            if (sum != wanted.at(key) && ++different <= 3)
                UNSCOPED_INFO("box " << voxel::to_string(key));
        CHECK(different == 0);
    }
}

TEST_CASE("what lies two kilometres away changes nothing here",
          "[voxelserver][voxelize][seamless]") {
    const TemporaryFolder folder;
    fs::create_directory(folder.path() / "here");
    fs::create_directory(folder.path() / "both");
    country().write(folder.path() / "here" / "here.laz");
    fs::copy(folder.path() / "here" / "here.laz", folder.path() / "both");
    // The same density, other land: higher, and named before or after.
    const std::string name = GENERATE("a_far.laz", "z_far.laz");
    Cloud far;
    for (const auto& p : country().points())
        far.add(p.east + 2000, kDeep - p.north, p.height + 35, p.source_class);
    far.write(folder.path() / "both" / name);
    OpenWorld here(folder.path() / "here"), both(folder.path() / "both");
    REQUIRE(both.world().stats().files == 2);
    REQUIRE(both.world().stats().water_cell_m == here.world().stats().water_cell_m);
    const auto keys = all_keys(here.info(), 0);
    (void)checksums(both.world(),
                    {{0, voxel_x(2050) >> 6, 0, voxel_z(50) >> 6}});  // something there first
    CHECK((checksums(both.world(), keys) == checksums(here.world(), keys)));
}
