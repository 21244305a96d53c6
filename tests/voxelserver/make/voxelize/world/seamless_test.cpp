// The seamless property: an area's voxels are the same in whatever boxes and order they are
// requested, and however the points lie in files. reach_test.cpp has threads and memory,
// stale_boxes_test.cpp files far away, neighbours_test.cpp the borders of patches.
#include <algorithm>
#include <random>

#include "common/voxel/box_builder.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/image_file.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

constexpr double kWide = 150;
constexpr double kDeep = 130;

/// A lake, a river, houses in rows, a wood, a bridge and a void, all across patches. Dense enough
/// that water is looked for in cells of the same size however the points are dealt.
const Cloud& country() {
    static const Cloud made = [] {
        Cloud cloud;
        std::mt19937 random(4711);
        const auto unit = [&] { return static_cast<double>(random() % 1'000'000) / 1'000'000; };
        const auto ground = [](double e, double n) {
            return 120.3 + 5 * std::sin(e / 41) + 0.03 * n;
        };
        const auto river = [](double e, double n) {
            return std::abs(n - 96 - 8 * std::sin(e / 25)) < 7;
        };
        for (int i = 0; i < 330'000; ++i) {
            const double e = 0.02 + unit() * (kWide - 0.04);
            const double n = 0.02 + unit() * (kDeep - 0.04);
            const double noise = (unit() - 0.5) * 0.12;
            const bool bridge = e > 70 && e < 76 && n > 80 && n < 115;
            const bool house = std::fmod(e, 31) > 20 && std::fmod(n, 43) > 31 && n < 80;
            if (bridge && i % 3 != 0)
                cloud.add(e, n, 128 + noise / 2, 17);
            else if (river(e, n)) {
                if (i % 6 == 0)
                    cloud.add(e, n, 115 - 0.01 * e + noise, 9);
            } else if (std::hypot(e - 45, n - 50) < 17) {
                if (i % 9 == 0)
                    cloud.add(e, n, 117 + noise, 9);
            } else if (house)
                cloud.add(e, n, ground(e, n) + 7 + 0.4 * std::fmod(e, 31) + noise, 6);
            else if (!(e > 128 && e < 140 && n > 20 && n < 30)) {  // a void
                const double crown = std::sin(e / 4) * std::sin(n / 4);
                if (e > 80 && crown > 0.3 && i % 2 == 0)
                    cloud.add(e, n, ground(e, n) + 3 + 11 * crown * unit(), i % 5 == 0 ? 1 : 5);
                else
                    cloud.add(e, n, ground(e, n) + noise, 2);
            }
        }
        return cloud;
    }();
    return made;
}

/// Two images over the country: a coarse one, and a fine one over its middle.
void write_images(const fs::path& folder) {
    struct Image {
        const char* name;
        double east;
        double north;
        double pixel_m;
        int width;
        int height;
    };
    for (const Image& one : {Image{"coarse.tif", -10, 140, 0.8, 215, 190},
                             Image{"fine.tif", 30, 100, 0.3, 200, 230}}) {
        ImageFile image;
        image.width = one.width;
        image.height = one.height;
        image.geo = {kEast0 + one.east, one.pixel_m, 0, kNorth0 + one.north, 0, -one.pixel_m};
        image.value = [&](int x, int y, int band) {
            const double e = one.east + x * one.pixel_m;
            const double n = one.north - y * one.pixel_m;
            return static_cast<int>(128 + 60 * std::sin(e / (5 + 3 * band)) +
                                    60 * std::cos(n / (9 - 2 * band)));
        };
        write_image(folder / one.name, image);
    }
}

