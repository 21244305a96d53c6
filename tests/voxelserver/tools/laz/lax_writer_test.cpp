#include "voxelserver/tools/laz/laz_commands.hpp"

#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// Each point lies in a cell that an interval with its number belongs to. @return how many do not
std::size_t unfound(const fs::path& cloud) {
    const auto info = lidar::read_las_info(cloud);
    const auto cells = lidar::read_lax_index(info);
    REQUIRE(cells.has_value());
    std::size_t missed = 0;
    std::size_t number = 0;
    for (const auto& p : all_points(cloud)) {
        bool found = false;
        for (const auto& cell : *cells)
            found = found ||
                    (number >= cell.points.begin && number < cell.points.end && p.x >= cell.min_x &&
                     p.x <= cell.max_x && p.y >= cell.min_y && p.y <= cell.max_y);
        missed += found ? 0 : 1;
        ++number;
    }
    return missed;
}

void write_points(const fs::path& path, std::size_t count, bool shuffled) {
    lidar::LasWriterOptions options;
    lidar::LasWriter writer(path, options);
    std::mt19937 random(5);
    for (std::size_t i = 0; i < count; ++i) {
        lidar::LasWritePoint p;
        const std::size_t place = shuffled ? random() % 1'000'000 : i * 1'000'000 / count;
        p.x = 462'000 + static_cast<double>(place % 1000);
        p.y = 101'000 + static_cast<double>(place / 1000);
        p.z = 500;
        writer.write(p);
    }
    writer.close();
}

}  // namespace

TEST_CASE("an index finds every point, in order or shuffled", "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const bool shuffled = GENERATE(false, true);
    const std::size_t count = GENERATE(1, 19'999, 90'000);
    CAPTURE(shuffled, count);
    const fs::path laz = folder.path() / "a.laz";
    write_points(laz, count, shuffled);
    const auto done = laz::write_lax(laz);
    CHECK(done.path == folder.path() / "a.lax");
    CHECK(fs::file_size(done.path) == done.bytes);
    CHECK(done.cells == (count > 80'000 ? 16U : count > 20'000 ? 4U : 1U));
    CHECK(unfound(laz) == 0);
}

TEST_CASE("an index of points in no order stays small", "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const fs::path laz = folder.path() / "b.laz";
    write_points(laz, 300'000, true);
    const auto done = laz::write_lax(laz);
    CHECK(done.intervals <= 200'000);
    CHECK(lidar::read_lax_index(lidar::read_las_info(laz)).has_value());
}

TEST_CASE("a COPC file and one without points get no index", "[voxelserver][laz][data]") {
    const fs::path data = fs::path(TERRAVOX_SHARED_DATA);
    if (!fs::exists(data)) {
        WARN("skipped: " << data.string() << " is not there");
        return;
    }
    const TemporaryFolder folder;
    for (const char* name : {"pasture/autzen.copc.laz", "pdal/las/no-points.las"}) {
        CAPTURE(name);
        const fs::path copy = folder.path() / fs::path(name).filename();
        fs::copy_file(data / name, copy);
        CHECK_THROWS_AS(laz::write_lax(copy), util::Error);
        CHECK_FALSE(fs::exists(lidar::lax_path(copy)));
    }
}
