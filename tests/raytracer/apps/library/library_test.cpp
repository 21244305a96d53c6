#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <set>
#include <span>
#include <vector>

#include "tests/catch.hpp"
#include "tests/raytracer/apps/library/own_worlds.hpp"

using namespace terravox;
using terravox::test::Hills;
using terravox::test::SlopePoints;

namespace {

World hills(const std::string& crs = "") {
    return World::of(std::make_shared<Hills>(crs));
}

/// A small picture of few samples, as fields of a scene.
SceneText small_scene() {
    return {"", {{"output.size", "64x48"}, {"quality.samples", "1"}}};
}

/// Rays from all over the hills, in many directions.
struct ManyRays {
    std::vector<double> origins;
    std::vector<double> directions;
    ManyRays() {
        for (int i = 0; i < 4000; ++i) {
            const double turn = i * 2.399963;
            origins.insert(origins.end(),
                           {std::cos(i * 0.7) * 60, std::sin(i * 1.3) * 60, 20 + i % 150 * 1.0});
            directions.insert(directions.end(),
                              {std::cos(turn) * 3, std::sin(turn) * 3, (i % 9) - 6.5});
        }
    }
};

/// Equal bits, also of numbers that are none.
template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

}  // namespace

TEST_CASE("library: facts of a world of one's own", "[library]") {
    const World world = hills("EPSG:3794");
    CHECK(world.info().title == "hills");
    CHECK(world.info().crs == "EPSG:3794");
    CHECK(world.info().voxel_m == 0.5);
    CHECK(world.info().bounds == MapBounds{-75, -75, 75, 75, 0, 150});
    CHECK(world.info().levels > 2);
    REQUIRE(hills().info().crs.empty());
    CHECK(hills().info().bounds == MapBounds{-75, -75, 75, 75, 0, 150});
}

TEST_CASE("library: voxels are those of the source, on any number of threads", "[library]") {
    const World world = hills();
    const VoxelBlock block = world.block_of(MapBounds{-20, -30, 21, 10, 3, 40});
    CHECK(block == VoxelBlock{0, {-40, 6, -20}, {42, 80, 60}});
    const VoxelGrid grid = world.voxels(block, 1);
    REQUIRE(grid.shape == std::array<std::size_t, 3>{74, 80, 82});
    REQUIRE(grid.holes == 0);
    std::size_t i = 0;
    std::size_t wrong = 0;
    for (std::int32_t y = block.min[1]; y < block.max[1]; ++y)
        for (std::int32_t z = block.min[2]; z < block.max[2]; ++z)
            for (std::int32_t x = block.min[0]; x < block.max[0]; ++x, ++i) {
                const bool solid = y < Hills::ground(x, z) || Hills::is_tower(x, y, z);
                wrong += (grid.materials[i] != 0) == solid ? 0 : 1;
            }
    CHECK(wrong == 0);
    CHECK(grid.materials == world.voxels(block, 3).materials);
}

TEST_CASE("library: the surface is what the source says, and what rays from above meet",
          "[library]") {
    const World world = hills();
    const Raster surface = world.surface();
    REQUIRE(surface.rows == 300);
    REQUIRE(surface.columns == 300);
    CHECK(surface.cell == 0.5);
    std::vector<double> origins;
    std::vector<double> directions;
    std::size_t wrong = 0;
    for (std::int32_t row = 0; row < 300; ++row)
        for (std::int32_t column = 0; column < 300; ++column) {
            const float height =
                surface.bands.front().values[static_cast<std::size_t>(row * 300 + column)];
            wrong += height == Hills::top(column - 150, row - 150) * 0.5F ? 0 : 1;
            origins.insert(origins.end(), {-74.75 + column * 0.5, 74.75 - row * 0.5, 200});
            directions.insert(directions.end(), {0, 0, -1});
        }
    CHECK(wrong == 0);
    const RayHits hits = world.cast(origins, directions);
    for (std::size_t i = 0; i < hits.distance_m.size(); ++i)
        wrong += 200 - hits.distance_m[i] == static_cast<double>(surface.bands.front().values[i])
                     ? 0
                     : 1;
    CHECK(wrong == 0);
}

