// Headers whose bounds are not those of the points: strays, wrong numbers, and none at all.
#include "tests/catch.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

using Bounds = std::array<double, 6>;  // least x, y, z, greatest x, y, z; metres from the corner,
                                       // heights as they are

void state_bounds(const std::filesystem::path& file, const Bounds& b) {
    std::string bytes = read_content(file);
    const std::array<double, 3> corner{kEast0, kNorth0, 0};
    for (std::size_t a = 0; a < 3; ++a) {
        const double least = b[a] + corner[a];
        const double greatest = b[a + 3] + corner[a];
        std::memcpy(bytes.data() + 179 + 16 * a, &greatest, 8);
        std::memcpy(bytes.data() + 187 + 16 * a, &least, 8);
    }
    write_content(file, bytes);
}

/// 200 x 160 m of gentle land.
Cloud land() {
    Cloud out;
    out.cover(0, 0, 200, 160, 0.8, 2,
              [](double e, double n) { return 100 + std::sin(e / 20) + 0.01 * n; });
    return out;
}

constexpr Bounds kTrue = {0.4, 0.4, 98, 199.6, 159.6, 104};

/// The land's columns, whatever lies around them.
Checksums make_land(OpenWorld& world) {
    std::vector<voxel::BoxKey> keys;
    for (std::int32_t bx = voxel_x(0) >> 6; bx <= voxel_x(199.9) >> 6; ++bx)
        for (std::int32_t bz = voxel_z(159.9) >> 6; bz <= voxel_z(0) >> 6; ++bz)
            keys.push_back({0, bx, 0, bz});
    return checksums(world.world(), keys);
}

}  // namespace

