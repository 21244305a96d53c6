#include "voxelserver/data/lidar/spatial_index.hpp"

#include <laszip/laszip_api.h>

#include <random>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "tests/voxelserver/data/lidar/shared_files.hpp"

using namespace terravox;
using namespace terravox::lidar;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

struct Rectangle {
    double min_x;
    double min_y;
    double max_x;
    double max_y;
};

std::vector<RawPoint> inside(const LasInfo& info, const std::vector<RawPoint>& points,
                             const Rectangle& r) {
    std::vector<RawPoint> out;
    for (const RawPoint& p : points) {
        const double x = p.x * info.scale[0] + info.offset[0];
        const double y = p.y * info.scale[1] + info.offset[1];
        if (x >= r.min_x && x <= r.max_x && y >= r.min_y && y <= r.max_y)
            out.push_back(p);
    }
    return out;
}

/// Checks random rectangles, some of them empty, thin, or with a corner on a point. @return share
/// of the points that small ones had to read
double check_rectangles(const LasInfo& info, const SpatialIndex& index, unsigned seed) {
    const auto whole = all_raw(info);
    std::mt19937 random(seed);
    const auto between = [&](double a, double b) {
        return a + (b - a) * (random() % 100'001) / 1e5;
    };
    double share = 0;
    for (int i = 0; i < 40; ++i) {
        const double wide = i % 2 == 0 ? 0.05 : 0.7;
        const RawPoint& p = whole[random() % whole.size()];
        const double x = i % 3 == 0 ? p.x * info.scale[0] + info.offset[0]
                                    : between(info.min[0] - 5, info.max[0]);
        const double y = i % 3 == 0 ? p.y * info.scale[1] + info.offset[1]
                                    : between(info.min[1] - 5, info.max[1]);
        const double width = i % 5 == 4 ? 0 : between(0, wide * (info.max[0] - info.min[0]));
        const double depth = between(0, wide * (info.max[1] - info.min[1]));
        const Rectangle r{x, y, x + width, y + depth};
        const auto ranges = index.ranges_over(r.min_x, r.min_y, r.max_x, r.max_y);
        for (std::size_t k = 0; k < ranges.size(); ++k) {
            CHECK(ranges[k].begin < ranges[k].end);
            CHECK(ranges[k].end <= info.point_count);
            if (k > 0)
                CHECK(ranges[k - 1].end < ranges[k].begin);
            if (i % 2 == 0)
                share += static_cast<double>(ranges[k].end - ranges[k].begin) /
                         static_cast<double>(info.point_count) / 20;
        }
        std::vector<RawPoint> found;
        read_point_batches(info, ranges, [&](std::span<const RawPoint> batch) {
            found.insert(found.end(), batch.begin(), batch.end());
        });
        INFO("seed " << seed << ", case " << i << ": " << r.min_x << " " << r.min_y << " to "
                     << r.max_x << " " << r.max_y);
        CHECK(inside(info, found, r) == inside(info, whole, r));
    }
    CHECK(
        index.ranges_over(info.max[0] + 1e7, info.min[1], info.max[0] + 2e7, info.max[1]).size() <=
        1000);
    return share;
}

/// Points in short strips, so that neighbours in the file are neighbours in space, with LASzip's
/// own index next to them.
void write_with_lax(const fs::path& path, int format, std::size_t count, double origin) {
    laszip_POINTER writer = nullptr;
    REQUIRE(laszip_create(&writer) == 0);
    laszip_header_struct* header = nullptr;
    laszip_point_struct* point = nullptr;
    REQUIRE(laszip_get_header_pointer(writer, &header) == 0);
    header->version_major = 1;
    header->version_minor = format >= 6 ? 4 : 2;
    header->header_size = format >= 6 ? 375 : 227;
    header->offset_to_point_data = header->header_size;
    header->point_data_format = static_cast<laszip_U8>(format);
    header->point_data_record_length = format >= 6 ? 30 : 28;
    header->x_scale_factor = header->y_scale_factor = header->z_scale_factor = 0.01;
    header->x_offset = header->y_offset = origin;
    // The index is made over these bounds before any point is seen.
    header->min_x = header->min_y = origin;
    header->max_x = header->max_y = origin + 1000;
    if (format >= 6)
        REQUIRE(laszip_request_native_extension(writer, 1) == 0);
    REQUIRE(laszip_create_spatial_index(writer, 1, 0) == 0);
    REQUIRE(laszip_open_writer(writer, path.c_str(), 1) == 0);
    REQUIRE(laszip_get_point_pointer(writer, &point) == 0);
    std::mt19937 random(3);
    laszip_I32 failed = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t strip = i / 400;
        point->X = static_cast<laszip_I32>(strip % 20 * 5000 + random() % 5000);
        point->Y = static_cast<laszip_I32>((strip / 20 * 2500 + random() % 2500) % 100'000);
        point->Z = static_cast<laszip_I32>(i);
        failed += laszip_write_indexed_point(writer) + laszip_update_inventory(writer);
    }
    REQUIRE(failed == 0);
    REQUIRE(laszip_close_writer(writer) == 0);
    laszip_destroy(writer);
}

}  // namespace