TEST_CASE("library: the surface of every level is that of the analysis", "[library]") {
    const World world = hills();
    for (int level = 0; level < world.info().levels; ++level) {
        INFO("level " << level);
        AnalysisOptions options;
        options.kind = "terrain";
        options.level = level;
        options.resolution_m = 0.5 * (1 << level);
        const Raster terrain = world.analyse(options);
        const Raster surface = world.surface(std::nullopt, level);
        REQUIRE(terrain.bands.front().name == "dsm");
        REQUIRE(terrain.rows == surface.rows);
        CHECK(same_bits(terrain.bands.front().values, surface.bands.front().values));
    }
}

TEST_CASE("library: rays meet the voxel that is there, on any number of threads", "[library]") {
    const World world = hills();
    const ManyRays rays;
    CastOptions options;
    options.threads = 1;
    const RayHits hits = world.cast(rays.origins, rays.directions, options);
    std::size_t met = 0;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < hits.distance_m.size(); ++i) {
        if (std::isinf(hits.distance_m[i])) {
            wrong += hits.material[i] == 0 && hits.face[i] == Face::kNone ? 0 : 1;
            continue;
        }
        ++met;
        const auto [x, y, z] = hits.voxel[i];
        wrong += y < Hills::ground(x, z) || Hills::is_tower(x, y, z) ? 0 : 1;
    }
    CHECK(met > 1000);
    CHECK(wrong == 0);
    options.threads = 3;
    const RayHits again = world.cast(rays.origins, rays.directions, options);
    CHECK(same_bits(again.distance_m, hits.distance_m));
    CHECK(again.voxel == hits.voxel);
    CHECK(again.face == hits.face);
    const Occlusion occlusion = world.occluded(rays.origins, rays.directions, options);
    for (std::size_t i = 0; i < hits.distance_m.size(); ++i)
        wrong += (occlusion.occluded[i] == 1) == std::isfinite(hits.distance_m[i]) ? 0 : 1;
    CHECK(wrong == 0);
}

TEST_CASE("library: one wrong ray among many is named", "[library]") {
    const World world = hills();
    ManyRays rays;
    rays.directions[3 * 3210] = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_WITH(world.cast(rays.origins, rays.directions), test::contains("ray 3210 "));
    std::fill_n(&rays.directions[3 * 3210], 3, 0.0);
    CHECK_THROWS_WITH(world.cast(rays.origins, rays.directions), test::contains("ray 3210 "));
    rays.directions[3 * 3210] = 1e-320;
    rays.origins[3 * 3210] = -1e300;
    CHECK(world.cast(rays.origins, rays.directions).distance_m.size() == 4000);
}

TEST_CASE("library: a range ends rays, and distances are metres", "[library]") {
    const World world = hills();
    const std::vector<double> origin{30, 30, 100};
    const std::vector<double> down{0, 0, -7};
    const double height = Hills::top(60, -60) * 0.5;
    CastOptions options;
    CHECK(world.cast(origin, down, options).distance_m.front() == 100 - height);
    options.range_m = 100 - height - 0.25;
    CHECK(std::isinf(world.cast(origin, down, options).distance_m.front()));
    CHECK(world.occluded(origin, down, options).occluded.front() == 0);
}

TEST_CASE("library: a picture is the same on any number of threads, with its layers", "[library]") {
    const World world = hills("EPSG:3794");
    SceneText scene = small_scene();
    scene.fields.emplace_back("output.layers", "all");
    const Picture one = world.render(scene, 1);
    const Picture three = world.render(scene, 3);
    REQUIRE(one.width == 64);
    REQUIRE(one.height == 48);
    CHECK(one.rgb == three.rgb);
    CHECK(same_bits(one.light, three.light));
    CHECK(std::set<std::uint8_t>(one.rgb.begin(), one.rgb.end()).size() > 16);
    std::set<std::string> names;
    for (const Picture::Layer& layer : one.layers) {
        names.insert(layer.name);
        CHECK(layer.values.size() == 64 * 48 * layer.channels);
    }
    CHECK(names.contains("normal"));
    CHECK(names.contains("material"));
}

TEST_CASE("library: a scene's text and fields are both used", "[library]") {
    const World world = hills();
    SceneText scene;
    scene.toml = "[output]\nsize = \"32x16\"\n[quality]\nsamples = 1\n";
    CHECK(world.render(scene).width == 32);
    scene.fields = {{"output.size", "40x16"}};
    CHECK(world.render(scene).width == 40);
    scene.toml = "[output]\nsize = \"-1x16\"\n";
    scene.fields.clear();
    CHECK_THROWS_AS(world.render(scene), UsageError);
}

