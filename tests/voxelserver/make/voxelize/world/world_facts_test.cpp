#include <chrono>
#include <fstream>
#include <random>
#include <set>

#include "common/util/error.hpp"
#include "common/voxel/fingerprint.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "tests/voxelserver/make/voxelize/world/patchwork.hpp"
#include "voxelserver/make/voxelize/points/sources.hpp"
#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;
namespace fs = std::filesystem;

namespace {

bool same_info(const voxel::WorldInfo& a, const voxel::WorldInfo& b) {
    const bool centre = a.centre.has_value() == b.centre.has_value() &&
                        (!a.centre || (a.centre->lat_deg == b.centre->lat_deg &&
                                       a.centre->lon_deg == b.centre->lon_deg &&
                                       a.centre->convergence_deg == b.centre->convergence_deg));
    return a.title == b.title && a.bounds == b.bounds && a.voxel_m == b.voxel_m &&
           a.levels == b.levels && a.crs == b.crs && a.crs_wkt == b.crs_wkt &&
           a.crs_units_per_voxel == b.crs_units_per_voxel && centre && a.licence == b.licence &&
           a.attribution == b.attribution && a.typical_heights == b.typical_heights;
}

}  // namespace

TEST_CASE("facts that were kept answer as the opened world does",
          "[voxelserver][voxelize][facts]") {
    Patchwork patchwork;
    patchwork.image("west.tif", 0, 0, 90, 200, {90, 160, 60});
    OpenWorld opened(patchwork.options());
    voxelize::LidarWorld& world = opened.world();
    CHECK_FALSE(world.info().typical_heights);
    const voxelize::WorldFacts facts =
        voxelize::facts_from_bytes(voxelize::to_bytes(world.facts()));
    CHECK(same_info(facts.info, world.info()));
    CHECK(facts.orthophotos == 1);
    CHECK(facts.water_cell_m == world.stats().water_cell_m);
    const auto squares = world.squares();
    REQUIRE(squares.size() == 6);
    REQUIRE(facts.squares.size() == 6);
    for (std::size_t i = 0; i < 6; ++i) {
        CHECK(facts.squares[i].name == "s" + std::to_string(i));
        CHECK(facts.squares[i].file == squares[i].file);
        CHECK(facts.squares[i].points == squares[i].points);
        CHECK(facts.squares[i].bytes == fs::file_size(squares[i].file));
        CHECK(facts.squares[i].bounds.max_x == squares[i].bounds.max_x);
    }
    const auto range = voxel::boxes_over(world.info().bounds, 0);
    std::mt19937 random(9);
    const auto near = [&](std::int32_t from, std::int32_t to) {
        return from - 6 +
               static_cast<std::int32_t>(random() % static_cast<unsigned>(to - from + 12));
    };
    std::set<voxel::Fingerprint> fingerprints;
    for (int i = 0; i < 2000; ++i) {
        const int level = static_cast<int>(random() % static_cast<unsigned>(world.info().levels));
        const std::int32_t bx = near(range.min.bx, range.max.bx) >> level;
        const std::int32_t bz = near(range.min.bz, range.max.bz) >> level;
        const voxel::InputExtent reach{bx, bz, bx + 1 + static_cast<std::int32_t>(random() % 4),
                                       bz + 1 + static_cast<std::int32_t>(random() % 4)};
        INFO("level " << level << ", " << bx << ", " << bz);
        CHECK(facts.column(level, bx, bz) == world.column(level, bx, bz));
        CHECK((facts.fingerprint(reach) == world.fingerprint(reach)));
        fingerprints.insert(facts.fingerprint(reach));
    }
    CHECK(fingerprints.size() > 6);
    for (const int level : {-1, world.info().levels})
        CHECK_THROWS_AS(facts.column(level, 0, 0), util::UsageError);
}

TEST_CASE("bytes that are no facts are refused", "[voxelserver][voxelize][facts]") {
    Patchwork patchwork;
    OpenWorld opened(patchwork.options());
    const std::string good = voxelize::to_bytes(opened.world().facts());
    CHECK_NOTHROW(voxelize::facts_from_bytes(good));
    CHECK_THROWS_AS(voxelize::facts_from_bytes(""), util::Error);
    CHECK_THROWS_AS(voxelize::facts_from_bytes("TVFACTS3"), util::Error);
    CHECK_THROWS_AS(voxelize::facts_from_bytes("TVFACTS2" + good.substr(8)), util::Error);
    CHECK_THROWS_AS(voxelize::facts_from_bytes(good + "x"), util::Error);
    std::mt19937 random(4);
    for (std::size_t cut = 0; cut < good.size(); cut += 1 + random() % 40) {
        INFO("cut to " << cut << " bytes");
        CHECK_THROWS_AS(voxelize::facts_from_bytes(good.substr(0, cut)), util::Error);
    }
    for (int i = 0; i < 500; ++i) {
        std::string bad = good;
        const std::size_t at = random() % bad.size();
        bad[at] = static_cast<char>(bad[at] ^ (1 + random() % 255));
        INFO("byte " << at);
        CHECK_THROWS_AS(voxelize::facts_from_bytes(bad), util::Error);
    }
}

