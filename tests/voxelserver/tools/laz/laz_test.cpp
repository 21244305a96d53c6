#include <algorithm>
#include <cstring>
#include <functional>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/child.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"
#include "voxelserver/tools/laz/laz_commands.hpp"
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
    const std::string before = read_content(las);
    const std::string after = read_content(laz);
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
    std::string bytes = read_content(las);
    const std::string point =
        bytes.substr(at<std::uint32_t>(bytes, 96), at<std::uint16_t>(bytes, 105));
    bytes.resize(at<std::uint32_t>(bytes, 96));
    for (std::uint32_t i = 0; i < kPoints; ++i)
        bytes += point;
    if (format < 6)
        put(bytes, 107, kPoints);
    else
        put(bytes, 247, std::uint64_t{kPoints});
    write_content(las, bytes);
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

TEST_CASE("a file of LAS 1.5 keeps its version, and the times of its header",
          "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const fs::path las = folder.path() / "a.las";
    const fs::path laz = folder.path() / "a.laz";
    const int format = GENERATE(6, 7, 8);
    CAPTURE(format);
    write_sample(las, format, 60'000);
    std::string bytes = with_extended_record(read_content(las), "payload");
    std::string times(18, '\0');
    put(times, 0, 300.5);
    put(times, 8, 100.25);
    put(times, 16, std::uint16_t{1000});
    bytes.insert(375, times);
    put(bytes, 25, std::uint8_t{5});
    put(bytes, 94, std::uint16_t{393});
    put(bytes, 96, at<std::uint32_t>(bytes, 96) + 18);
    put(bytes, 235, at<std::uint64_t>(bytes, 235) + 18);
    write_content(las, bytes);
    CHECK(laz::compress(las, laz).points == 60'000);
    const std::string after = read_content(laz);
    CHECK(at<std::uint8_t>(after, 25) == 5);
    CHECK(after.substr(375, 18) == times);
    CHECK(after.substr(after.size() - 7) == "payload");
    CHECK(laz::check(laz) == 60'000);
}

TEST_CASE("records behind the points move with their offset", "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const fs::path las = folder.path() / "e.las";
    const fs::path laz = folder.path() / "e.laz";
    write_sample(las, 6, 60'000);
    const std::string payload(100'000, 'w');
    write_content(las, with_extended_record(read_content(las), payload));
    (void)laz::compress(las, laz);
    const std::string after = read_content(laz);
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
    const std::string good = read_content(las);
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
        write_content(las, c.bytes);
        CHECK_THROWS_AS(laz::compress(las, out), util::Error);
        CHECK_FALSE(fs::exists(out));
        CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
    }
    write_content(las, good);
    (void)laz::compress(las, out);
    CHECK_THROWS_AS(laz::compress(out, folder.path() / "again.laz"), util::Error);
    CHECK_THROWS_AS(laz::compress(las, las), util::UsageError);
    CHECK(read_content(las) == good);
}

TEST_CASE("a point outside the bounds of its header is found", "[voxelserver][laz]") {
    const TemporaryFolder folder;
    const fs::path las = folder.path() / "d.las";
    write_sample(las, 6, 1000);
    CHECK(laz::check(las) == 1000);
    std::string bytes = read_content(las);
    put(bytes, 179, at<double>(bytes, 179) - 1.0);
    write_content(las, bytes);
    CHECK_THROWS_AS(laz::check(las), util::Error);
}

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

// Files with bytes changed at random: each is tried in a child of its own, so that a crash or a
// hang is a failure with its number.
TEST_CASE("damaged files end in one line, never in a crash", "[voxelserver][laz][damage]") {
    const TemporaryFolder folder;
    const fs::path las = folder.path() / "a.las";
    const fs::path laz = folder.path() / "a.laz";
    const fs::path bad = folder.path() / "bad.las";
    const fs::path out = folder.path() / "out.laz";
    const int format = GENERATE(3, 7);
    write_sample(las, format, 3000, "LOCAL_CS[\"x\"]");
    (void)laz::compress(las, laz);
    for (const fs::path& from : {las, laz}) {
        const std::string good = read_content(from);
        for (unsigned seed = 0; seed < 24; ++seed) {
            CAPTURE(format, from.string(), seed);
            std::mt19937 random(seed);
            std::string bytes = good;
            // Half of them in the header and its records, where counts and offsets are.
            for (int i = 0; i < 4; ++i)
                bytes[random() % (seed % 2 == 0 ? std::min<std::size_t>(bytes.size(), 600)
                                                : bytes.size())] = static_cast<char>(random());
            if (seed % 5 == 0)
                bytes.resize(random() % bytes.size());
            write_content(bad, bytes);
            for (const auto& work : std::vector<std::function<void()>>{
                     [&] { (void)laz::check(bad); }, [&] { (void)laz::info_json(bad); },
                     [&] { (void)laz::compress(bad, out); }, [&] { (void)laz::write_lax(bad); }}) {
                CHECK(complaint(in_child(work)) == "");
            }
        }
    }
}