TEST_CASE("library: points of one's own are voxelized", "[library]") {
    SlopePoints points;
    const World world = World::voxelize(points);
    CHECK(world.info().crs == "EPSG:3794");
    const Raster surface = world.surface(MapBounds{462000, 101000, 462064, 101064, 0, 0});
    REQUIRE(surface.columns == 64);
    for (std::size_t column = 8; column < 56; ++column)
        CHECK(surface.bands.front().values[32 * 64 + column] ==
              static_cast<float>(301 + column / 4));
}

TEST_CASE("library: boxes that cannot be made are counted, never air", "[library]") {
    const auto source = std::make_shared<Hills>();
    const World world = World::of(source);
    source->fail();
    CHECK(world.surface().holes > 0);
    CHECK(std::isnan(world.surface().bands.front().values.front()));
    CHECK(world.voxels(world.block_of(std::nullopt)).holes > 0);
    const std::vector<double> origin{30, 30, 200};
    const std::vector<double> down{0, 0, -1};
    CHECK(world.cast(origin, down).holes == 1);
    CHECK(std::isnan(world.cast(origin, down).distance_m.front()));
    CHECK(world.occluded(origin, down).occluded.front() == 1);
    CHECK(world.render(small_scene()).holes > 0);
}

TEST_CASE("library: boxes that come back are read again", "[library]") {
    const auto source = std::make_shared<Hills>();
    const World world = World::of(source);
    const std::vector<double> origin{30, 30, 200};
    const std::vector<double> down{0, 0, -1};
    source->fail();
    REQUIRE(world.cast(origin, down).holes == 1);
    source->fail(false);
    CHECK(world.cast(origin, down).holes == 0);
    source->fail();
    source->fail(false);
    CHECK(world.surface().holes == 0);
}

TEST_CASE("library: areas of worlds without end are where they are asked for", "[library]") {
    const World world = World::open({"generated:7"});
    const MapBounds far{3000, -64, 3064, 0};
    const Raster surface = world.surface(far);
    CHECK(surface.bounds.west == 3000);
    CHECK(surface.columns == 64);
    CHECK(surface.rows == 64);
    CHECK(std::none_of(surface.bands.front().values.begin(), surface.bands.front().values.end(),
                       [](float v) { return std::isnan(v); }));
    AnalysisOptions options;
    options.kind = "terrain";
    options.area = far;
    CHECK(same_bits(world.analyse(options).bands.front().values, surface.bands.front().values));
    const double all = 1e9;
    CHECK_THROWS_AS(world.surface(MapBounds{-all, -all, all, all}), UsageError);
}

TEST_CASE("library: a call that is stopped ends with Stopped", "[library]") {
    const World world = hills();
    std::stop_source stop;
    stop.request_stop();
    Control control;
    control.stop = stop.get_token();
    CHECK_THROWS_AS(world.surface(std::nullopt, 0, 1, control), Stopped);
    CHECK_THROWS_AS(world.voxels(world.block_of(std::nullopt), 1, control), Stopped);
    CHECK_THROWS_AS(world.render(small_scene(), 1, control), Stopped);
    const std::vector<double> ray{0, 0, 1};
    CHECK_THROWS_AS(world.cast(ray, ray, {}, control), Stopped);
    CHECK_THROWS_AS(World::open({"generated:7"}, {}, control), Stopped);
    AnalysisOptions options;
    options.kind = "terrain";
    CHECK_THROWS_AS(world.analyse(options, control), Stopped);
    const std::filesystem::path out =
        std::filesystem::temp_directory_path() / "terravox_library_stopped.tvx";
    CHECK_THROWS_AS(world.convert(out.string(), {}, control), Stopped);
    CHECK(!std::filesystem::exists(out));
    // The world can be used afterwards.
    CHECK(world.surface().holes == 0);
}

TEST_CASE("library: progress is told until all is done", "[library]") {
    const World world = hills();
    std::uint64_t last = 0;
    std::uint64_t total = 1;
    Control control;
    control.progress = [&](std::uint64_t done, std::uint64_t of) {
        CHECK(done == last + 1);
        last = done;
        total = of;
    };
    (void)world.surface(std::nullopt, 0, 2, control);
    CHECK(last == total);
}

