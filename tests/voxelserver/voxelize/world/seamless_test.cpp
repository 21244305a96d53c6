#include <algorithm>
#include <random>
#include <thread>

#include "common/voxel/downsample.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// A bit of everything, 200 x 180 m: slopes, gaps, a lake, houses, trees.
const Cloud& mixture() {
    static const Cloud made = [] {
        Cloud cloud;
        std::mt19937 random(77);
        const auto unit = [&] { return static_cast<double>(random() % 100'000) / 100'000; };
        const auto ground = [](double e, double n) {
            return 300 + 8 * std::sin(e / 37) + 6 * std::cos(n / 23);
        };
        const auto lake = [](double e, double n) { return std::hypot(e - 100, n - 90) < 28; };
        const auto house = [](double e, double n) {
            return std::fmod(e, 50) > 35 && std::fmod(n, 60) > 45;
        };
        for (int i = 0; i < 160'000; ++i) {
            const double e = 0.05 + unit() * 199.9;
            const double n = 0.05 + unit() * 179.9;
            const double noise = (unit() - 0.5) * 0.1;
            if (lake(e, n)) {
                if (i % 12 == 0)
                    cloud.add(e, n, 296 + noise, 9);
            } else if (house(e, n)) {
                cloud.add(e, n, ground(e, n) + 8 + noise, 6);
            } else if (!(e > 150 && e < 170 && n < 30)) {  // a void
                cloud.add(e, n, ground(e, n) + noise, 2);
                if (std::sin(e / 5) * std::sin(n / 5) > 0.7)
                    cloud.add(e, n, ground(e, n) + 2 + unit() * 9, 5);
            }
        }
        return cloud;
    }();
    return made;
}

std::vector<voxel::BoxKey> keys_of_two_levels(const voxel::WorldInfo& info) {
    auto keys = all_keys(info, 0);
    const auto coarse = all_keys(info, 1);
    keys.insert(keys.end(), coarse.begin(), coarse.end());
    return keys;
}

}  // namespace

TEST_CASE(
    "boxes are the same in whatever order, by however many threads and with however little memory "
    "they are requested",
    "[voxelserver][voxelize][seamless]") {
    const TemporaryFolder folder;
    mixture().write(folder.path() / "all.laz");
    OpenWorld first(folder.path() / "all.laz");
    const auto keys = keys_of_two_levels(first.info());
    const Checksums reference = checksums(first.world(), keys);
    CHECK(std::count_if(reference.begin(), reference.end(),
                        [](const auto& e) { return e.second != 0; }) > 8);
    struct Case {
        const char* name;
        std::size_t memory_bytes;
        int threads;
        unsigned shuffle;
    };
    const auto c = GENERATE(values<Case>({{"backwards", std::size_t{4} << 30, 1, 0},
                                          {"shuffled, 64 MiB", std::size_t{64} << 20, 2, 5},
                                          {"shuffled, 1 MiB", std::size_t{1} << 20, 3, 6},
                                          {"no memory at all", 1, 2, 7}}));
    DYNAMIC_SECTION(c.name) {
        auto options = OpenWorld::with(folder.path() / "all.laz");
        options.memory_bytes = c.memory_bytes;
        options.threads = c.threads;
        OpenWorld world(options);
        CHECK(world.info().bounds == first.info().bounds);
        auto order = keys;
        if (c.shuffle == 0)
            std::reverse(order.begin(), order.end());
        else
            std::shuffle(order.begin(), order.end(), std::mt19937(c.shuffle));
        CHECK((checksums(world.world(), order) == reference));
    }
    SECTION("by four threads at once") {
        OpenWorld world(folder.path() / "all.laz");
        std::vector<Checksums> found(4);
        std::vector<std::thread> threads;
        for (unsigned t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                auto order = keys;
                std::shuffle(order.begin(), order.end(), std::mt19937(t));
                found[t] = checksums(world.world(), order);
            });
        for (auto& t : threads)
            t.join();
        for (const auto& f : found)
            CHECK((f == reference));
    }
}

