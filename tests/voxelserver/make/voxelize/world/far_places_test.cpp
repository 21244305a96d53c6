// Worlds of places far apart: nothing is looked for between them, and too far is refused.
#include "common/geo/crs.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

void cover_place(Cloud& cloud, double east, double north) {
    cloud.cover(east, north, east + 60, north + 60, 1, 2, [](double, double) { return 50; });
}

void write_place(const std::filesystem::path& file, double east, double north) {
    Cloud cloud;
    cover_place(cloud, east, north);
    cloud.write(file);
}

std::uint64_t columns_made(const util::StageTimes& times) {
    for (const auto& s : times.stages())
        if (s.name == "coverage")
            return s.count;
    return 0;
}

}  // namespace

TEST_CASE("between places far apart no box is made, at no level", "[voxelserver][voxelize]") {
    const bool one_file = GENERATE(false, true);
    INFO((one_file ? "one file" : "two files"));
    const TemporaryFolder folder;
    Cloud cloud;
    for (const double at : {0.0, 40'000.0}) {
        cover_place(cloud, at, at);
        if (!one_file)
            write_place(folder.path() / ("at" + std::to_string(at) + ".laz"), at, at);
    }
    if (one_file)
        cloud.write(folder.path() / "both.laz");
    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(OpenWorld::with(folder.path()), times);
    const int top = world->info().levels - 1;
    REQUIRE(top >= 9);
    std::size_t found = 0;
    for (const int level : {top, 4})
        for (const auto& key : all_keys(world->info(), level))
            found += world->box(key) ? 1 : 0;
    CHECK(found > 0);
    CHECK(columns_made(times) <= 8);  // two places of at most two by two columns of boxes
    const std::int32_t bx = voxel_x(20'000) >> 6;
    const std::int32_t bz = voxel_z(20'000) >> 6;
    CHECK(world->box({0, bx, 0, bz}) == nullptr);
    CHECK(world->column(0, bx, bz).empty());
    CHECK(!world->column(0, voxel_x(10) >> 6, voxel_z(10) >> 6).empty());
    CHECK(!world->column(top, voxel_x(10) >> (6 + top), voxel_z(10) >> (6 + top)).empty());
}

TEST_CASE("places too far apart for one world are refused by name, with the distance",
          "[voxelserver][voxelize]") {
    struct Case {
        double east;
        double north;
        const char* message;  // "": it is allowed
    };
    const auto c = GENERATE(values<Case>({
        {0, 99'000, ""},
        {0, 150'000, "150 km apart"},
        {-120'000, 50'000, "120 km apart"},
    }));
    const TemporaryFolder folder;
    write_place(folder.path() / "a.laz", 0, 0);
    write_place(folder.path() / "b.laz", c.east, c.north);
    if (*c.message != '\0')
        CHECK_THROWS_WITH(OpenWorld(folder.path()),
                          contains(c.message) && contains("a.laz") && contains("b.laz"));
    else
        CHECK(-OpenWorld(folder.path()).info().bounds.min[2] > kNorth0 + c.north);
}

TEST_CASE("a file of another system lies within its bounds, also where its edges are arcs there",
          "[voxelserver][voxelize]") {
    // A degree of latitude and three of longitude: the northern edge bends by kilometres in the
    // middle of the UTM zone.
    const TemporaryFolder folder;
    lidar::LasWriterOptions options;
    options.scale = {1e-7, 1e-7, 0.01};
    options.offset = {3, 44, 0};
    options.wkt = geo::Crs::from_text("EPSG:4326").wkt();
    lidar::LasWriter writer(folder.path() / "degrees.laz", options);
    std::vector<double> x;
    std::vector<double> y;
    for (int i = 0; i <= 60; ++i)
        for (int k = 0; k <= 20; ++k) {
            lidar::LasWritePoint p;
            p.x = 1.5 + 3.0 * i / 60;
            p.y = 44 + k / 20.0;
            p.z = 10;
            p.classification = 2;
            x.push_back(p.x);
            y.push_back(p.y);
            writer.write(p);
        }
    writer.close();
    OpenWorld world(folder.path() / "degrees.laz");
    geo::Transform(geo::Crs::from_text("EPSG:4326"), geo::Crs::from_text("EPSG:32631")).apply(x, y);
    const auto& b = world.info().bounds;
    for (std::size_t i = 0; i < x.size(); ++i) {
        INFO(x[i] << ", " << y[i] << " in " << b.min[0] << " to " << b.max[0] << ", " << -b.max[2]
                  << " to " << -b.min[2]);
        if (!(x[i] >= b.min[0] && x[i] < b.max[0] && -y[i] >= b.min[2] && -y[i] < b.max[2]))
            FAIL("point " << i << " lies outside");
    }
}
