// Many callers at once, with hardly any memory, while files are being loaded.
// What a second world over the same cache folder does.
// Files of which only parts are decoded: the voxels must be those of the whole.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <random>
#include <thread>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/strip.hpp"
#include "tests/voxelserver/data/store/timed_world.hpp"
#include "voxelserver/data/lidar/las_file.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// Four files that meet in one point.
void write_four(const fs::path& folder) {
    for (int i = 0; i < 4; ++i)
        hills().write(folder / (std::to_string(i) + ".laz"), kCrs, 6, [&](const Cloud::Point& p) {
            return (p.east < 81.3) == ((i & 1) != 0) && (p.north < 69.6) == ((i & 2) != 0);
        });
}

/// Requests all boxes from `count` threads, each in an order of its own.
/// @return how many results were wrong
int count_wrong(TimedWorld& world, const Checksums& wanted, unsigned count) {
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < count; ++t)
        threads.emplace_back([&, t] {
            try {
                wrong += world.boxes(t + 1) == wanted ? 0 : 1;
            } catch (const std::exception&) {
                ++wrong;
            }
        });
    for (auto& t : threads)
        t.join();
    return wrong;
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
};

const fs::path kCopc = fs::path(TERRAVOX_SHARED_DATA) / "copcjs" / "ellipsoid.copc.laz";

/// A cache folder in which only the chunk index of a file is left.
void leave_index(const fs::path& file, const fs::path& cache) {
    auto options = OpenWorld::with(file);
    options.cache_dir = cache;
    TimedWorld world(options);
    (void)world->box(all_keys(world->info(), 0).front());
    for (const auto& square : files_ending(cache / "squares", ".square"))
        fs::remove(square);
    REQUIRE(files_ending(cache / "squares", ".chunks").size() == 1);
}

}  // namespace

TEST_CASE("eight threads with little memory and room on disk get the boxes that one gets with much",
          "[voxelserver][store][threads]") {
    const TemporaryFolder folder;
    write_four(folder.path() / "data");
    const Checksums wanted = TimedWorld(OpenWorld::with(folder.path() / "data")).boxes();
    REQUIRE(solid_boxes(wanted) >= 9);
    auto options = OpenWorld::with(folder.path() / "data");
    options.memory_bytes = 420'000;  // one square of four
    options.cache_dir = folder.path() / "cache";
    options.cache_bytes = 260'000;  // two
    for (int round = 0; round < 2; ++round) {
        TimedWorld world(options);
        CHECK(count_wrong(world, wanted, 8) == 0);
    }
    CHECK(bytes_in(options.cache_dir / "squares") <= options.cache_bytes);
}

TEST_CASE("callers may be tasks of a thread pool themselves", "[voxelserver][store][threads]") {
    const TemporaryFolder folder;
    write_four(folder.path() / "data");
    const Checksums wanted = TimedWorld(OpenWorld::with(folder.path() / "data")).boxes();
    auto options = OpenWorld::with(folder.path() / "data");
    options.memory_bytes = 1;
    TimedWorld world(options);
    const auto keys = all_keys(world->info(), 0);
    std::atomic<int> wrong{0};
    // Each box four times, so that some wait for others that decode within the same pool.
    thread::parallel_for(keys.size() * 4, 6, [&](std::size_t i) {
        const auto& key = keys[i % keys.size()];
        const auto box = world->box(key);
        wrong += (box ? box->checksum() : 0) == wanted.at(key) ? 0 : 1;
    });
    CHECK(wrong == 0);
}

TEST_CASE(
    "when a file goes bad while eight threads wait for it, each gets the error and none hangs",
    "[voxelserver][store][threads]") {
    const TemporaryFolder folder;
    write_four(folder.path() / "data");
    TimedWorld world(OpenWorld::with(folder.path() / "data"));
    const fs::path bad = folder.path() / "data" / "2.laz";
    fs::resize_file(bad, fs::file_size(bad) / 2);
    const auto keys = all_keys(world->info(), 0);
    std::atomic<int> errors{0};
    std::atomic<int> other{0};
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < 8; ++t)
        threads.emplace_back([&, t] {
            auto order = keys;
            std::shuffle(order.begin(), order.end(), std::mt19937(t));
            for (const auto& key : order) {
                try {
                    (void)world->box(key);
                } catch (const util::Error&) {
                    ++errors;
                } catch (...) {
                    ++other;
                }
            }
        });
    for (auto& t : threads)
        t.join();
    CHECK(other == 0);
    CHECK(errors >= 8);
}

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
    TimedWorld second(place.options());
    CHECK((second.boxes(3) == plain));
    CHECK(second.count("point load") == 0);
    CHECK(second->stats().outliers == TimedWorld(place.options(false))->stats().outliers);
    CHECK(place.squares().size() == 2);
}

