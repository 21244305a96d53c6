// What a second world over the same cache folder does.
#include <chrono>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/store/squares.hpp"
#include "tests/voxelserver/store/timed_world.hpp"
#include "tests/voxelserver/store/warnings.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// Hills with a road, trees and noise, in two files, 150 x 130 m.
const Cloud& hills() {
    static const Cloud made = [] {
        Cloud cloud;
        std::mt19937 random(12);
        const auto unit = [&] { return static_cast<double>(random() % 100'000) / 100'000; };
        for (int i = 0; i < 60'000; ++i) {
            const double e = 0.05 + unit() * 149.9;
            const double n = 0.05 + unit() * 129.9;
            const double ground = 200 + 6 * std::sin(e / 31) + 4 * std::cos(n / 17);
            cloud.add(e, n, ground, n > 60 && n < 66 ? 11 : 2);
            if (i % 3 == 0 && std::sin(e / 6) * std::sin(n / 6) > 0.6)
                cloud.add(e, n, ground + 2 + unit() * 9, 5);
            if (i % 50 == 0)
                cloud.add(e, n, ground + 40, 7);
        }
        return cloud;
    }();
    return made;
}

/// Two files and a cache folder that lasts for one test.
struct Place {
    TemporaryFolder folder;
    fs::path west = folder.path() / "data" / "west.laz";
    fs::path east = folder.path() / "data" / "east.laz";
    fs::path cache = folder.path() / "cache";
    Place() {
        hills().write(west, kCrs, 6, [](const Cloud::Point& p) { return p.east < 80; });
        hills().write(east, kCrs, 6, [](const Cloud::Point& p) { return p.east >= 80; });
    }
    [[nodiscard]] voxelize::LidarWorldOptions options(bool cached = true) const {
        auto out = OpenWorld::with(folder.path() / "data");
        if (cached)
            out.cache_dir = cache;
        return out;
    }
    [[nodiscard]] std::vector<fs::path> squares() const {
        return files_ending(cache / "squares", ".square");
    }
    fs::path text(const char* name, const std::string& content) const {
        write_bytes(folder.path() / name, content);
        return folder.path() / name;
    }
    /// The ASPRS table with another meaning of roads.
    std::string classes(const std::string& road) const {
        std::string table =
            bytes_of(fs::path(TERRAVOX_SOURCE_DIR) / "config" / "classes" / "asprs.toml");
        const std::string before = "\n11 = ";
        const auto at = table.find(before) + before.size();
        REQUIRE(at > before.size());
        table.replace(at, table.find('}', at) + 1 - at, road);
        return text("t.toml", table).string();
    }
};

}  // namespace

TEST_CASE("a second world over the same cache folder decodes nothing and makes the same boxes",
          "[voxelserver][store][restart]") {
    const Place place;
    const Checksums plain = TimedWorld(place.options(false)).boxes();
    REQUIRE(solid_boxes(plain) >= 9);
    {
        TimedWorld first(place.options());
        CHECK((first.boxes() == plain));
        CHECK(first.count("point load") > 0);
        CHECK(place.squares().size() == 2);
    }
    const unsigned shuffle = GENERATE(0U, 3U);
    TimedWorld second(place.options());
    CHECK((second.boxes(shuffle) == plain));
    CHECK(second.count("point load") == 0);
    CHECK(second->stats().outliers == TimedWorld(place.options(false))->stats().outliers);
    CHECK(place.squares().size() == 2);
}

TEST_CASE("what shapes the points makes squares of another name, what does not uses them",
          "[voxelserver][store][restart]") {
    const Place place;
    TimedWorld(place.options()).boxes();
    REQUIRE(place.squares().size() == 2);
    struct Case {
        const char* name;
        std::size_t decoded;
        std::function<void(const Place&, voxelize::LidarWorldOptions&)> change;
    };
    const auto c = GENERATE(values<Case>({
        {"another voxel size", 2, [](const Place&, auto& o) { o.voxel_m = 0.5; }},
        {"another unit of heights", 2, [](const Place&, auto& o) { o.vertical_unit = "ft"; }},
        {"another system", 2, [](const Place&, auto& o) { o.crs = "EPSG:32631"; }},
        {"a class table that drops roads", 2,
         [](const Place& p, auto& o) { o.classes = p.classes("{ role = \"drop\" }"); }},
        {"withheld points kept", 2,
         [](const Place& p, auto& o) {
             o.settings = p.text("s.toml", "[points]\ndrop_withheld = false\n");
         }},
        {"overlap dropped", 2,
         [](const Place& p, auto& o) {
             o.settings = p.text("s.toml", "[points]\ndrop_overlap = true\n");
         }},
        {"a file that was touched", 1,
         [](const Place& p, auto&) {
             fs::last_write_time(p.west, fs::last_write_time(p.west) + std::chrono::seconds(5));
         }},
        {"a file with another point", 1,
         [](const Place& p, auto&) {
             Cloud more = hills();
             more.add(20.5, 20.5, 230, 15);
             more.write(p.west, kCrs, 6, [](const Cloud::Point& q) { return q.east < 80; });
         }},
        {"a class table that drops the same", 0,
         [](const Place& p, auto& o) {
             o.classes = p.classes("{ role = \"ground\", material = \"rail\" }");
         }},
        {"other steps", 0,
         [](const Place& p, auto& o) {
             o.settings = p.text("s.toml", "[steps]\nvegetation = false\n");
         }},
        {"other threads and memory", 0,
         [](const Place&, auto& o) { o.threads = 1, o.memory_bytes = std::size_t{1} << 30; }},
    }));
    DYNAMIC_SECTION(c.name) {
        auto cached = place.options();
        auto plain = place.options(false);
        c.change(place, cached);
        c.change(place, plain);
        const Checksums wanted = TimedWorld(plain).boxes();
        TimedWorld world(cached);
        CHECK((world.boxes() == wanted));
        CHECK((world.count("point load") > 0) == (c.decoded > 0));
        CHECK(place.squares().size() == 2 + c.decoded);
    }
}