/// The country in one file, cut into four through voxels, and dealt into three; and images of it.
class Files {
public:
    Files() {
        for (const char* name : {"one", "cut", "dealt", "images"})
            fs::create_directory(m_folder.path() / name);
        country().write(m_folder.path() / "one" / "all.laz");
        for (int i = 0; i < 4; ++i)
            country().write(m_folder.path() / "cut" / ("part" + std::to_string(i) + ".laz"), kCrs,
                            6, [&](const Cloud::Point& p) {
                                return (p.east < 61.37) == ((i & 1) != 0) &&
                                       (p.north < 88.81) == ((i & 2) != 0);
                            });
        for (unsigned i = 0; i < 3; ++i) {
            std::mt19937 random(99);  // the same for each file
            country().write(m_folder.path() / "dealt" / ("deal" + std::to_string(i) + ".laz"), kCrs,
                            6, [&](const Cloud::Point&) { return random() % 3 == i; });
        }
        write_images(m_folder.path() / "images");
    }
    [[nodiscard]] fs::path folder(const std::string& layout) const {
        return m_folder.path() / layout;
    }
    [[nodiscard]] OpenWorld open(const std::string& layout, double voxel_m, bool images) const {
        auto options = OpenWorld::with(folder(layout));
        options.voxel_m = voxel_m;
        if (images)
            options.orthophotos = {folder("images")};
        return OpenWorld(options);
    }

private:
    TemporaryFolder m_folder;
};
const Files& files() {
    static const Files made;
    return made;
}

}  // namespace

TEST_CASE("all boxes of all levels are the same from files of any cut, in any order",
          "[voxelserver][voxelize][seamless]") {
    struct Case {
        double voxel_m;
        bool images;
    };
    const auto c = GENERATE(values<Case>({{1, false}, {1, true}, {0.5, true}, {2, true}}));
    OpenWorld reference = files().open("one", c.voxel_m, c.images);
    std::vector<voxel::BoxKey> keys;
    for (int level = 0; level < std::min(4, reference.info().levels); ++level) {
        const auto more = all_keys(reference.info(), level);
        keys.insert(keys.end(), more.begin(), more.end());
    }
    const Checksums wanted = checksums(reference.world(), keys);
    CHECK(std::count_if(wanted.begin(), wanted.end(), [](const auto& e) { return e.second != 0; }) >
          4);
    unsigned seed = 0;
    for (const char* layout : {"one", "cut", "dealt"}) {
        std::shuffle(keys.begin(), keys.end(), std::mt19937(++seed));
        OpenWorld world = files().open(layout, c.voxel_m, c.images);
        INFO(c.voxel_m << " m, " << layout << (c.images ? ", with images" : "") << ", seed "
                       << seed);
        REQUIRE(world.info().bounds == reference.info().bounds);
        REQUIRE(world.world().stats().water_cell_m == reference.world().stats().water_cell_m);
        int different = 0;
        for (const auto& [key, sum] : checksums(world.world(), keys))
            if (sum != wanted.at(key) && ++different <= 3)
                UNSCOPED_INFO("box " << voxel::to_string(key));
        CHECK(different == 0);
    }
}

TEST_CASE("files named in any order, or twice, make the same world",
          "[voxelserver][voxelize][seamless]") {
    const auto part = [](int i) {
        return files().folder("cut") / ("part" + std::to_string(i) + ".laz");
    };
    const auto sums = [&](std::vector<fs::path> named) {
        auto options = OpenWorld::with(part(0));
        options.files = std::move(named);
        OpenWorld world(options);
        return checksums(world.world(), all_keys(world.info(), 0));
    };
    const Checksums reference = sums({part(0), part(1), part(2), part(3)});
    CHECK((sums({part(3), part(1), part(0), part(2)}) == reference));
    CHECK((sums({files().folder("cut"), part(1)}) == reference));
}

TEST_CASE("a box of a coarser level is made of its eight children", "[voxelserver][voxelize]") {
    OpenWorld world = files().open("one", 1, false);
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
    OpenWorld world = files().open("one", 1, false);
    const voxel::BoxKey first = all_keys(world.info(), 0).front();
    CHECK(world.world().box({0, 0, 0, 0}) == nullptr);
    CHECK(world.world().column(0, 0, 0).empty());
    CHECK(world.world().box({0, first.bx, 30, first.bz}) == nullptr);
    CHECK_THROWS(world.world().box({world.info().levels, 0, 0, 0}));
    CHECK_THROWS(world.world().box({-1, 0, 0, 0}));
    for (const auto& key : all_keys(world.info(), 0)) {
        const auto extent = world.world().column(0, key.bx, key.bz);
        if (world.world().box(key))
            CHECK((key.by >= extent.by_begin && key.by < extent.by_end));
    }
}
