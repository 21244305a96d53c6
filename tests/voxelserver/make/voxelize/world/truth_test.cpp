// Where things are: real ground points, feet, Web Mercator, several systems at once.
#include <map>
#include <sstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/lidar/read_points.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/data/lidar/las_file.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::Material;
namespace fs = std::filesystem;

namespace {

const fs::path kShared = TERRAVOX_SHARED_DATA;

bool there(const fs::path& path) {
    if (fs::exists(path))
        return true;
    WARN("skipped: " << path.string() << " is not there");
    return false;
}

bool is_ground(const voxel::VoxelAttr& v) {
    return v.material == Material::kGround || v.material == Material::kGrass ||
           v.material == Material::kRock || v.material == Material::kSoil ||
           v.material == Material::kRoad;
}

}  // namespace

TEST_CASE("heights are true: real ground points lie in the top voxel of the ground",
          "[voxelserver][voxelize][data]") {
    struct Case {
        const char *name, *files, *classes;
    };
    const auto c = GENERATE(values<Case>(
        {{"Delft", "tudelft-3dfier-ahn3/ahn3", "nl-ahn"},
         {"Montpellier", "ign-pdal-tools/test_data_77055_627760_LA93_IGN69.laz", "fr-lidarhd"}}));
    if (!there(kShared / c.files))
        return;
    DYNAMIC_SECTION(c.name) {
        std::vector<fs::path> files;
        if (fs::is_directory(kShared / c.files))
            for (const auto& entry : fs::directory_iterator(kShared / c.files))
                files.push_back(entry.path());
        else
            files.push_back(kShared / c.files);
        // What the points say of each column, by the definition of space and not by the voxelizer's
        // code.
        struct Said {
            double low = 1e9;
            double high = -1e9;
            bool other = false;
        };
        std::map<std::pair<std::int32_t, std::int32_t>, Said> columns;
        for (const auto& file : files) {
            const auto info = lidar::read_las_info(file);
            lidar::read_las_points(info, {0, info.point_count}, [&](const pointcloud::Point& p) {
                Said& said = columns[{static_cast<std::int32_t>(std::floor(p.x)),
                                      static_cast<std::int32_t>(std::floor(-p.y))}];
                if (p.classification == 2) {
                    said.low = std::min(said.low, p.z);
                    said.high = std::max(said.high, p.z);
                }
                if (p.classification == 6 || p.classification == 9 || p.classification == 26 ||
                    p.classification == 17)
                    said.other = true;
            });
        }
        OpenWorld world(kShared / c.files, c.classes);
        int plain = 0;
        int wrong = 0;
        std::ostringstream details;
        for (const auto& [place, said] : columns) {
            if (said.low > said.high)
                continue;
            bool covered = false;  // under a roof or deck, or in a gap of one that is closed
            for (int dz = -1; dz <= 1; ++dz)
                for (int dx = -1; dx <= 1; ++dx)
                    if (const auto near = columns.find({place.first + dx, place.second + dz});
                        near != columns.end())
                        covered = covered || near->second.other;
            if (covered)
                continue;
            const auto top = world.highest(place.first, place.second, is_ground);
            // A trunk's foot between higher columns is hidden, and reads as rock.
            if (top && world.material(place.first, *top + 1, place.second) == Material::kTrunk)
                continue;
            const auto low = static_cast<std::int32_t>(std::floor(said.low));
            if (low != static_cast<std::int32_t>(std::floor(said.high)))
                continue;
            ++plain;
            if (top != low && ++wrong <= 3)
                details << "\n  column " << place.first << ", " << place.second
                        << ": ground points in voxel " << low << ", top ground voxel "
                        << top.value_or(-9999);
        }
        INFO(wrong << " of " << plain << " columns" << details.str());
        CHECK(plain > 500);
        CHECK(wrong == 0);
    }
}

TEST_CASE("a survey in feet is as wide and as high as it is in metres",
          "[voxelserver][voxelize][data]") {
    const fs::path file = kShared / "pdal" / "las" / "autzen_trim.las";
    if (!there(file))
        return;
    const auto info = lidar::read_las_info(file);
    REQUIRE(info.crs);
    OpenWorld world(file);
    const auto& b = world.info().bounds;
    CHECK(std::abs((b.max[0] - b.min[0]) - (info.max[0] - info.min[0]) * 0.3048) < 2);
    CHECK(std::abs((b.max[2] - b.min[2]) - (info.max[1] - info.min[1]) * 0.3048) < 2);
    CHECK(std::abs(b.max[1] - info.max[2] * 0.3048) < 2);
    CHECK(b.min[1] < info.min[2] * 0.3048);
    CHECK(b.min[1] > info.min[2] * 0.3048 - 20);
    int checked = 0;
    std::size_t i = 0;
    lidar::read_las_points(info, {0, info.point_count}, [&](const pointcloud::Point& p) {
        if (p.classification != 2 || i++ % 500 != 0)
            return;
        ++checked;
        const double units = world.info().crs_units_per_voxel;
        const auto x = static_cast<std::int32_t>(std::floor(p.x / units));
        const auto z = static_cast<std::int32_t>(std::floor(-p.y / units));
        const auto top = world.highest(x, z, is_ground);
        INFO("feet " << p.x << " " << p.y << " " << p.z);
        REQUIRE(top);
        CHECK(std::abs(*top - std::floor(p.z * 0.3048)) <= 1);
    });
    CHECK(checked >= 20);
}

