// Files that lie: each is read in a child of its own, so that a crash or a hang is a failure with
// the file's name. In an executable of its own: children are forked, so there must be no threads.
#include <algorithm>
#include <cstring>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/lidar/child.hpp"
#include "tests/voxelserver/lidar/las_bytes.hpp"
#include "tests/voxelserver/lidar/shared_files.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

Outcome read_in_child(const fs::path& file) {
    return in_child([&] {
        const auto info = lidar::read_las_info(file);
        for (const auto& range : lidar::split_by_chunk(info, 100'000))
            lidar::read_las_points(info, range, [](const pointcloud::Point&) {});
    });
}

/// Reads, or throws an Error of one line that names the file. @return what is wrong, empty when
/// nothing is
std::string complaint(const fs::path& file, const Outcome& outcome) {
    switch (outcome.kind) {
        case Outcome::Kind::kDone: return {};
        case Outcome::Kind::kError:
            if (outcome.text.find(file.filename().string()) == std::string::npos)
                return "the message does not name the file: " + outcome.text;
            if (outcome.text.find('\n') != std::string::npos)
                return "the message has several lines: " + outcome.text;
            return {};
        case Outcome::Kind::kOther: return "threw something else than an Error: " + outcome.text;
        default: return "crashed: " + outcome.text;
    }
}

}  // namespace

TEST_CASE("a child that crashes, hangs or takes too much is recognised",
          "[voxelserver][lidar][child]") {
    CHECK(in_child([] {}).kind == Outcome::Kind::kDone);
    CHECK(in_child([] { throw util::Error("no"); }).text == "no");
    CHECK(in_child([] { std::raise(SIGSEGV); }).kind == Outcome::Kind::kCrashed);
    CHECK(in_child(
              [] {
                  volatile int i = 0;
                  while (i == 0) {
                  }
              },
              rlim_t{1} << 30, 1)
              .kind == Outcome::Kind::kCrashed);
    if (kSanitized)
        return;  // without a limit on memory
    CHECK(in_child([] { std::vector<char> much(std::size_t{3} << 30, 'x'); }).kind ==
          Outcome::Kind::kOther);
}

TEST_CASE("files known to be bad are refused with the reason", "[voxelserver][lidar][data]") {
    if (!fs::exists(kShared)) {
        WARN("skipped: " << kShared.string() << " is not there");
        return;
    }
    struct Case {
        const char* file;
        bool refused;
    };
    const auto c = GENERATE(values<Case>({
        {"lazpy/testdata/malformed/chunk_table_11gb.laz", true},
        {"lazpy/testdata/malformed/empty_layer_sigfpe.laz", true},
        {"lazpy/testdata/malformed/layer_sizes_11gb.laz", true},
        {"lazpy/testdata/malformed/seek_past_end.laz", true},
        {"pdal/las/garbage_nVariableLength.las", true},
        {"pdal/las/bad_vlr_count.las", true},
        {"ign-pdal-tools/check_las/Semis_2022_0906_6665_LA93_IGN69_nok.laz", true},
        {"pdal/las/bad-geotiff-keys.las", false},
        {"pdal/las/permutations/1.2-no-points.las", false},
        {"pdal/las/spurious.las", false},
        {"laspy/tests/data/append-bug-cpy.laz", false},
    }));
    DYNAMIC_SECTION(c.file) {
        if (!fs::exists(kShared / c.file)) {
            WARN("skipped: not there");
            return;
        }
        const Outcome outcome = read_in_child(kShared / c.file);
        INFO(outcome.text);
        CHECK(complaint(kShared / c.file, outcome).empty());
        if (c.refused)
            CHECK(outcome.kind == Outcome::Kind::kError);
    }
}

TEST_CASE("every file of the zoo is read, or refused in one line", "[voxelserver][lidar][data]") {
    if (!fs::exists(kShared)) {
        WARN("skipped: " << kShared.string() << " is not there");
        return;
    }
    int files = 0;
    for (const char* set :
         {"pasture", "lazpy", "laspy", "pdal", "copcjs", "ign-pdal-tools/check_las"}) {
        if (!fs::exists(kShared / set))
            continue;
        for (const auto& entry : fs::recursive_directory_iterator(kShared / set)) {
            if (entry.path().extension() != ".las" && entry.path().extension() != ".laz")
                continue;
            ++files;
            INFO(entry.path().string());
            CHECK(complaint(entry.path(), read_in_child(entry.path())) == "");
        }
    }
    CHECK(files > 100);
}

TEST_CASE("a file cut short anywhere is refused, unless all its points are there",
          "[voxelserver][lidar]") {
    const TemporaryFolder folder;
    struct Case {
        const char* name;
        int format;
        std::size_t points;
    };
    const auto c = GENERATE(values<Case>(
        {{"whole.laz", 6, 120'000}, {"whole3.laz", 3, 60'000}, {"whole.las", 6, 3'000}}));
    DYNAMIC_SECTION(c.name) {
        write_sample(folder.path() / c.name, c.format, c.points,
                     c.format >= 6 ? geo::Crs::from_text("EPSG:3794").wkt() : "");
        const std::string whole = file_bytes(folder.path() / c.name);
        std::mt19937 random(8);
        const auto cut = folder.path() / (std::string("cut_") + c.name);
        for (int i = 0; i < 25; ++i) {
            const std::size_t length = i < 5 ? whole.size() - 1 - static_cast<std::size_t>(i) * 3
                                             : random() % whole.size();
            write_bytes(cut, whole.substr(0, length));
            const Outcome outcome = read_in_child(cut);
            INFO(length << " of " << whole.size() << " bytes: " << outcome.text);
            CHECK(complaint(cut, outcome) == "");
            if (outcome.kind != Outcome::Kind::kDone)
                continue;
            // LASzip finds chunks without the last bytes of their table: then every point must be
            // there.
            CHECK(whole.size() - length < 16);
            const auto points = all_points(cut);
            const auto wanted = all_points(folder.path() / c.name);
            REQUIRE(points.size() == wanted.size());
            CHECK(std::equal(points.begin(), points.end(), wanted.begin(), same_point));
        }
    }
}

TEST_CASE(
    "a header with any byte changed is read or refused, never a crash, a hang or a flood of memory",
    "[voxelserver][lidar][fuzz]") {
    const TemporaryFolder folder;
    struct Case {
        const char* name;
        int format;
    };
    const auto c = GENERATE(values<Case>({{"six.laz", 6}, {"three.laz", 3}, {"seven.las", 7}}));
    DYNAMIC_SECTION(c.name) {
        write_sample(folder.path() / c.name, c.format, 2'000,
                     c.format >= 6 ? geo::Crs::from_text("EPSG:3794").wkt() : "");
        const std::string whole = file_bytes(folder.path() / c.name);
        std::uint32_t points_at = 0;
        std::memcpy(&points_at, whole.data() + 96, sizeof points_at);
        std::mt19937 random(static_cast<unsigned>(c.format));
        const auto file = folder.path() / (std::string("changed_") + c.name);
        for (int i = 0; i < 100; ++i) {
            std::string bytes = whole;
            std::string description;
            // Mostly where numbers that lead somewhere stand; else anywhere before the points and
            // in their first bytes.
            for (int changes = 1 + i % 3; changes > 0; --changes) {
                const std::size_t at =
                    i % 2 == 0 ? 90 + random() % 60 : random() % (points_at + 40);
                bytes[at] = static_cast<char>(i % 5 == 0 ? 0xFF : random());
                description += " byte " + std::to_string(at) + " = " +
                               std::to_string(static_cast<unsigned char>(bytes[at]));
            }
            write_bytes(file, bytes);
            INFO("seed " << c.format << ", case " << i << ":" << description);
            CHECK(complaint(file, read_in_child(file)) == "");
        }
    }
}

TEST_CASE("compressed points with any byte changed are read or refused",
          "[voxelserver][lidar][fuzz]") {
    const TemporaryFolder folder;
    const int format = GENERATE(3, 6);
    write_sample(folder.path() / "good.laz", format, 5'000);
    const std::string whole = file_bytes(folder.path() / "good.laz");
    std::uint32_t points_at = 0;
    std::memcpy(&points_at, whole.data() + 96, sizeof points_at);
    std::mt19937 random(17);
    const auto file = folder.path() / "changed.laz";
    for (int i = 0; i < 100; ++i) {
        std::string bytes = whole;
        const std::size_t at = i % 4 == 0   ? whole.size() - 1 - random() % 24
                               : i % 4 == 1 ? points_at + random() % 120
                                            : points_at + random() % (whole.size() - points_at);
        bytes[at] = static_cast<char>(random());
        write_bytes(file, bytes);
        INFO("format " << format << ", byte " << at << " of " << whole.size() << " = "
                       << static_cast<int>(static_cast<unsigned char>(bytes[at])));
        CHECK(complaint(file, read_in_child(file)) == "");
    }
}
