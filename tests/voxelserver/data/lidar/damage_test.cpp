// Good files of many kinds, cut and changed at random: read in a child of their own, they end in an
// Error or with all their points.
#include <algorithm>
#include <random>
#include <stdexcept>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/child.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "tests/voxelserver/data/lidar/shared_files.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// One small file of every kind; skipped without the shared data.
struct Kind {
    const char *name, *file;
};
const Kind kKinds[] = {{"plain, format 0", "lazpy/testdata/pt0_v0.las"},
                       {"plain, format 9", "lazpy/testdata/pt9_v0.las"},
                       {"first items, format 1", "lazpy/testdata/pt1_v1.laz"},
                       {"chunked, format 1", "lazpy/testdata/pt1_v2.laz"},
                       {"with an index inside", "lazpy/testdata/pt1_v2_appended.laz"},
                       {"pointwise, format 3", "lazpy/testdata/pt3_v1_pointwise.laz"},
                       {"waveforms, format 5", "lazpy/testdata/pt5_v2.laz"},
                       {"layered, format 6", "lazpy/testdata/pt6_v4.laz"},
                       {"layered, format 7", "lazpy/testdata/pt7_v3.laz"},
                       {"layered, format 8", "lazpy/testdata/pt8_v4.laz"},
                       {"layered, format 10", "lazpy/testdata/pt10_v4.laz"},
                       {"compatible, format 8", "lazpy/testdata/pt8_compat_v2.laz"},
                       {"COPC of one page", "laspy/tests/data/simple.copc.laz"},
                       {"COPC of two pages", "laspy/tests/data/simple_with_page.copc.laz"},
                       {"COPC", "copcjs/ellipsoid.copc.laz"},
                       {"extra bytes", "laspy/tests/data/append-bug.laz"}};

Outcome read_all(const fs::path& file) {
    return in_child([&] {
        const auto info = lidar::read_las_info(file);
        std::uint64_t count = 0;
        const auto ranges = lidar::split_by_chunk(info, 20'000);
        lidar::read_point_batches(
            info, ranges, [&](std::span<const lidar::RawPoint> batch) { count += batch.size(); });
        if (count != info.point_count)
            throw std::logic_error(std::to_string(count) + " of " +
                                   std::to_string(info.point_count) + " points without an error");
        const auto sample = lidar::sample_points(info, 100);
        if (sample.empty() && count > 0)
            throw std::logic_error("no sample");
    });
}

Outcome read_index(const fs::path& file) {
    return in_child([&] {
        const auto info = lidar::read_las_info(file);
        const auto index = lidar::read_spatial_index(info);
        if (!index)
            return;
        const auto ranges = index->ranges_over(-1e300, -1e300, 1e300, 1e300);
        if (ranges.size() != 1 || ranges[0].begin != 0 || ranges[0].end != info.point_count)
            throw std::logic_error("an index that has lost points");
    });
}

bool files_are_there() {
    return there(kShared / "lazpy") && there(kShared / "laspy") && there(kShared / "copcjs");
}

/// Cuts a file at random: it must be refused, unless all its points are there.
void check_cuts(const std::string& name, const fs::path& file) {
    const TemporaryFolder folder;
    const fs::path cut = folder.path() / "cut.laz";
    const std::string whole = read_content(file);
    const auto wanted = all_raw(lidar::read_las_info(file));
    std::mt19937 random(11);
    for (int i = 0; i < 16; ++i) {
        const std::size_t length =
            i < 3 ? whole.size() - 1 - random() % 200 : random() % whole.size();
        write_content(cut, whole.substr(0, length));
        const Outcome outcome = read_all(cut);
        INFO(name << ", seed 11, case " << i << ": " << length << " of " << whole.size()
                  << " bytes: " << outcome.text);
        CHECK(complaint(outcome, "cut.laz") == "");
        CHECK(complaint(read_index(cut)) == "");
        if (outcome.kind == Outcome::Kind::kDone)
            CHECK(all_raw(lidar::read_las_info(cut)) == wanted);
    }
}

/// Changes bytes of a file at random: it must be read whole, or refused.
void check_changes(const std::string& name, const fs::path& file) {
    const TemporaryFolder folder;
    const fs::path changed = folder.path() / "changed.laz";
    const std::string whole = read_content(file);
    std::uint32_t points_at = 0;
    std::memcpy(&points_at, whole.data() + 96, sizeof points_at);
    std::mt19937 random(12);
    for (int i = 0; i < 40; ++i) {
        std::string bytes = whole;
        std::string description;
        // Numbers that lead somewhere stand in the header, before and after the points; each also
        // gets its share of anywhere.
        for (int changes = 1 + i % 4; changes > 0; --changes) {
            const std::size_t places[] = {random() % points_at, points_at + random() % 160,
                                          whole.size() - 1 - random() % 300,
                                          random() % whole.size()};
            const std::size_t at = std::min(places[i % 4], whole.size() - 1);
            bytes[at] = static_cast<char>(i % 7 == 0 ? 0xFF : i % 7 == 1 ? 0 : random());
            description += " byte " + std::to_string(at) + " = " +
                           std::to_string(static_cast<unsigned char>(bytes[at]));
        }
        write_content(changed, bytes);
        INFO(name << ", seed 12, case " << i << ":" << description);
        CHECK(complaint(read_all(changed), "changed.laz") == "");
        CHECK(complaint(read_index(changed)) == "");
    }
}

}  // namespace