TEST_CASE("the points inside random rectangles are found through a COPC hierarchy",
          "[voxelserver][lidar][copc][data]") {
    // Small files have one node that lies everywhere, and so save nothing.
    struct Case {
        const char* file;
        double max_share;
    };
    const auto c = GENERATE(values<Case>({{"copcjs/ellipsoid.copc.laz", 0.9},
                                          {"laspy/tests/data/simple.copc.laz", 1},
                                          {"laspy/tests/data/simple_with_page.copc.laz", 1},
                                          {"pdal/copc/1.2-with-color.copc.laz", 1},
                                          {"pasture/autzen.copc.laz", 1}}));
    if (!there(kShared / c.file))
        return;
    DYNAMIC_SECTION(c.file) {
        const auto info = read_las_info(kShared / c.file);
        const auto index = read_spatial_index(info);
        REQUIRE(index);
        CHECK(index->source().find("COPC") != std::string::npos);
        CHECK(check_rectangles(info, *index, 21) <= c.max_share + 1e-9);
    }
}

TEST_CASE("the points inside random rectangles are found through a .lax file",
          "[voxelserver][lidar][lax][data]") {
    const std::string name =
        GENERATE("pt0_v0.las", "pt1_v2.laz", "pt6_v3.laz", "pt1_v1_pointwise.laz");
    if (!there(kShared / "lazpy"))
        return;
    INFO(name);
    const auto info = read_las_info(kShared / "lazpy" / "testdata" / name);
    const auto index = read_spatial_index(info);
    REQUIRE(index);
    check_rectangles(info, *index, 22);
}

TEST_CASE("an index that LASzip has written is used, far from the origin too",
          "[voxelserver][lidar][lax]") {
    struct Case {
        const char* name;
        int format;
        double origin;
    };
    // 32-bit numbers hold the last place in steps of half a metre; the writer rounds so, and so
    // must the reader.
    const auto c = GENERATE(values<Case>({{"near", 1, 0},
                                          {"far", 1, 4'900'123.45},
                                          {"negative", 1, -777'777.7},
                                          {"layered", 6, 462'000}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const fs::path file = folder.path() / "strips.laz";
        write_with_lax(file, c.format, 60'000, c.origin);
        REQUIRE(fs::exists(folder.path() / "strips.lax"));
        const auto info = read_las_info(file);
        const auto index = read_spatial_index(info);
        REQUIRE(index);
        CHECK(index->source() == (folder.path() / "strips.lax").string());
        CHECK(check_rectangles(info, *index, 23) < 0.3);
        // An index next to a file changes nothing for readers that do not request it.
        const auto with = all_raw(info);
        fs::remove(folder.path() / "strips.lax");
        CHECK(all_raw(info) == with);
        CHECK_FALSE(read_spatial_index(info));
    }
}

TEST_CASE("a .lax file of another point cloud is refused", "[voxelserver][lidar][lax]") {
    const TemporaryFolder folder;
    write_with_lax(folder.path() / "a.laz", 1, 60'000, 1000);
    write_with_lax(folder.path() / "fewer.laz", 1, 50'000, 1000);
    write_with_lax(folder.path() / "elsewhere.laz", 1, 60'000, 500);
    const auto info = read_las_info(folder.path() / "a.laz");
    struct Case {
        const char *lax, *said;
    };
    for (const Case& c : {Case{"fewer.lax", "50000 points; the point cloud has 60000"},
                          Case{"elsewhere.lax", "do not belong together"}}) {
        INFO(c.lax);
        fs::copy_file(folder.path() / c.lax, folder.path() / "a.lax",
                      fs::copy_options::overwrite_existing);
        CHECK_THROWS_WITH(read_spatial_index(info), contains(c.said) && contains("a.lax"));
    }
}