// The voxels of two such worlds lie apart: 0.0000001 of 0.3333333 m is 2 m at 6,277 km from the
// origin.
TEST_CASE("voxel sizes that differ in the seventh digit share no squares",
          "[voxelserver][store][restart]") {
    const Place place;
    auto options = place.options();
    options.voxel_m = 0.3333333;
    TimedWorld(options).boxes();
    options.voxel_m = 0.3333334;
    TimedWorld cached(options);
    options.cache_dir.clear();
    CHECK((cached.boxes() == TimedWorld(options).boxes()));
    CHECK(place.squares().size() == 4);
}

TEST_CASE("a damaged square on disk is reported, made again and replaced",
          "[voxelserver][store][restart][damage]") {
    const Place place;
    const Checksums wanted = TimedWorld(place.options()).boxes();
    struct Case {
        const char* name;
        std::function<void(std::string&)> damage;
    };
    const auto c = GENERATE(values<Case>({
        {"wrong magic", [](std::string& b) { b[0] = 'X'; }},
        {"another version", [](std::string& b) { b[8] = 99; }},
        {"header", [](std::string& b) { b[30] ^= 1; }},
        {"directory", [](std::string& b) { b[2150] ^= 1; }},
        {"cut in the header", [](std::string& b) { b.resize(100); }},
        {"cut in the points", [](std::string& b) { b.resize(b.size() / 2); }},
        {"empty", [](std::string& b) { b.clear(); }},
        {"a point", [](std::string& b) { b[b.size() - 1000] ^= 1; }},
        {"every point",
         [](std::string& b) {
             for (std::size_t i = b.size() / 4; i < b.size(); i += 12)
                 b[i] ^= 1;
         }},
    }));
    DYNAMIC_SECTION(c.name) {
        const fs::path bad = place.squares().at(0);
        const std::string good = bytes_of(bad);
        std::string bytes = good;
        c.damage(bytes);
        write_bytes(bad, bytes);
        {
            const Warnings warnings;
            TimedWorld world(place.options());
            CHECK((world.boxes(9) == wanted));
            CHECK(world.count("point load") > 0);
            INFO(warnings.text());
            CHECK(warnings.count("made again") == 1);
        }
        CHECK((bytes_of(bad) == good));
        TimedWorld after(place.options());
        CHECK((after.boxes() == wanted));
        CHECK(after.count("point load") == 0);
    }
}

TEST_CASE("a world without a usable cache folder works from memory, with one warning",
          "[voxelserver][store][restart]") {
    const Place place;
    auto options = place.options();
    options.cache_dir = place.text("plain", "text") / "below";
    const Warnings warnings;
    TimedWorld world(options);
    CHECK((world.boxes() == TimedWorld(place.options(false)).boxes()));
    CHECK(warnings.count("plain") == 1);
}

TEST_CASE("a cache folder with room for one square of two keeps its limit and changes no voxel",
          "[voxelserver][store][restart]") {
    const Place place;
    const Checksums wanted = TimedWorld(place.options()).boxes();
    std::uint64_t largest = 0;
    for (const auto& file : place.squares())
        largest = std::max<std::uint64_t>(largest, fs::file_size(file));
    auto options = place.options();
    options.cache_dir = place.folder.path() / "small";
    options.cache_bytes = largest + 10'000;
    for (const std::size_t memory : {std::size_t{4} << 30, std::size_t{1}}) {
        options.memory_bytes = memory;
        TimedWorld world(options);
        CHECK((world.boxes(4) == wanted));
        CHECK(bytes_in(options.cache_dir / "squares") <= options.cache_bytes);
    }
}