TEST_CASE("files cut or changed at random are refused, or read whole",
          "[voxelserver][lidar][damage]") {
    const TemporaryFolder folder;
    struct Case {
        const char* name;
        int format;
        std::size_t points;
    };
    const auto c = GENERATE(
        values<Case>({{"six.laz", 6, 60'000}, {"three.laz", 3, 60'000}, {"seven.las", 7, 3'000}}));
    DYNAMIC_SECTION(c.name) {
        const fs::path file = folder.path() / c.name;
        write_sample(file, c.format, c.points,
                     c.format >= 6 ? geo::Crs::from_text("EPSG:3794").wkt() : "");
        check_cuts(c.name, file);
        check_changes(c.name, file);
    }
}

TEST_CASE("every kind of file cut or changed at random is refused, or read whole",
          "[voxelserver][lidar][damage][data][all]") {
    if (!files_are_there())
        return;
    for (const Kind& kind : kKinds) {
        check_cuts(kind.name, kShared / kind.file);
        check_changes(kind.name, kShared / kind.file);
    }
}

TEST_CASE(
    "stretches of equal bytes in compressed points end in an error or in points, not in a crash",
    "[voxelserver][lidar][damage]") {
    const int format = GENERATE(3, 7);
    const TemporaryFolder folder;
    const fs::path good = folder.path() / "good.laz";
    const fs::path changed = folder.path() / "changed.laz";
    {
        lidar::LasWriterOptions options;
        options.point_format = format;
        options.scale = {0.01, 0.01, 0.01};
        lidar::LasWriter writer(good, options);
        std::mt19937 random(14);
        for (int i = 0; i < 120'000; ++i) {
            lidar::LasWritePoint p;
            p.x = i % 1000;
            p.y = i / 1000 + 0.01 * static_cast<double>(random() % 100);
            p.z = 0.01 * static_cast<double>(random() % 3000);
            p.return_number = p.return_count = 1;
            p.classification = static_cast<std::uint8_t>(random() % 7);
            p.gps_time_s = i * 1e-5 + static_cast<double>(random() % 3);
            writer.write(p);
        }
        writer.close();
    }
    const std::string whole = read_content(good);
    std::mt19937 random(15);
    // Where the packed bytes of a chunk begin: behind its first point and, from format 6 on, its
    // counts.
    const auto info = lidar::read_las_info(good);
    const lidar::ChunkTable& chunks = *info.chunks;
    const std::size_t packed = chunks.first_byte[1] + chunks.record_bytes +
                               (chunks.layers > 0 ? 4 + 4 * std::size_t{chunks.layers} : 0);
    for (int i = 0; i < 12; ++i) {
        std::string bytes = whole;
        // Some from within a chunk to its end: whole layers of the formats that have them.
        const bool to_end = i % 3 == 1;
        const std::size_t chunk_end = chunks.first_byte[2];
        const std::size_t from =
            packed + (chunk_end - packed) * static_cast<std::size_t>(i - i % 3) / 12;
        const std::size_t length = to_end ? chunk_end - from : std::size_t{1000} << random() % 6;
        const std::size_t at =
            to_end ? from : whole.size() / 20 + random() % (whole.size() * 9 / 10);
        const char value = i % 3 == 0 ? char{0} : static_cast<char>(0xFF);
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    std::min(length, whole.size() - at), value);
        write_content(changed, bytes);
        INFO("format " << format << ", seed 15, case " << i << ": " << length << " bytes from "
                       << at << " of " << whole.size() << " are " << int{value});
        CHECK(complaint(read_all(changed)) == "");
        CHECK(complaint(in_child(
                  [&] { (void)lidar::sample_points(lidar::read_las_info(changed), 4096); })) == "");
    }
}

TEST_CASE("a .lax file cut or changed at random is refused, or loses no point",
          "[voxelserver][lidar][damage][lax][data]") {
    if (!files_are_there())
        return;
    const TemporaryFolder folder;
    fs::copy_file(kShared / "lazpy/testdata/pt1_v2.laz", folder.path() / "a.laz");
    const std::string whole = read_content(kShared / "lazpy/testdata/pt1_v2.lax");
    std::mt19937 random(13);
    for (int i = 0; i < 60; ++i) {
        std::string bytes = whole.substr(0, i % 3 == 0 ? random() % whole.size() : whole.size());
        const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
        if (i % 3 != 0)
            bytes[at] = static_cast<char>(i % 3 == 1 ? 0xFF : random());
        write_content(folder.path() / "a.lax", bytes);
        INFO("seed 13, case " << i << ": " << bytes.size() << " bytes, byte " << at << " changed");
        const Outcome outcome = read_index(folder.path() / "a.laz");
        CHECK(complaint(outcome) == "");
        if (i % 3 == 0)
            CHECK(outcome.kind == Outcome::Kind::kError);
        // Whatever lies next to it, the point cloud itself is read.
        if (i % 30 == 0)
            CHECK(read_all(folder.path() / "a.laz").kind == Outcome::Kind::kDone);
    }
}
