// Files that have little in common, in one world and one cache folder.
#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/store/squares.hpp"
#include "tests/voxelserver/store/timed_world.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// Flat ground at 100.5 m, `step_m` between points, from `east` on for 70 m; a tower in its middle.
void write_field(const fs::path& file, const std::string& crs, int format, double east,
                 double step_m, double metres_per_height = 1) {
    Cloud cloud;
    cloud.cover(east, 0, east + 70, 70, step_m, 2, [](double, double) { return 100.5; });
    cloud.cover(east + 33, 33, east + 37, 37, 0.5, 15, [](double, double) { return 120.5; });
    const geo::Transform place(geo::Crs::from_text(kCrs), geo::Crs::from_text(crs));
    lidar::LasWriterOptions options;
    options.point_format = format;
    double x0 = kEast0 + east;
    double y0 = kNorth0;
    place.apply({&x0, 1}, {&y0, 1});
    const bool degrees = geo::Crs::from_text(crs).geographic();
    options.scale = degrees ? std::array{1e-8, 1e-8, 0.001} : std::array{0.001, 0.001, 0.001};
    options.offset = {std::floor(x0), std::floor(y0), 0};
    options.wkt = geo::Crs::from_text(crs).wkt();
    lidar::LasWriter writer(file, options);
    for (const auto& c : cloud.points()) {
        lidar::LasWritePoint p;
        p.x = kEast0 + c.east;
        p.y = kNorth0 + c.north;
        place.apply({&p.x, 1}, {&p.y, 1});
        p.z = c.height / metres_per_height;
        p.classification = c.source_class;
        if (format == 7)
            p.rgb = {20'000, 40'000, 10'000};
        writer.write(p);
    }
    writer.close();
}

}  // namespace

TEST_CASE(
    "files of different systems, formats, units and densities make one world, and the same after a "
    "restart",
    "[voxelserver][store][mixed]") {
    const TemporaryFolder folder;
    const fs::path data = folder.path() / "data";
    constexpr double kUsFoot_m = 1200.0 / 3937.0;
    write_field(data / "a.laz", kCrs, 6, 0, 0.4);
    write_field(data / "b.las", "EPSG:32631", 7, 70, 0.7);
    write_field(data / "c.laz", "EPSG:2154+6360", 6, 140, 0.4,
                kUsFoot_m);  // heights in US survey feet
    write_field(data / "d.laz", "EPSG:4326", 8, 210, 0.9);
    write_field(data / "e.laz", "EPSG:3857", 6, 280, 0.5);
    auto options = OpenWorld::with(data);
    options.cache_dir = folder.path() / "cache";
    Checksums boxes;
    {
        OpenWorld world(options);
        CHECK(world.world().stats().files == 5);
        for (int i = 0; i < 5; ++i) {
            INFO("file " << static_cast<char>('a' + i));
            CHECK(world.top(voxel_x(70 * i + 12.5), voxel_z(12.5)) == 100);
            CHECK(world.top(voxel_x(70 * i + 35.5), voxel_z(35.5)) == 120);
        }
        boxes = checksums(world.world(), all_keys(world.info(), 0));
    }
    CHECK(files_ending(folder.path() / "cache" / "squares", ".square").size() == 5);
    TimedWorld second(options);
    CHECK((second.boxes(2) == boxes));
    CHECK(second.count("point load") == 0);
    // In another company the same file is another square where the frame is another, and the same
    // one where it is not.
    options.files = {data / "a.laz"};
    TimedWorld alone(options);
    alone.boxes();
    CHECK(alone.count("point load") == 0);
    options.files = {data / "b.las", data / "c.laz"};
    TimedWorld other(options);
    CHECK(other->info().crs == "EPSG:32631");
    const Checksums cached = other.boxes();
    CHECK(other.count("point load") > 0);
    options.cache_dir.clear();
    CHECK((cached == TimedWorld(options).boxes()));
}

TEST_CASE("a file that cannot join the others is named", "[voxelserver][store][mixed]") {
    const TemporaryFolder folder;
    write_field(folder.path() / "a.laz", kCrs, 6, 0, 0.8);
    Cloud lost;
    lost.cover(0, 0, 20, 20, 1, 2, [](double, double) { return 5.5; });
    lost.write(folder.path() / "lost.laz", "");
    CHECK_THROWS_WITH(TimedWorld(OpenWorld::with(folder.path())),
                      contains("lost.laz") && contains("no coordinate reference system"));
    fs::remove(folder.path() / "lost.laz");
    write_bytes(folder.path() / "text.las", "no point cloud");
    CHECK_THROWS_WITH(TimedWorld(OpenWorld::with(folder.path())), contains("text.las"));
    fs::remove(folder.path() / "text.las");
    CHECK_NOTHROW(TimedWorld(OpenWorld::with(folder.path())));
}
