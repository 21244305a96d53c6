// Worlds of bad files, opened, and all boxes read, in a child process of their own: an Error, or
// boxes of all their points. In an executable of its own: children are forked, so there must be no
// threads.
#include <fstream>
#include <stdexcept>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/lidar/child.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

const fs::path kShared = TERRAVOX_SHARED_DATA;

/// Columns of boxes to request: all of a small world; of a large one (bounds that lie) its corners
/// and some at random.
std::vector<std::pair<std::int32_t, std::int32_t>> find_columns(const voxel::BoxRange& range) {
    constexpr std::int32_t kSmall = 4096;
    constexpr std::int32_t kCorner = 3;
    constexpr std::int32_t kRandom = 4;
    std::vector<std::pair<std::int32_t, std::int32_t>> out;
    const bool small =
        std::int64_t{range.max.bx - range.min.bx} * (range.max.bz - range.min.bz) <= kSmall;
    const auto corner = [&](std::int32_t v, std::int32_t min, std::int32_t max) {
        return small || v < min + kCorner || v >= max - kCorner;
    };
    const auto next = [&](std::int32_t v, std::int32_t min, std::int32_t max) {
        return corner(v + 1, min, max) ? v + 1 : max - kCorner;
    };
    for (auto bz = range.min.bz; bz < range.max.bz; bz = next(bz, range.min.bz, range.max.bz))
        for (auto bx = range.min.bx; bx < range.max.bx; bx = next(bx, range.min.bx, range.max.bx))
            out.emplace_back(bx, bz);
    std::mt19937 random(1);
    const auto between = [&](std::int32_t min, std::int32_t max) {
        return min + static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(max - min));
    };
    for (int i = 0; !small && i < kRandom; ++i)
        out.emplace_back(between(range.min.bx, range.max.bx), between(range.min.bz, range.max.bz));
    return out;
}

/// What a world of a file holds, as a text.
std::string all_boxes(const fs::path& input, const char* crs) {
    auto options = OpenWorld::with(input);
    options.threads = 1;
    if (crs != nullptr)
        options.crs = crs;
    OpenWorld world(options);
    std::uint64_t sum = 0;
    std::uint64_t boxes = 0;
    const auto columns = find_columns(voxel::boxes_over(world.info().bounds, 0));
    for (const auto& [bx, bz] : columns) {
        const auto extent = world.world().column(0, bx, bz);
        for (auto by = extent.by_begin; by < extent.by_end; ++by)
            if (const auto box = world.world().box({0, bx, by, bz})) {
                sum = sum * 31 + box->checksum();
                ++boxes;
            }
    }
    return std::to_string(columns.size()) + " columns, " + std::to_string(boxes) + " boxes, " +
           std::to_string(world.world().stats().outliers) + " outliers, sum " + std::to_string(sum);
}

/// The same in a child; what it holds comes back as the text of an exception, for there is no other
/// way.
Outcome world_in_child(const fs::path& input, const char* crs = nullptr) {
    Outcome out =
        in_child([&] { throw std::runtime_error(all_boxes(input, crs)); }, rlim_t{2} << 30, 60);
    if (out.kind == Outcome::Kind::kOther && out.text.find(" columns, ") != std::string::npos)
        out.kind = Outcome::Kind::kDone;
    return out;
}

}  // namespace

TEST_CASE("worlds of files known to be bad end in an error or in boxes",
          "[voxelserver][voxelize][data]") {
    if (!fs::exists(kShared)) {
        WARN("skipped: " << kShared.string() << " is not there");
        return;
    }
    // Files that a reader refuses are tested with readers. crs: for files that carry none; message:
    // part of the error, or of what the world holds.
    struct Case {
        const char *file, *crs;
        bool refused;
        const char* message;
    };
    const auto c = GENERATE(values<Case>({
        {"lazpy/testdata/malformed/chunk_table_11gb.laz", kCrs, true, "chunk_table_11gb.laz"},
        {"pdal/las/permutations/1.2-no-points.las", kCrs, true,
         "1.2-no-points.las: cut short: 1065 points promised; 0 are there"},
        {"pdal/las/bad-geotiff-keys.las", kCrs, false, " boxes"},
        {"pdal/las/spurious.las", "EPSG:4326", false, " boxes"},
        // Bounds from 0, 0: two strays of 37,807 points, and a world of 699 by 6260 km if they
        // counted.
        {"laspy/tests/data/append-bug-cpy.laz", kCrs, false, " 2 outliers"},
    }));
    DYNAMIC_SECTION(c.file) {
        if (!fs::exists(kShared / c.file)) {
            WARN("skipped: not there");
            return;
        }
        const Outcome outcome = world_in_child(kShared / c.file, c.crs);
        INFO(outcome.text);
        CHECK(outcome.kind == (c.refused ? Outcome::Kind::kError : Outcome::Kind::kDone));
        CHECK_THAT(outcome.text, contains(c.message));
        CHECK(outcome.text.find('\n') == std::string::npos);
        if (!c.refused)
            CHECK(outcome.text.find(" 0 boxes") == std::string::npos);
    }
}

TEST_CASE("a world of a file cut short anywhere is refused, and never has fewer voxels quietly",
          "[voxelserver][voxelize]") {
    struct Case {
        const char* name;
        int format;
    };
    const auto c = GENERATE(values<Case>({{"whole.laz", 6}, {"whole.las", 6}, {"old.laz", 1}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        Cloud cloud;
        cloud.cover(0, 0, 120, 100, 0.4, 2,
                    [](double e, double n) { return 50 + 3 * std::sin(e / 9) + 0.05 * n; });
        cloud.cover(30, 30, 50, 50, 0.5, 5,
                    [](double e, double n) { return 62 + std::sin(e) + std::cos(n); });
        const auto file = folder.path() / c.name;
        cloud.write(file, "", c.format);
        const std::string whole = file_bytes(file);
        const Outcome wanted = world_in_child(file, kCrs);
        INFO(wanted.text);
        REQUIRE(wanted.kind == Outcome::Kind::kDone);
        REQUIRE(wanted.text.find(" 0 boxes") == std::string::npos);
        for (unsigned seed = 1; seed <= 10; ++seed) {
            std::mt19937 random(seed);
            const std::size_t length =
                seed <= 3 ? whole.size() - seed * 5 : random() % whole.size();
            std::ofstream(file, std::ios::binary | std::ios::trunc) << whole.substr(0, length);
            const Outcome outcome = world_in_child(file, kCrs);
            INFO("seed " << seed << ", " << length << " of " << whole.size()
                         << " bytes: " << outcome.text);
            // The last bytes of a chunk table may be lost without loss of a point: then all voxels
            // are there.
            if (outcome.kind == Outcome::Kind::kDone)
                CHECK((outcome.text == wanted.text && whole.size() - length < 16));
            else
                CHECK(outcome.kind == Outcome::Kind::kError);
            if (outcome.kind == Outcome::Kind::kError)
                CHECK_THAT(outcome.text, contains(c.name));
        }
    }
}