TEST_CASE(
    "a stray point within the header's bounds makes the world no larger, in any order of the "
    "points",
    "[voxelserver][voxelize][headers]") {
    struct Case {
        const char* name;
        double east;
        double north;
        const char* file;
        bool first;
    };
    const auto c = GENERATE(values<Case>({
        {"5 km away, the first point", 5000, 5000, "first.las", true},
        {"5 km away, packed, the last point", 5000, 5000, "last.laz", false},
        {"20 km away, packed, the first", 20'000, -20'000, "far.laz", true},
        {"near the CRS's origin", -kEast0, -2'000'000, "zero.las", false},
        {"on one axis only", 0, 9000, "north.laz", false},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        Cloud cloud;
        if (c.first)
            cloud.add(c.east, c.north, 100, 2);
        const Cloud clean_land = land();
        for (const auto& p : clean_land.points())
            cloud.add(p.east, p.north, p.height, p.source_class);
        if (!c.first)
            cloud.add(c.east, c.north, 100, 2);
        const auto file = folder.path() / c.file;
        cloud.write(file);
        clean_land.write(folder.path() / "clean.las");
        const Warnings warnings;
        OpenWorld world(file), clean(folder.path() / "clean.las");
        CHECK((world.info().bounds == clean.info().bounds));
        CHECK((make_land(world) == make_land(clean)));
        CHECK(world.world().stats().outliers == 1);
        CHECK(warnings.count(std::string(c.file) + ": its header states the bounds") == 1);
        CHECK(warnings.count("clean.las") == 0);
    }
}

TEST_CASE("bounds that hold part of the points are widened to all of them",
          "[voxelserver][voxelize][headers]") {
    struct Case {
        const char* name;
        Bounds stated;
        const char* file;
    };
    const auto c = GENERATE(values<Case>({
        {"half of the land", {0.4, 0.4, 98, 100, 159.6, 104}, "half.las"},
        {"two metres short on each side", {2.4, 2.4, 98, 197.6, 157.6, 104}, "short.laz"},
        {"short in height", {0.4, 0.4, 100.5, 199.6, 159.6, 101}, "flat.las"},
        {"reaching far beyond them, packed", {-1e6, 0.4, 98, 199.6, 1e6, 104}, "wide.laz"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / c.file;
        land().write(file);
        land().write(folder.path() / "clean.laz");
        state_bounds(file, c.stated);
        const Warnings warnings;
        OpenWorld world(file), clean(folder.path() / "clean.laz");
        CHECK((world.info().bounds == clean.info().bounds));
        CHECK((make_land(world) == make_land(clean)));
        CHECK(world.world().stats().outliers == 0);
        CHECK(warnings.count("its header states the bounds") == 1);
    }
}

TEST_CASE("what files share is said of each world, when it is open",
          "[voxelserver][voxelize][headers]") {
    const TemporaryFolder folder;
    for (const char* name : {"a.laz", "b.laz", "c.laz"}) {
        land().write(folder.path() / name);
        state_bounds(folder.path() / name, {-1e6, 0.4, 98, 199.6, 1e6, 104});
    }
    const Warnings warnings;
    const OpenWorld first(folder.path());
    CHECK(warnings.count("laz: its header states the bounds") == 2);
    CHECK(warnings.count("2 other files, such as") == 1);
    const OpenWorld second(folder.path());
    CHECK(warnings.count("laz: its header states the bounds") == 4);
    CHECK(warnings.count("2 other files, such as") == 2);
}

TEST_CASE("bounds that hold no point are an error that names the header",
          "[voxelserver][voxelize][headers]") {
    struct Case {
        const char* name;
        Bounds stated;
        const char* message;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing but zeros", {-kEast0, -kNorth0, 0, -kEast0, -kNorth0, 0}, "none of the"},
        {"least and greatest swapped", {199.6, 159.6, 104, 0.4, 0.4, 98}, "minimum above maximum"},
        {"another place", {5000, 0.4, 98, 5200, 159.6, 104}, "none of the"},
        {"another height", {0.4, 0.4, 0, 199.6, 159.6, 20}, "none of the"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "bad.laz";
        land().write(file);
        state_bounds(file, c.stated);
        CHECK_THROWS_WITH(OpenWorld(file), contains("bad.laz: its header states the bounds") &&
                                               contains(c.message) && !contains("\n"));
    }
}

TEST_CASE("honest headers of odd surveys are believed, and all their land is there",
          "[voxelserver][voxelize][headers]") {
    struct Place {
        double east, north, side_m;
    };
    struct Case {
        const char* name;
        std::vector<Place> places;
    };
    const auto c = GENERATE(values<Case>({
        {"two places four kilometres apart", {{0, 0, 100}, {3000, 3000, 100}}},
        {"an islet two kilometres off", {{0, 0, 300}, {2000, 0, 12}}},
        {"a few points, kilometres apart", {{0, 0, 1}, {900, 700, 1}, {1800, 0, 1}, {2700, 9, 1}}},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        Cloud cloud;
        for (const auto& [east, north, side_m] : c.places)
            cloud.cover(east, north, east + side_m, north + side_m, 1, 2,
                        [](double, double) { return 50.0; });
        for (const char* name : {"odd.las", "odd.laz"}) {
            cloud.write(folder.path() / name);
            const Warnings warnings;
            OpenWorld world(folder.path() / name);
            for (const auto& p : cloud.points()) {
                const voxel::VoxelBounds& b = world.info().bounds;
                if (voxel_x(p.east) < b.min[0] || voxel_x(p.east) >= b.max[0] ||
                    voxel_z(p.north) < b.min[2] || voxel_z(p.north) >= b.max[2])
                    FAIL(name << ": point " << p.east << ", " << p.north << " lies outside");
            }
            for (const auto& [east, north, side_m] : c.places)
                CHECK(world.top(voxel_x(east + side_m / 2), voxel_z(north + side_m / 2)) == 50);
            CHECK(world.world().stats().outliers == 0);
            CHECK(warnings.text().empty());
        }
    }
}

TEST_CASE("an area that is nearly all empty is warned of", "[voxelserver][voxelize]") {
    struct Case {
        const char* name;
        double edge_m;  ///< of the land in the corner
        int warnings;
    };
    const auto c = GENERATE(values<Case>({{"a corner", 20, 1}, {"all", 600, 0}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        Cloud cloud;
        const auto level = [](double, double) { return 50; };
        cloud.cover(0, 0, c.edge_m, c.edge_m, 2, 2, level);
        cloud.add(599, 599, 50, 2);
        cloud.write(folder.path() / "a.laz");
        const Warnings warnings;
        {
            OpenWorld world(folder.path() / "a.laz");
            const voxel::BoxRange boxes = voxel::boxes_over(world.info().bounds, 0);
            for (std::int32_t bx = boxes.min.bx; bx < boxes.max.bx; ++bx)
                for (std::int32_t bz = boxes.min.bz; bz < boxes.max.bz; ++bz)
                    (void)world.world().box({0, bx, boxes.min.by, bz});
        }
        CHECK(warnings.count("% of the area that the files claim is empty") == c.warnings);
    }
}
