// Many callers at once, with hardly any memory, while files are being loaded.
#include <atomic>
#include <thread>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/store/squares.hpp"
#include "tests/voxelserver/store/timed_world.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// Four files that meet in one point, 160 x 160 m.
void write_four(const fs::path& folder) {
    Cloud cloud;
    std::mt19937 random(4);
    const auto unit = [&] { return static_cast<double>(random() % 100'000) / 100'000; };
    for (int i = 0; i < 60'000; ++i) {
        const double e = 160 * unit();
        const double n = 160 * unit();
        const bool lake = std::hypot(e - 80, n - 80) < 25;
        cloud.add(e, n, lake ? 95 : 100 + 5 * std::sin(e / 20) + 3 * std::cos(n / 15),
                  lake ? 9 : 2);
        if (i % 4 == 0 && !lake)
            cloud.add(e, n, 108 + 4 * unit(), 5);
    }
    for (int i = 0; i < 4; ++i) {
        const auto mine = [&](const Cloud::Point& p) {
            return (p.east < 81.3) == ((i & 1) != 0) && (p.north < 79.6) == ((i & 2) != 0);
        };
        cloud.write(folder / (std::to_string(i) + ".laz"), kCrs, 6, mine);
    }
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

}  // namespace

TEST_CASE("eight threads with little memory get the boxes that one gets with much",
          "[voxelserver][store][threads]") {
    const TemporaryFolder folder;
    write_four(folder.path() / "data");
    const Checksums wanted = TimedWorld(OpenWorld::with(folder.path() / "data")).boxes();
    REQUIRE(solid_boxes(wanted) >= 9);
    struct Case {
        const char* name;
        std::size_t memory_bytes;
        std::uint64_t cache_bytes;
        bool cached;
    };
    const auto c =
        GENERATE(values<Case>({{"no memory", 1, 0, false},
                               {"one square of four", 700'000, 0, false},
                               {"one square of four, room on disk for two", 700'000, 450'000, true},
                               {"all squares on disk", 700'000, std::uint64_t{1} << 30, true},
                               {"no memory, a cache folder", 1, std::uint64_t{1} << 30, true}}));
    DYNAMIC_SECTION(c.name) {
        auto options = OpenWorld::with(folder.path() / "data");
        options.memory_bytes = c.memory_bytes;
        if (c.cached) {
            options.cache_dir = folder.path() / "cache";
            options.cache_bytes = c.cache_bytes;
        }
        for (int round = 0; round < 2; ++round) {
            TimedWorld world(options);
            CHECK(count_wrong(world, wanted, 8) == 0);
        }
        if (c.cached)
            CHECK(bytes_in(options.cache_dir / "squares") <= c.cache_bytes);
    }
}

TEST_CASE("callers may be tasks of a thread pool themselves", "[voxelserver][store][threads]") {
    const TemporaryFolder folder;
    write_four(folder.path() / "data");
    const Checksums wanted = TimedWorld(OpenWorld::with(folder.path() / "data")).boxes();
    auto options = OpenWorld::with(folder.path() / "data");
    options.memory_bytes = GENERATE(std::size_t{1}, std::size_t{700'000}, std::size_t{1} << 30);
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

TEST_CASE("two worlds over one cache folder at the same time do not disturb each other",
          "[voxelserver][store][threads]") {
    const TemporaryFolder folder;
    write_four(folder.path() / "data");
    const Checksums wanted = TimedWorld(OpenWorld::with(folder.path() / "data")).boxes();
    auto options = OpenWorld::with(folder.path() / "data");
    options.cache_dir = folder.path() / "cache";
    options.cache_bytes = GENERATE(std::uint64_t{450'000}, std::uint64_t{1} << 30);
    TimedWorld one(options), two(options);
    int wrong = 0;
    std::thread other([&] { wrong = count_wrong(one, wanted, 3); });
    CHECK(count_wrong(two, wanted, 3) == 0);
    other.join();
    CHECK(wrong == 0);
    CHECK(bytes_in(options.cache_dir / "squares") <= options.cache_bytes);
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
