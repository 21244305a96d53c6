// Many callers at once, with hardly any memory, while files are being loaded.
#include <atomic>
#include <thread>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/timed_world.hpp"

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
