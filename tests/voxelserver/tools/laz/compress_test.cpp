#include "voxelserver/tools/laz/laz_commands.hpp"

#include <cstring>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "voxelserver/tools/laz/point_stream.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

std::uint64_t digest(const fs::path& path) {
    const auto info = lidar::read_las_info(path);
    laz::PointStream points(info);
    laz::PointDigest digest(info.point_format);
    while (points.next())
        digest.add(points.point());
    return digest.value();
}

template <class T>
T at(const std::string& bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}
template <class T>
void put(std::string& bytes, std::size_t offset, T value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
}

std::string with_extended_record(std::string las, const std::string& payload) {
    const std::uint64_t start = las.size();
    std::string record(60, '\0');
    std::memcpy(record.data() + 2, "terravox", 8);
    put(record, 18, std::uint16_t{4242});
    put(record, 20, static_cast<std::uint64_t>(payload.size()));
    las += record + payload;
    put(las, 235, start);
    put(las, 243, std::uint32_t{1});
    return las;
}

}  // namespace

TEST_CASE("a compressed file has every field of every point, and its header",
          "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const int format = GENERATE(0, 1, 2, 3, 6, 7, 8);
    CAPTURE(format);
    const fs::path las = folder.path() / "a.las";
    const fs::path laz = folder.path() / "a.laz";
    write_sample(las, format, 50'001);
    const auto done = laz::compress(las, laz);
    CHECK(done.points == 50'001);
    CHECK(done.bytes_after == fs::file_size(laz));
    CHECK(done.bytes_after < done.bytes_before);
    CHECK(digest(las) == digest(laz));
    CHECK(laz::check(laz) == 50'001);
    const std::string before = file_bytes(las);
    const std::string after = file_bytes(laz);
    CHECK(after.substr(0, 94) == before.substr(0, 94));
    CHECK(after.substr(131, 96) == before.substr(131, 96));
}

TEST_CASE("points that are all the same are compressed too, to less than any others",
          "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const int format = GENERATE(1, 6);
    CAPTURE(format);
    const fs::path las = folder.path() / "a.las";
    const fs::path laz = folder.path() / "a.laz";
    write_sample(las, format, 1);
    constexpr std::uint32_t kPoints = 200'000;
    std::string bytes = file_bytes(las);
    const std::string point =
        bytes.substr(at<std::uint32_t>(bytes, 96), at<std::uint16_t>(bytes, 105));
    bytes.resize(at<std::uint32_t>(bytes, 96));
    for (std::uint32_t i = 0; i < kPoints; ++i)
        bytes += point;
    if (format < 6)
        put(bytes, 107, kPoints);
    else
        put(bytes, 247, std::uint64_t{kPoints});
    write_bytes(las, bytes);
    const auto done = laz::compress(las, laz);
    CHECK(done.points == kPoints);
    CHECK(laz::check(laz) == kPoints);
}

TEST_CASE("every format of the real files keeps its points, with waveforms and extra bytes",
          "[voxelserver][laz][data]") {
    const fs::path data = fs::path(TERRAVOX_SHARED_DATA) / "lazpy/testdata";
    if (!fs::exists(data)) {
        WARN("skipped: " << data.string() << " is not there");
        return;
    }
    const TemporaryFolder folder;
    int seen = 0;
    for (const auto& entry : fs::directory_iterator(data)) {
        if (entry.path().extension() != ".las")
            continue;
        CAPTURE(entry.path().string());
        const fs::path laz = folder.path() / "b.laz";
        const auto done = laz::compress(entry.path(), laz);
        CHECK(done.points == lidar::read_las_info(entry.path()).point_count);
        CHECK(digest(entry.path()) == digest(laz));
        ++seen;
    }
    CHECK(seen >= 15);
}

TEST_CASE("a digest differs whichever field of a point does", "[voxelserver][laz]") {
    laszip_point_struct a{};
    a.extended_point_type = 1;
    const auto value = [](int format, const laszip_point_struct& p) {
        laz::PointDigest digest(format);
        digest.add(p);
        return digest.value();
    };
    const std::vector<void (*)(laszip_point_struct&)> changes = {
        [](laszip_point_struct& p) { p.X = 1; },
        [](laszip_point_struct& p) { p.Z = 1; },
        [](laszip_point_struct& p) { p.intensity = 1; },
        [](laszip_point_struct& p) { p.user_data = 1; },
        [](laszip_point_struct& p) { p.point_source_ID = 1; },
        [](laszip_point_struct& p) { p.gps_time = 1; },
        [](laszip_point_struct& p) { p.rgb[2] = 1; },
        [](laszip_point_struct& p) { p.rgb[3] = 1; },
        [](laszip_point_struct& p) { p.wave_packet[28] = 1; },
        [](laszip_point_struct& p) { p.extended_classification = 1; },
        [](laszip_point_struct& p) { p.extended_scanner_channel = 1; },
        [](laszip_point_struct& p) { p.extended_scan_angle = 1; },
        [](laszip_point_struct& p) { p.extended_return_number = 1; },
        [](laszip_point_struct& p) { p.extended_classification_flags = 8; },
        [](laszip_point_struct& p) { p.scan_direction_flag = 1; },
        [](laszip_point_struct& p) { p.edge_of_flight_line = 1; },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        CAPTURE(i);
        laszip_point_struct b = a;
        changes[i](b);
        CHECK(value(10, a) != value(10, b));
    }
}

TEST_CASE("records behind the points move with their offset", "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const fs::path las = folder.path() / "e.las";
    const fs::path laz = folder.path() / "e.laz";
    write_sample(las, 6, 60'000);
    const std::string payload(100'000, 'w');
    write_bytes(las, with_extended_record(file_bytes(las), payload));
    (void)laz::compress(las, laz);
    const std::string after = file_bytes(laz);
    const auto start = at<std::uint64_t>(after, 235);
    CHECK(at<std::uint32_t>(after, 243) == 1);
    REQUIRE(start + 60 + payload.size() == after.size());
    CHECK(after.substr(start + 2, 8) == "terravox");
    CHECK(after.substr(start + 60) == payload);
    CHECK(digest(las) == digest(laz));
}

TEST_CASE("what cannot be compressed is refused, and nothing is left behind",
          "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const fs::path las = folder.path() / "c.las";
    const fs::path out = folder.path() / "out.laz";
    write_sample(las, 6, 1000);
    const std::string good = file_bytes(las);
    struct Case {
        const char* name;
        std::string bytes;
    };
    std::string beyond = with_extended_record(good, "x");
    put(beyond, 235, std::uint64_t{10'000'000'000});
    std::string before = with_extended_record(good, "x");
    put(before, 235, std::uint64_t{100});
    const std::vector<Case> cases = {
        {"cut short", good.substr(0, good.size() - 10)},
        {"no LAS", "nothing of the kind"},
        {"empty", ""},
        {"record beyond the end", beyond},
        {"record in the header", before},
    };
    for (const Case& c : cases) {
        CAPTURE(c.name);
        write_bytes(las, c.bytes);
        CHECK_THROWS_AS(laz::compress(las, out), util::Error);
        CHECK_FALSE(fs::exists(out));
        CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
    }
    write_bytes(las, good);
    (void)laz::compress(las, out);
    CHECK_THROWS_AS(laz::compress(out, folder.path() / "again.laz"), util::Error);
    CHECK_THROWS_AS(laz::compress(las, las), util::UsageError);
    CHECK(file_bytes(las) == good);
}

TEST_CASE("a point outside the bounds of its header is found", "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const fs::path las = folder.path() / "d.las";
    write_sample(las, 6, 1000);
    CHECK(laz::check(las) == 1000);
    std::string bytes = file_bytes(las);
    put(bytes, 179, at<double>(bytes, 179) - 1.0);
    write_bytes(las, bytes);
    CHECK_THROWS_AS(laz::check(las), util::Error);
}
