// Files and images without a place on Earth that are named like squares of a source.
#include <cstring>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "tests/voxelserver/image_file.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::Material;

namespace {

constexpr double kWest = 462'000;
constexpr double kSouth = 101'000;

/// 60 m in the north-west corner of the square 462_101.
void write_corner(const std::filesystem::path& file, const std::string& crs = {}) {
    Cloud cloud(kWest, kSouth);
    cloud.cover(0, 940, 60, 1000, 0.5, 2, [](double, double) { return 400.5; });
    cloud.write(file, crs);
}

/// 100 x 100 pixels without a place: red roofs' colour in the north-west pixel of 10 m, else that
/// of a meadow.
void write_png(const std::filesystem::path& file) {
    const auto tiff = file.parent_path() / "placed.tif";
    ImageFile image;
    image.value = [](int x, int y, int band) {
        const bool roof = x == 0 && y == 0;
        return roof ? std::array{200, 20, 20}[static_cast<std::size_t>(band)]
                    : std::array{0x70, 0x89, 0x4a}[static_cast<std::size_t>(band)];
    };
    write_image(tiff, image);
    {
        const GDALDatasetUniquePtr placed(GDALDataset::Open(tiff.c_str()));
        REQUIRE(GDALDatasetUniquePtr(GetGDALDriverManager()->GetDriverByName("PNG")->CreateCopy(
            file.c_str(), placed.get(), 0, nullptr, nullptr, nullptr)));
    }
    std::filesystem::remove(tiff);
    std::filesystem::remove(file.string() + ".aux.xml");
}

}  // namespace

TEST_CASE("a file without a CRS that is named like a square of a source has the source's",
          "[voxelserver][voxelize][names]") {
    struct Case {
        const char* name;
        const char* crs;
    };
    const auto c =
        GENERATE(values<Case>({{"TM_462_101.laz", "EPSG:3794"}, {"GK_462_101.laz", "EPSG:3912"}}));
    const TemporaryFolder folder;
    write_corner(folder.path() / c.name);
    CHECK(OpenWorld(folder.path() / c.name).info().crs == c.crs);
    // The table of the survey holds for both grids and names the CRS of one.
    CHECK(OpenWorld(folder.path() / c.name, "si-lss").info().crs == c.crs);
    auto options = OpenWorld::with(folder.path() / c.name);
    options.crs = "EPSG:2154";
    CHECK(OpenWorld(options).info().crs == "EPSG:2154");
}

TEST_CASE("the CRS in a file, and points elsewhere, prevail over its name",
          "[voxelserver][voxelize][names]") {
    const TemporaryFolder folder;
    write_corner(folder.path() / "GK_462_101.laz", "EPSG:3794");
    CHECK(OpenWorld(folder.path() / "GK_462_101.laz").info().crs == "EPSG:3794");
    write_corner(folder.path() / "TM_500_101.laz");
    CHECK_THROWS_AS(OpenWorld(folder.path() / "TM_500_101.laz"), util::UsageError);
}

TEST_CASE("a wrong header hides no square, and a name says nothing of points far around it",
          "[voxelserver][voxelize][names]") {
    struct Case {
        const char* name;
        double east;       ///< of more points, metres from the square's corner
        int extra;         ///< of them
        double stated_to;  ///< east, in the header
        bool is_found;
    };
    const auto c = GENERATE(values<Case>({
        {"a header's stray number", 30, 1, 1e7, true},
        {"a stray point", 8000, 1, kWest + 8000, true},
        {"another square's points", 2500, 1000, kWest + 2500, false},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "TM_462_101.laz";
        Cloud cloud(kWest, kSouth);
        cloud.cover(0, 940, 60, 1000, 0.5, 2, [](double, double) { return 400.5; });
        for (int i = 0; i < c.extra; ++i)
            cloud.add(c.east, 950, 400.5, 2);
        cloud.write(file, "");
        std::string bytes = read_content(file);
        std::memcpy(bytes.data() + 179, &c.stated_to, sizeof c.stated_to);
        write_content(file, bytes);
        const Warnings ignored;
        if (c.is_found)
            CHECK(OpenWorld(file).info().crs == "EPSG:3794");
        else
            CHECK_THROWS_AS(OpenWorld(file), util::UsageError);
    }
}

TEST_CASE("an image without a place lies on the square that it is named like",
          "[voxelserver][voxelize][names]") {
    const TemporaryFolder folder;
    const auto points = folder.path() / "TM_462_101.laz";
    write_corner(points);
    const std::string name = GENERATE("462_101.png", "TM_462_101.png", "462_102.png");
    const auto image = folder.path() / name;
    write_png(image);
    auto options = OpenWorld::with(points);
    options.orthophotos = {image};
    if (name == "462_102.png") {
        CHECK_THROWS_WITH(OpenWorld(options), contains(name) && contains("not georeferenced"));
        return;
    }
    OpenWorld world(options);
    const auto colour_at = [&](double east, double north) {
        const auto voxel =
            world.top_voxel(static_cast<std::int32_t>(std::floor(kWest + east)),
                            static_cast<std::int32_t>(std::floor(-(kSouth + north))));
        REQUIRE(voxel);
        REQUIRE(voxel->has_colour());
        return voxel->colour;
    };
    CHECK(colour_at(3.5, 996.5) == voxel::Rgb8{200, 20, 20});
    CHECK(colour_at(25.5, 996.5) == voxel::Rgb8{0x70, 0x89, 0x4a});
    CHECK(colour_at(3.5, 974.5) == voxel::Rgb8{0x70, 0x89, 0x4a});
}