TEST_CASE("Web Mercator's stretched metres become metres", "[voxelserver][voxelize]") {
    // A square of 100 m at Bled: 100 / cos(46.36 degrees) units of EPSG:3857.
    const double stretch = 1 / std::cos(46.364 * 3.14159265358979 / 180);
    const TemporaryFolder folder;
    double x0 = 14.0937;
    double y0 = 46.364;
    geo::Transform(geo::Crs::from_text("EPSG:4326"), geo::Crs::from_text("EPSG:3857"))
        .apply({&x0, 1}, {&y0, 1});
    Cloud cloud(x0, y0);
    cloud.cover(0, 0, 100 * stretch, 100 * stretch, stretch / 2, 2,
                [](double, double) { return 500.5; });
    cloud.write(folder.path() / "mercator.laz", "EPSG:3857");
    OpenWorld world(folder.path() / "mercator.laz");
    const auto& b = world.info().bounds;
    CHECK(std::abs(b.max[0] - b.min[0] - 100) <= 2);
    CHECK(std::abs(b.max[2] - b.min[2] - 100) <= 2);
    CHECK(b.max[1] == 501);
    CHECK(world.info().crs_units_per_voxel == Approx(stretch).epsilon(1e-4));
    REQUIRE(world.info().centre);
    CHECK(world.info().centre->lat_deg == Approx(46.3645).margin(0.001));
}

TEST_CASE("a file without a system needs one from the user or the class table",
          "[voxelserver][voxelize]") {
    Cloud cloud;
    cloud.cover(0, 0, 20, 20, 0.5, 2, [](double, double) { return 5.5; });
    const TemporaryFolder folder;
    cloud.write(folder.path() / "nowhere.laz", "");
    auto options = OpenWorld::with(folder.path() / "nowhere.laz");
    CHECK_THROWS_AS(OpenWorld(options), util::UsageError);
    CHECK_THROWS_WITH(OpenWorld(options), contains("nowhere.laz") && contains("--crs EPSG:"));
    options.crs = "EPSG:2154";
    CHECK(OpenWorld(options).info().crs == "EPSG:2154");
    options.crs.reset();
    options.classes = "fr-lidarhd";
    CHECK(OpenWorld(options).info().crs == "EPSG:2154");
    options.crs = "EPSG:99999999";
    CHECK_THROWS_AS(OpenWorld(options), util::UsageError);
    options.crs = "EPSG:4326";
    CHECK_THROWS_AS(OpenWorld(options), util::Error);
}

TEST_CASE("no input, or one without points, is an error that names it; one point is a world",
          "[voxelserver][voxelize]") {
    const TemporaryFolder folder;
    voxelize::LidarWorldOptions options;
    CHECK_THROWS_AS(OpenWorld(options), util::UsageError);
    options.files = {folder.path()};
    CHECK_THROWS_AS(OpenWorld(options), util::UsageError);
    options.files = {folder.path() / "none.laz"};
    CHECK_THROWS_AS(OpenWorld(options), util::UsageError);
    Cloud{}.write(folder.path() / "empty.laz");
    options.files = {folder.path() / "empty.laz"};
    CHECK_THROWS_WITH(OpenWorld(options), contains("holds a point"));
    Cloud cloud;
    cloud.add(10.5, 10.5, 33.5, 2);
    cloud.write(folder.path() / "one.laz");
    options.files = {folder.path() / "one.laz"};
    options.voxel_m = 0;
    CHECK_THROWS_AS(OpenWorld(options), util::UsageError);
    options.voxel_m = 1;
    options.vertical_unit = "fathom";
    CHECK_THROWS_WITH(OpenWorld(options), contains("'fathom'; allowed: m, ft, us-ft"));
    options.vertical_unit.reset();
    OpenWorld world(options);
    CHECK(world.top(voxel_x(10.5), voxel_z(10.5)) == 33);
    CHECK(world.top(voxel_x(12.5), voxel_z(10.5)) == std::nullopt);
}