TEST_CASE("one file or several with borders through voxels: the same voxels",
          "[voxelserver][voxelize][seamless]") {
    struct Case {
        const char* name;
        double east;
        double north;
    };
    const auto c = GENERATE(values<Case>({{"on voxel borders", 100, 90},
                                          {"inside voxels", 97.37, 61.81},
                                          {"near a corner", 3.2, 176.6}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder whole;
        const TemporaryFolder cut;
        mixture().write(whole.path() / "all.laz");
        for (int i = 0; i < 4; ++i)
            mixture().write(cut.path() / ("part" + std::to_string(i) + ".laz"), kCrs, 6,
                            [&](const Cloud::Point& p) {
                                return (p.east < c.east) == ((i & 1) != 0) &&
                                       (p.north < c.north) == ((i & 2) != 0);
                            });
        OpenWorld one(whole.path()), four(cut.path());
        REQUIRE(four.world().stats().files == 4);
        CHECK(four.info().bounds == one.info().bounds);
        const auto keys = all_keys(one.info(), 0);
        int different = 0;
        int voxels = 0;
        for (const auto& key : keys) {
            const auto a = one.world().box(key);
            const auto b = four.world().box(key);
            if ((a ? a->checksum() : 0) == (b ? b->checksum() : 0))
                continue;
            ++different;
            for (int y = 0; y < 256; ++y)
                for (int z = 0; z < 64; ++z)
                    for (int x = 0; x < 64; ++x)
                        if ((a ? a->voxel(x, y, z) : std::nullopt) !=
                            (b ? b->voxel(x, y, z) : std::nullopt)) {
                            if (++voxels <= 3)
                                UNSCOPED_INFO("box " << voxel::to_string(key) << " voxel " << x
                                                     << " " << y << " " << z << ": "
                                                     << (key.bx * 64 + x - kEast0) << " m east, "
                                                     << (-kNorth0 - (key.bz * 64 + z))
                                                     << " m north");
                        }
        }
        UNSCOPED_INFO(voxels << " voxels differ");
        CHECK(different == 0);
    }
}

TEST_CASE("files named in any order, or twice, make the same world",
          "[voxelserver][voxelize][seamless]") {
    const TemporaryFolder folder;
    const auto west = folder.path() / "b_west.laz";
    const auto east = folder.path() / "a_east.laz";
    mixture().write(west, kCrs, 6, [](const Cloud::Point& p) { return p.east < 90; });
    mixture().write(east, kCrs, 6, [](const Cloud::Point& p) { return p.east >= 90; });
    const auto sums = [&](std::vector<std::filesystem::path> files) {
        auto options = OpenWorld::with(west);
        options.files = std::move(files);
        OpenWorld world(options);
        return checksums(world.world(), all_keys(world.info(), 0));
    };
    const Checksums reference = sums({west, east});
    CHECK((sums({east, west}) == reference));
    CHECK((sums({folder.path(), west}) == reference));
}

TEST_CASE("a box of a coarser level is made of its eight children", "[voxelserver][voxelize]") {
    const TemporaryFolder folder;
    mixture().write(folder.path() / "all.laz");
    OpenWorld world(folder.path() / "all.laz");
    REQUIRE(world.info().levels >= 3);
    for (int level = 1; level < world.info().levels; ++level)
        for (const auto& key : all_keys(world.info(), level)) {
            INFO(voxel::to_string(key));
            std::array<std::shared_ptr<const voxel::Box>, 8> children;
            for (int i = 0; i < 8; ++i)
                children[static_cast<std::size_t>(i)] =
                    world.world().box({level - 1, 2 * key.bx + (i & 1), 2 * key.by + (i >> 2),
                                       2 * key.bz + (i >> 1 & 1)});
            const auto wanted = voxel::downsample(key, children);
            const auto found = world.world().box(key);
            CHECK((wanted ? wanted->checksum() : 0) == (found ? found->checksum() : 0));
        }
}

TEST_CASE("boxes beyond the world are air, and levels it does not have are refused",
          "[voxelserver][voxelize]") {
    const TemporaryFolder folder;
    mixture().write(folder.path() / "all.laz");
    OpenWorld world(folder.path() / "all.laz");
    CHECK(world.world().box({0, 0, 0, 0}) == nullptr);
    CHECK(world.world().column(0, 0, 0).empty());
    CHECK(world.world().box({0, all_keys(world.info(), 0).front().bx, 30,
                             all_keys(world.info(), 0).front().bz}) == nullptr);
    CHECK_THROWS(world.world().box({world.info().levels, 0, 0, 0}));
    CHECK_THROWS(world.world().box({-1, 0, 0, 0}));
    for (const auto& key : all_keys(world.info(), 0)) {
        const auto extent = world.world().column(0, key.bx, key.bz);
        if (world.world().box(key))
            CHECK((key.by >= extent.by_begin && key.by < extent.by_end));
    }
}
