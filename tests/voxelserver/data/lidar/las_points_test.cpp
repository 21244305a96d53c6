#include <laszip/laszip_api.h>

#include <algorithm>
#include <random>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "tests/voxelserver/data/lidar/shared_files.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"

using namespace terravox;
using namespace terravox::lidar;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

std::vector<RawPoint> list_points(const LasInfo& info, std::span<const PointRange> ranges) {
    std::vector<RawPoint> out;
    read_point_batches(info, ranges, [&](std::span<const RawPoint> batch) {
        CHECK(!batch.empty());
        CHECK(batch.size() <= 4096);
        out.insert(out.end(), batch.begin(), batch.end());
    });
    return out;
}

}  // namespace

TEST_CASE("ranges in any order, overlapping, empty or single points give the points of one read",
          "[voxelserver][lidar]") {
    struct Case {
        const char* name;
        int format;
        const char* ending;
    };
    const auto c = GENERATE(
        values<Case>({{"plain", 6, ".las"}, {"chunked", 1, ".laz"}, {"layered", 7, ".laz"}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const fs::path file = folder.path() / (std::string("sample") + c.ending);
        write_sample(file, c.format, 120'000);
        const auto info = read_las_info(file);
        const auto whole = all_raw(info);
        std::mt19937 random(5);
        for (int i = 0; i < 12; ++i) {
            std::vector<PointRange> ranges;
            std::vector<RawPoint> wanted;
            for (int k = 0; k < 1 + i % 5; ++k) {
                const std::uint64_t begin = random() % whole.size();
                const std::uint64_t most = i % 3 == 0 ? 3 : 60'000;
                const std::uint64_t end =
                    std::min<std::uint64_t>(whole.size(), begin + random() % most);
                ranges.push_back({begin, end});
                wanted.insert(wanted.end(), whole.begin() + static_cast<std::ptrdiff_t>(begin),
                              whole.begin() + static_cast<std::ptrdiff_t>(end));
                UNSCOPED_INFO("case " << i << ": " << begin << " to " << end);
            }
            CHECK(list_points(info, ranges) == wanted);
        }
    }
}

TEST_CASE("a range beyond the points is refused", "[voxelserver][lidar]") {
    const TemporaryFolder folder;
    write_sample(folder.path() / "few.laz", 6, 10);
    const auto info = read_las_info(folder.path() / "few.laz");
    const PointRange beyond{5, 11};
    CHECK_THROWS_WITH(read_point_batches(info, {&beyond, 1}, [](std::span<const RawPoint>) {}),
                      contains("points 5 to 11") && contains("few.laz"));
}

TEST_CASE("near infrared is read where the format has it", "[voxelserver][lidar][data]") {
    struct Case {
        const char *file, *plain;
        std::size_t at;
    };
    const auto c = GENERATE(values<Case>({{"pt8_v3.laz", "pt8_v0.las", 36},
                                          {"pt8_v4.laz", "pt8_v0.las", 36},
                                          {"pt10_v4.laz", "pt10_v0.las", 36},
                                          {"pt8_v0.las", "pt8_v0.las", 36},
                                          {"pt7_v4.laz", "pt7_v0.las", 0},
                                          {"pt3_v2.laz", "pt3_v0.las", 0}}));
    const fs::path folder = kShared / "lazpy" / "testdata";
    if (!there(folder))
        return;
    DYNAMIC_SECTION(c.file) {
        const auto raw = all_raw(read_las_info(folder / c.file));
        const std::string bytes = read_content(folder / c.plain);
        std::uint32_t begin = 0;
        std::uint16_t record = 0;
        std::memcpy(&begin, bytes.data() + 96, 4);
        std::memcpy(&record, bytes.data() + 105, 2);
        std::size_t different = 0;
        std::size_t bright = 0;
        for (std::size_t i = 0; i < raw.size(); ++i) {
            std::uint16_t wanted = 0;
            if (c.at != 0)
                std::memcpy(&wanted, bytes.data() + begin + i * record + c.at, 2);
            different += raw[i].nir == wanted ? 0 : 1;
            bright += raw[i].nir != 0 ? 1 : 0;
        }
        CHECK(raw.size() == 500);
        CHECK(different == 0);
        CHECK((bright > 0) == (c.at != 0));
    }
}

TEST_CASE("a sample is spread over the file and always the same", "[voxelserver][lidar]") {
    struct Case {
        const char* name;
        int format;
        std::size_t points;
        std::size_t about;
        std::size_t least;
        std::size_t most;
    };
    const auto c = GENERATE(values<Case>({{"many.laz", 6, 420'000, 900, 900, 909},
                                          {"old.laz", 1, 420'000, 900, 900, 909},
                                          {"plain.las", 6, 70'000, 640, 640, 704},
                                          {"few.laz", 6, 50, 1000, 50, 50},
                                          {"one.laz", 6, 3000, 1, 1, 1},
                                          {"nothing.las", 6, 0, 100, 0, 0},
                                          {"none.laz", 6, 100, 0, 0, 0}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        write_sample(folder.path() / c.name, c.format, c.points);
        const auto info = read_las_info(folder.path() / c.name);
        const auto sample = sample_points(info, c.about);
        const auto whole = all_raw(info);
        CHECK(sample.size() >= c.least);
        CHECK(sample.size() <= c.most);
        CHECK(sample == sample_points(info, c.about));
        // Points of the file in its order, from its first piece to its last (a chunk has 50,000
        // points).
        auto at = whole.begin();
        for (const RawPoint& p : sample) {
            at = std::find(at, whole.end(), p);
            REQUIRE(at != whole.end());
        }
        if (c.points > 60'000)
            CHECK(static_cast<std::size_t>(at - whole.begin()) + 60'000 > c.points);
    }
}

TEST_CASE(
    "the sample of a COPC file is of its root node, that of an unseekable file its first points",
    "[voxelserver][lidar][data]") {
    if (!there(kShared / "copcjs") || !there(kShared / "lazpy"))
        return;
    const auto copc = read_las_info(kShared / "copcjs" / "ellipsoid.copc.laz");
    const auto sample = sample_points(copc, 500);
    CHECK(sample.size() >= 500);
    const auto [low, high] =
        std::minmax_element(sample.begin(), sample.end(),
                            [](const RawPoint& a, const RawPoint& b) { return a.x < b.x; });
    CHECK((high->x - low->x) * copc.scale[0] > 0.8 * (copc.max[0] - copc.min[0]));
    const auto pointwise = read_las_info(kShared / "lazpy" / "testdata" / "pt1_v1_pointwise.laz");
    CHECK_FALSE(pointwise.seekable);
    const auto whole = all_raw(pointwise);
    CHECK(sample_points(pointwise, 20) == std::vector<RawPoint>(whole.begin(), whole.begin() + 20));
}

TEST_CASE("points of formats 6-10 kept in an older one are read as LASzip reads them",
          "[voxelserver][lidar][data]") {
    const std::string name =
        GENERATE("pt6_compat_v0.las", "pt6_compat_v2.laz", "pt7_compat_v2.laz", "pt8_compat_v2.laz",
                 "pt8_compat_noextra_v0.las", "pt8_compat_noextra_v2.laz", "pt9_compat_v2.laz",
                 "pt10_compat_v0.las", "pt10_compat_v2.laz");
    const fs::path file = kShared / "lazpy" / "testdata" / name;
    if (!there(file))
        return;
    INFO(name);
    const auto info = read_las_info(file);
    REQUIRE(info.compatible);
    CHECK(info.point_format < 6);
    const auto points = all_raw(info);
    laszip_POINTER reader = nullptr;
    laszip_point_struct* theirs = nullptr;
    laszip_BOOL compressed = 0;
    REQUIRE(laszip_create(&reader) == 0);
    REQUIRE(laszip_request_compatibility_mode(reader, 1) == 0);
    REQUIRE(laszip_open_reader(reader, file.c_str(), &compressed) == 0);
    REQUIRE(laszip_get_point_pointer(reader, &theirs) == 0);
    std::size_t different = 0;
    std::size_t only_there = 0;
    for (const RawPoint& p : points) {
        REQUIRE(laszip_read_point(reader) == 0);
        const int flags = theirs->extended_classification_flags;
        const int nir = info.has_near_infrared() ? theirs->rgb[3] : 0;
        different += p.x == theirs->X && p.y == theirs->Y && p.z == theirs->Z &&
                             p.classification == theirs->extended_classification &&
                             p.return_number == theirs->extended_return_number &&
                             p.return_count == theirs->extended_number_of_returns &&
                             p.withheld == ((flags & 4) != 0) && p.overlap == ((flags & 8) != 0) &&
                             p.nir == nir
                         ? 0
                         : 1;
        only_there += p.classification > 31 && p.return_count > 7 ? 1 : 0;
    }
    laszip_close_reader(reader);
    laszip_destroy(reader);
    CHECK(different == 0);
    if (name.find("noextra") == std::string::npos)
        CHECK(only_there > 0);
}

TEST_CASE("intensities and flight lines are read, or left out", "[voxelserver][lidar]") {
    const int format = GENERATE(1, 3, 6, 8);
    const std::string ending = GENERATE(".las", ".laz");
    INFO("format " << format << ending);
    const TemporaryFolder folder;
    const fs::path file = folder.path() / ("echoes" + ending);
    LasWriterOptions options;
    options.point_format = format;
    LasWriter writer(file, options);
    for (int i = 0; i < 3000; ++i) {
        LasWritePoint point;
        point.x = i * 0.1;
        point.intensity = static_cast<std::uint16_t>(i * 7);
        point.point_source = static_cast<std::uint16_t>(i / 1000 + 1);
        writer.write(point);
    }
    writer.close();
    const auto info = read_las_info(file);
    const PointRange all{0, info.point_count};
    std::size_t at = 0;
    std::size_t wrong = 0;
    read_point_batches(info, {&all, 1}, [&](std::span<const RawPoint> batch) {
        for (const RawPoint& p : batch) {
            wrong += p.intensity != at * 7 || p.point_source != at / 1000 + 1 ? 1 : 0;
            ++at;
        }
    });
    CHECK(at == 3000);
    CHECK(wrong == 0);
    std::size_t left = 0;
    read_point_batches(
        info, {&all, 1},
        [&](std::span<const RawPoint> batch) {
            for (const RawPoint& p : batch)
                left += p.intensity != 0 || p.point_source != 0 ? 1 : 0;
        },
        Echoes::kSkip);
    CHECK(left == 0);
}
