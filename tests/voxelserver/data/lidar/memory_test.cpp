// Point files written and read where the memory ends at any one allocation: LASzip, which makes
// thousands of objects for a file, is left by an exception and deletes what it has.
#include <new>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/scarce_memory.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

#ifdef __SANITIZE_ADDRESS__
// LASzip forgets some of its objects when memory ends while it opens a file.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming): its name.
extern "C" const char* __lsan_default_suppressions() {
    return "leak:laszip_";
}
#endif

namespace {

/// Of two chunks when compressed, whose sizes are kept in a table that grows.
constexpr int kPoints = 50'010;
/// More allocations than a file needs.
constexpr std::size_t kPlenty = 100'000;
/// @return whether the work was done with as many allocations; else it ended in an exception
template <typename Work>
bool done_with(std::size_t allocations, const Work& work) {
    try {
        const ScarceMemory scarce(allocations);
        work();
        return true;
    } catch (const std::bad_alloc&) {
        return false;
    } catch (const util::Error&) {
        return false;
    }
}

void write(const fs::path& file, int format) {
    lidar::LasWriterOptions options;
    options.point_format = format;
    lidar::LasWriter writer(file, options);
    lidar::LasWritePoint point;
    for (int i = 0; i < kPoints; ++i) {
        point.x = i;
        point.gps_time_s = i * 1e-3;
        writer.write(point);
    }
    writer.close();
}

std::uint64_t read(const fs::path& file) {
    const lidar::LasInfo info = lidar::read_las_info(file);
    const lidar::PointRange all{0, info.point_count};
    std::uint64_t count = 0;
    lidar::read_point_batches(
        info, std::span(&all, 1),
        [&](std::span<const lidar::RawPoint> batch) { count += batch.size(); });
    return count;
}

}  // namespace

TEST_CASE("without memory a file is written whole or not at all", "[voxelserver][lidar]") {
    const int format = GENERATE(3, 8);  // they have the fields of all others
    const std::string ending = GENERATE(".las", ".laz");
    INFO("format " << format << ending);
    const TemporaryFolder folder;
    const fs::path file = folder.path() / ("sample" + ending);
    REQUIRE(done_with(kPlenty, [&] { write(file, format); }));
    fs::remove(file);
    std::size_t failed = 0;
    while (!done_with(failed, [&] { write(file, format); })) {
        REQUIRE(fs::is_empty(folder.path()));
        REQUIRE(++failed < kPlenty);
    }
    CHECK(failed > 20);
    CHECK(read(file) == kPoints);
}

TEST_CASE("without memory a file is read whole or not at all", "[voxelserver][lidar]") {
    const int format = GENERATE(3, 8);  // they have the fields of all others
    const std::string ending = GENERATE(".las", ".laz");
    INFO("format " << format << ending);
    const TemporaryFolder folder;
    const fs::path file = folder.path() / ("sample" + ending);
    write(file, format);
    std::size_t failed = 0;
    std::uint64_t count = 0;
    REQUIRE(done_with(kPlenty, [&] { (void)read(file); }));
    while (!done_with(failed, [&] { count = read(file); })) {
        REQUIRE(count == 0);
        REQUIRE(++failed < kPlenty);
    }
    CHECK(failed > 20);
    CHECK(count == kPoints);
}