TEST_CASE("library: a conversion is read again as the same world", "[library]") {
    const std::filesystem::path out =
        std::filesystem::temp_directory_path() / "terravox_library_test.tvx";
    ConvertOptions options;
    options.overwrite = true;
    const World world = hills();
    const ConvertReport report = world.convert(out.string(), options);
    CHECK(report.holes == 0);
    REQUIRE(report.files.size() == 1);
    const World again = World::open({out.string()});
    const VoxelBlock block = world.block_of(std::nullopt);
    CHECK(again.voxels(block).materials == world.voxels(block).materials);
    options.overwrite = false;
    CHECK_THROWS_AS(world.convert(out.string(), options), UsageError);
    std::filesystem::remove(out);
}

#ifdef TERRAVOX_VDB
TEST_CASE("library: the module of OpenVDB is found from the library, not from the program",
          "[library]") {
    const std::filesystem::path out =
        std::filesystem::temp_directory_path() / "terravox_library_test.vdb";
    ConvertOptions options;
    options.overwrite = true;
    const ConvertReport report = hills().convert(out.string(), options);
    REQUIRE(report.files.size() == 2);
    for (const std::string& file : report.files)
        CHECK(std::filesystem::remove(file));
}
#endif

TEST_CASE("library: requests that make no sense are refused", "[library]") {
    const World world = hills();
    const std::vector<double> ray{0, 0, 1};
    const std::vector<double> nothing{0, 0, 0};
    const std::vector<double> endless{0, std::numeric_limits<double>::infinity(), 0};
    const std::vector<double> half{0, 0};
    CHECK_THROWS_AS(world.cast(ray, nothing), UsageError);
    CHECK_THROWS_AS(world.cast(endless, ray), UsageError);
    CHECK_THROWS_AS(world.cast(half, half), UsageError);
    CHECK_THROWS_AS(world.cast(ray, half), UsageError);
    CastOptions backwards;
    backwards.range_m = -1;
    CHECK_THROWS_AS(world.cast(ray, ray, backwards), UsageError);
    CHECK_THROWS_AS(world.surface(std::nullopt, 99), UsageError);
    CHECK_THROWS_AS(world.surface(MapBounds{500, 500, 600, 600, 0, 0}), UsageError);
    CHECK_THROWS_AS(world.block_of(std::nullopt, -1), UsageError);
    CHECK_THROWS_AS(world.voxels({0, {0, 0, 0}, {0, 1, 1}}), UsageError);
    CHECK_THROWS_AS(world.voxels({0, {-100000, 0, -100000}, {100000, 256, 100000}}), UsageError);
    AnalysisOptions options;
    options.kind = "gravity";
    CHECK_THROWS_AS(world.analyse(options), UsageError);
    options.kind = "sight";
    CHECK_THROWS_AS(world.analyse(options), UsageError);
    CHECK_THROWS_AS(World::open({"/nowhere/at/all"}), UsageError);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(world.surface(MapBounds{nan, -1, 1, 1}), UsageError);
    CHECK_THROWS_AS(world.block_of(MapBounds{-1, -1, 1, nan}), UsageError);
    const std::int32_t most = std::numeric_limits<std::int32_t>::max();
    CHECK_THROWS_AS(world.voxels({1, {0, 0, 0}, {most, 1, 1}}), UsageError);
    CHECK_THROWS_AS(world.surface(std::nullopt, 0, -1), UsageError);
    CHECK_THROWS_AS(world.render(small_scene(), 100'000), UsageError);
    OpenOptions elsewhere;
    elsewhere.fields = {{"sun.date", "2026-06-21"}};
    CHECK_THROWS_AS(World::open({"generated:7"}, elsewhere), UsageError);
    OpenOptions with_crs;
    with_crs.crs = "EPSG:3794";
    CHECK_THROWS_AS(World::of(std::make_shared<Hills>(), with_crs), UsageError);
    CHECK_THROWS_AS(World::of(nullptr), UsageError);
    CHECK_THROWS_AS(World::of(std::make_shared<Hills>("EPSG:4326")), UsageError);
    CHECK_THROWS_AS(make_survey({"", 7, 8, 1, 1, 1000, 0}), UsageError);
    CHECK_THROWS_AS(make_survey({"/tmp/never", 7, 8, 1, 1, 70, 0}), UsageError);
    CHECK_THROWS_AS(set_log_level("loud"), UsageError);
}