TEST_CASE("bytes with a right checksum that lie about their lengths are refused",
          "[voxelserver][voxelize][facts]") {
    Patchwork patchwork;
    OpenWorld opened(patchwork.options());
    const std::string good = voxelize::to_bytes(opened.world().facts());
    constexpr std::size_t kHead = 8 + 16 + 4;
    std::mt19937 random(11);
    int refused = 0;
    for (int i = 0; i < 2000; ++i) {
        std::string body = good.substr(kHead);
        for (unsigned n = 1 + random() % 3; n > 0; --n)
            body[random() % body.size()] = static_cast<char>(random() % 256);
        const voxel::Fingerprint print = voxel::to_fingerprint(body);
        std::string bad = good.substr(0, 8);
        bad.append(reinterpret_cast<const char*>(print.data()), sizeof print);
        bad += good.substr(24, 4) + body;
        try {
            const voxelize::WorldFacts facts = voxelize::facts_from_bytes(bad);
            CHECK(facts.squares.size() <= good.size());
            static_cast<void>(facts.column(facts.info.levels - 1, 0, 0));
            static_cast<void>(facts.fingerprint({0, 0, 1, 1}));
        } catch (const util::Error&) {
            ++refused;
        }
    }
    CHECK(refused > 100);
}

TEST_CASE("the name of a world changes with everything that opening it reads",
          "[voxelserver][voxelize][facts]") {
    struct Case {
        const char* name;
        Change change;
        bool other;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing", [](Patchwork&, Options&) {}, false},
        {"memory, threads, cache folder",
         [](Patchwork& p, Options& o) {
             o.memory_bytes = 1;
             o.threads = 3;
             o.cache_dir = p.root() / "c";
         },
         false},
        {"settings in other words", settings("# nothing\n"), false},
        {"a setting", settings("[ground]\nsoil_m = 2\n"), true},
        {"classes", [](Patchwork&, Options& o) { o.classes = "nl-ahn"; }, true},
        {"classes by themselves", [](Patchwork&, Options& o) { o.classes = kAnyClassTable; }, true},
        {"unknown classes", [](Patchwork&, Options& o) { o.mark_unknown = true; }, true},
        {"voxels", [](Patchwork&, Options& o) { o.voxel_m = 2; }, true},
        {"the CRS", [](Patchwork&, Options& o) { o.crs = "EPSG:2154"; }, true},
        {"the vertical unit", [](Patchwork&, Options& o) { o.vertical_unit = "m"; }, true},
        {"a point", in_square(3, [](Cloud::Point& at) { at.height += 1; }), true},
        {"a time",
         [](Patchwork& p, Options&) {
             fs::last_write_time(p.square(1),
                                 fs::last_write_time(p.square(1)) + std::chrono::seconds(1));
         },
         true},
        {"a square more", in_square(6, {}), true},
        {"a square less", without("lidar/s2.las"), true},
        {"a square's name",
         [](Patchwork& p, Options&) { fs::rename(p.square(2), p.folder() / "t2.las"); }, true},
        {"an image", image("west.tif", {0, 0, 90, 200}, {91, 160, 60}), true},
        {"no image", [](Patchwork&, Options& o) { o.orthophotos.clear(); }, true},
        {"an image's world file", with_file("images/west.tfw", "1\n0\n0\n-1\n0\n0\n"), true},
        {"a file that is not read", with_file("images/notes.txt", "x"), false},
    }));
    static const Patchwork kBefore = [] {
        Patchwork out;
        out.image("west.tif", 0, 0, 90, 200, {90, 160, 60});
        return out;
    }();
    DYNAMIC_SECTION(c.name) {
        Patchwork patchwork(kBefore);
        Options options = patchwork.options();
        const std::string before = voxelize::world_name(options);
        CHECK(before.size() == 32);
        CHECK(before.find_first_not_of("0123456789abcdef") == std::string::npos);
        c.change(patchwork, options);
        CHECK((voxelize::world_name(options) != before) == c.other);
    }
}

TEST_CASE("the name of a world changes with what opens it", "[voxelserver][voxelize][facts]") {
    Patchwork patchwork;
    const auto options = patchwork.options();
    const fs::path module = patchwork.root() / "module";
    std::ofstream(module) << "one";
    const std::string before = voxelize::world_name(options, module);
    CHECK(before == voxelize::world_name(options, module));
    CHECK(before != voxelize::world_name(options));
    std::ofstream(module) << "two";
    CHECK(before != voxelize::world_name(options, module));
    fs::remove(module);
    CHECK_THROWS_AS(voxelize::world_name(options, module), util::Error);
}

TEST_CASE("worlds without a name say why", "[voxelserver][voxelize][facts]") {
    const TemporaryFolder folder;
    voxelize::LidarWorldOptions options;
    CHECK_THROWS_AS(voxelize::world_name(options), util::UsageError);
    options.files = {folder.path() / "none.laz"};
    CHECK_THROWS_AS(voxelize::world_name(options), util::UsageError);
    options.files = {folder.path()};
    CHECK_THROWS_AS(voxelize::world_name(options), util::UsageError);
}

TEST_CASE("the fingerprint of all boxes is another for another frame, water, bed and lowest box",
          "[voxelserver][voxelize][fingerprint]") {
    const geo::Crs crs = geo::Crs::from_text(kCrs);
    Sources sources{.frame = grid::Frame(crs, 1, 0, 0),
                    .files = {},
                    .bounds = {},
                    .typical_heights = {},
                    .named_squares = {},
                    .known_before = {},
                    .known = {}};
    const ClassTable classes;
    const Settings settings;
    int cell_voxels = 4;
    const auto fingerprint = [&] {
        return fingerprint_everywhere(sources, classes, settings, cell_voxels);
    };
    const voxel::Fingerprint before = fingerprint();
    sources.highest_y = 7;
    sources.lowest_y = 3;
    CHECK(fingerprint() == before);
    SECTION("the size of a voxel") {
        sources.frame = grid::Frame(crs, 0.5, 0, 0);
    }
    SECTION("points of water") {
        sources.has_water_class = true;
    }
    SECTION("from where the terrain is solid") {
        sources.floor_y = -1;
    }
    SECTION("the lowest box") {
        sources.lowest_y = -1;
    }
    SECTION("cells of water") {
        cell_voxels = 8;
    }
    CHECK_FALSE(fingerprint() == before);
}