// What else shapes them is in the name of a square: file_plan_test and square_file_test.
TEST_CASE("what shapes the points makes squares of another name, what does not uses them",
          "[voxelserver][store][restart]") {
    const Place place;
    TimedWorld(place.options()).boxes();
    REQUIRE(place.squares().size() == 2);
    const auto check = [&](std::size_t decoded, const auto& change) {
        auto cached = place.options();
        auto plain = place.options(false);
        change(cached);
        change(plain);
        TimedWorld world(cached);
        CHECK((world.boxes() == TimedWorld(plain).boxes()));
        CHECK((world.count("point load") > 0) == (decoded > 0));
        CHECK(place.squares().size() == 2 + decoded);
    };
    SECTION("withheld points kept") {
        const auto file = place.text("s.toml", "[points]\ndrop_withheld = false\n");
        check(2, [&](auto& o) { o.settings = file; });
    }
    SECTION("other steps") {
        const auto file = place.text("s.toml", "[steps]\nvegetation = false\n");
        check(0, [&](auto& o) { o.settings = file; });
    }
}

TEST_CASE("voxel sizes that differ in the seventh digit share no squares",
          "[voxelserver][store][restart]") {
    const TemporaryFolder folder;
    Cloud field;
    field.cover(0, 0, 20, 20, 0.5, 2, [](double, double) { return 100.5; });
    field.write(folder.path() / "a.laz");
    auto options = OpenWorld::with(folder.path() / "a.laz");
    options.cache_dir = folder.path() / "cache";
    options.voxel_m = 0.3333333;
    TimedWorld(options).boxes();
    options.voxel_m = 0.3333334;
    TimedWorld cached(options);
    options.cache_dir.clear();
    CHECK((cached.boxes() == TimedWorld(options).boxes()));
    CHECK(files_ending(folder.path() / "cache" / "squares", ".square").size() == 2);
}

TEST_CASE("chunk indices that another world has kept spare most of a file, where they are read",
          "[voxelserver][store][parts]") {
    const Strip& strip = Strip::get();
    REQUIRE(strip.stretches >= 6);
    REQUIRE(solid_boxes(strip.boxes) >= 40);
    const TemporaryFolder kept;
    auto options = OpenWorld::with(strip.sorted);
    options.chunk_indices = kept.path();
    const auto one_box = [&] {
        TimedWorld world(options);
        const auto keys = all_keys(world->info(), 0);
        const auto middle = keys[keys.size() / 2];
        const auto box = world->box(middle);
        CHECK((box ? box->checksum() : 0) == strip.boxes.at(middle));
        return world.count("point load");
    };
    CHECK(one_box() == strip.stretches);
    CHECK(files_ending(kept.path(), ".chunks").size() == 1);
    CHECK(one_box() == strip.stretches);
    options.reads_chunk_indices = true;
    const auto some = one_box();
    CHECK(some >= 1);
    CHECK(some <= strip.stretches / 2);
    CHECK((TimedWorld(options).boxes(3) == strip.boxes));
    const fs::path index = files_ending(kept.path(), ".chunks").front();
    const std::string bytes = read_content(index);
    write_bytes(index, bytes.substr(0, bytes.size() / 2));
    CHECK(one_box() == strip.stretches);
    CHECK(read_content(index) == bytes);
}

TEST_CASE("a file in which every part lies everywhere gives the same boxes",
          "[voxelserver][store][parts]") {
    const Strip& strip = Strip::get();
    const Checksums whole = TimedWorld(OpenWorld::with(strip.mixed)).boxes();
    const TemporaryFolder cache;
    leave_index(strip.mixed, cache.path());
    auto options = OpenWorld::with(strip.mixed);
    options.cache_dir = cache.path();
    TimedWorld world(options);
    CHECK((world.boxes(5) == whole));
    CHECK(world.count("point load") <= 3 * strip.stretches);
}

TEST_CASE("a COPC file makes the same boxes through its hierarchy, in parts and whole",
          "[voxelserver][store][parts][data]") {
    if (!fs::exists(kCopc)) {
        WARN("skipped: " << kCopc.string() << " is not there");
        return;
    }
    auto copc = OpenWorld::with(kCopc);
    copc.voxel_m = 0.5;  // so that the thing is more than a few boxes
    if (!lidar::read_las_info(kCopc).crs)
        copc.crs = kCrs;
    // Ground far from any point is looked for far around, which takes long where no memory is left
    // to remember it.
    const TemporaryFolder folder;
    copc.settings = folder.path() / "settings.toml";
    write_bytes(copc.settings, "[steps]\nground_fill = false\n");
    const Checksums wanted = TimedWorld(copc).boxes();
    CHECK(solid_boxes(wanted) > 4);
    copc.memory_bytes = 1;
    TimedWorld world(copc);
    CHECK((world.boxes(3) == wanted));
}
