// Worlds of bad files, opened, and all boxes read, in a child process of their own: an Error, or
// boxes of all their points. In an executable of its own: children are forked, so there must be no
// threads.
#include <fstream>
#include <random>
#include <stdexcept>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/lidar/child.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// What a world of a file holds, as a text.
std::string all_boxes(const fs::path& input) {
    auto options = OpenWorld::with(input);
    options.threads = 1;
    options.crs = kCrs;
    OpenWorld world(options);
    std::uint64_t sum = 0;
    std::uint64_t boxes = 0;
    for (const auto& [key, checksum] : checksums(world.world(), all_keys(world.info(), 0))) {
        sum = sum * 31 + checksum;
        boxes += checksum != 0 ? 1 : 0;
    }
    return std::to_string(boxes) + " boxes, sum " + std::to_string(sum);
}

/// The same in a child; what it holds comes back as the text of an exception, for there is no other
/// way.
Outcome world_in_child(const fs::path& input) {
    Outcome out =
        in_child([&] { throw std::runtime_error(all_boxes(input)); }, rlim_t{2} << 30, 60);
    if (out.kind == Outcome::Kind::kOther && out.text.find(" boxes, ") != std::string::npos)
        out.kind = Outcome::Kind::kDone;
    return out;
}

}  // namespace

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
        const std::string whole = read_content(file);
        const Outcome wanted = world_in_child(file);
        INFO(wanted.text);
        REQUIRE(wanted.kind == Outcome::Kind::kDone);
        REQUIRE_FALSE(wanted.text.starts_with("0 boxes"));
        for (unsigned seed = 1; seed <= 10; ++seed) {
            std::mt19937 random(seed);
            const std::size_t length =
                seed <= 3 ? whole.size() - seed * 5 : random() % whole.size();
            std::ofstream(file, std::ios::binary | std::ios::trunc) << whole.substr(0, length);
            const Outcome outcome = world_in_child(file);
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
