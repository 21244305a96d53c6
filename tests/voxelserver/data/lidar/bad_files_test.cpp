// Files that lie: each is read in a child of its own, so that a crash or a hang is a failure with
// the file's name. In an executable of its own: children are forked, so there must be no threads.
// COPC hierarchies and .lax files lie in ways that random damage seldom finds.
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/child.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "tests/voxelserver/data/lidar/shared_files.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kInfoAt =
    375 + 54;  ///< of a COPC file: its record is the first one behind the header

struct Bytes {
    std::string all;
    template <class T>
    T get(std::size_t at) const {
        T value;
        std::memcpy(&value, all.data() + at, sizeof value);
        return value;
    }
    template <class T>
    void set(std::size_t at, T value) {
        std::memcpy(all.data() + at, &value, sizeof value);
    }
    std::size_t root() const { return static_cast<std::size_t>(get<std::uint64_t>(kInfoAt + 40)); }
    /// Byte of field 0 level, 4 x, 8 y, 12 z, 16 offset, 24 size, 28 points of an entry of the root
    /// page.
    std::size_t entry(std::size_t i, std::size_t field) const { return root() + 32 * i + field; }
};

Outcome index_in_child(const fs::path& file) {
    return in_child([&] { (void)lidar::read_spatial_index(lidar::read_las_info(file)); },
                    rlim_t{1} << 30, 5);
}

}  // namespace

TEST_CASE("a child that crashes, hangs or takes too much is recognised",
          "[voxelserver][lidar][child]") {
    CHECK(in_child([] {}).kind == Outcome::Kind::kDone);
    CHECK(in_child([] { throw util::Error("no"); }).text == "no");
    CHECK(in_child([] { std::raise(SIGSEGV); }).kind == Outcome::Kind::kCrashed);
    const auto hang = [] {
        for (volatile int i = 0; i == 0;) {
        }
    };
    CHECK(in_child(hang, rlim_t{1} << 30, 1).kind == Outcome::Kind::kCrashed);
    if (kSanitized)
        return;  // without a limit on memory
    CHECK(in_child([] { std::vector<char> much(std::size_t{3} << 30, 'x'); }).kind ==
          Outcome::Kind::kOther);
}

TEST_CASE("every file of the zoo is read, or refused in one line, those known to be bad always",
          "[voxelserver][lidar][data]") {
    if (!there(kShared))
        return;
    std::set<std::string> bad{"chunk_table_11gb.laz",
                              "empty_layer_sigfpe.laz",
                              "layer_sizes_11gb.laz",
                              "seek_past_end.laz",
                              "garbage_nVariableLength.las",
                              "bad_vlr_count.las",
                              "Semis_2022_0906_6665_LA93_IGN69_nok.laz"};
    int files = 0;
    for (const char* set :
         {"pasture", "lazpy", "laspy", "pdal", "copcjs", "ign-pdal-tools/check_las"}) {
        if (!there(kShared / set))
            continue;
        for (const auto& entry : fs::recursive_directory_iterator(kShared / set)) {
            const fs::path& file = entry.path();
            if (file.extension() != ".las" && file.extension() != ".laz")
                continue;
            ++files;
            const Outcome outcome = in_child([&] {
                const auto info = lidar::read_las_info(file);
                for (const auto& range : lidar::split_by_chunk(info, 100'000))
                    lidar::read_las_points(info, range, [](const pointcloud::Point&) {});
            });
            INFO(file.string() << ": " << outcome.text);
            CHECK(complaint(outcome, file.filename().string()) == "");
            if (bad.erase(file.filename().string()) > 0)
                CHECK(outcome.kind == Outcome::Kind::kError);
        }
    }
    CHECK(files > 100);
    CHECK(bad.empty());
}

TEST_CASE("a COPC hierarchy that lies is refused, and the points can still be read",
          "[voxelserver][lidar][copc][data]") {
    if (!there(kShared / "copcjs"))
        return;
    struct Case {
        const char* name;
        std::function<void(Bytes&)> lie;
    };
    const std::vector<Case> cases = {
        {"a page that holds itself",
         [](Bytes& b) {
             b.set(b.entry(1, 28), std::int32_t{-1});
             b.set(b.entry(1, 16), std::uint64_t{b.root()});
             b.set(b.entry(1, 24), b.get<std::int32_t>(kInfoAt + 48));
         }},
        {"pages one within the other",
         [](Bytes& b) {
             b.set(b.entry(1, 28), std::int32_t{-1});
             b.set(b.entry(1, 16), std::uint64_t{b.root() + 32});
             b.set(b.entry(1, 24), b.get<std::int32_t>(kInfoAt + 48) - 32);
         }},
        {"a page beyond the file",
         [](Bytes& b) {
             b.set(b.entry(1, 28), std::int32_t{-1});
             b.set(b.entry(1, 16), std::uint64_t{1} << 50);
             b.set(b.entry(1, 24), std::int32_t{32});
         }},
        {"a page of negative size",
         [](Bytes& b) {
             b.set(b.entry(1, 28), std::int32_t{-1});
             b.set(b.entry(1, 24), std::int32_t{-32});
         }},
        {"a root page of nothing", [](Bytes& b) { b.set(kInfoAt + 48, std::uint64_t{0}); }},
        {"a root page of a million gigabytes",
         [](Bytes& b) { b.set(kInfoAt + 48, std::uint64_t{1} << 50); }},
        {"a root page as large as the file",
         [](Bytes& b) {
             b.set(kInfoAt + 40, std::uint64_t{0});
             b.set(kInfoAt + 48, std::uint64_t{b.all.size() / 32 * 32});
         }},
        {"a root page of half entries",
         [](Bytes& b) { b.set(kInfoAt + 48, b.get<std::uint64_t>(kInfoAt + 48) - 16); }},
        {"a root page beyond the file",
         [](Bytes& b) { b.set(kInfoAt + 40, std::numeric_limits<std::uint64_t>::max() - 8); }},
        {"a point too many",
         [](Bytes& b) { b.set(b.entry(2, 28), b.get<std::int32_t>(b.entry(2, 28)) + 1); }},
        {"two thousand million points",
         [](Bytes& b) { b.set(b.entry(2, 28), std::numeric_limits<std::int32_t>::max()); }},
        {"a negative number of points", [](Bytes& b) { b.set(b.entry(2, 28), std::int32_t{-2}); }},
        {"a node without its points", [](Bytes& b) { b.set(b.entry(2, 28), std::int32_t{0}); }},
        {"a node of negative size", [](Bytes& b) { b.set(b.entry(2, 24), std::int32_t{-1}); }},
        {"a node a byte short",
         [](Bytes& b) { b.set(b.entry(2, 24), b.get<std::int32_t>(b.entry(2, 24)) - 1); }},
        {"a node between chunks",
         [](Bytes& b) { b.set(b.entry(2, 16), b.get<std::uint64_t>(b.entry(2, 16)) + 1); }},
        {"a node beyond the file", [](Bytes& b) { b.set(b.entry(2, 16), std::uint64_t{1} << 60); }},
        {"two nodes with the same points",
         [](Bytes& b) { b.all.replace(b.entry(2, 16), 16, b.all.substr(b.entry(1, 16), 16)); }},
        {"a level too deep", [](Bytes& b) { b.set(b.entry(2, 0), std::int32_t{64}); }},
        {"a negative level", [](Bytes& b) { b.set(b.entry(2, 0), std::int32_t{-1}); }},
        {"a node outside of the cube",
         [](Bytes& b) { b.set(b.entry(2, 4), std::int32_t{1} << 29); }},
        {"a cube of no size", [](Bytes& b) { b.set(kInfoAt + 24, 0.0); }},
        {"a cube that is no number", [](Bytes& b) { b.set(kInfoAt + 24, std::nan("")); }},
        {"a cube elsewhere",
         [](Bytes& b) {
             b.set(kInfoAt, b.get<double>(kInfoAt) + 3 * b.get<double>(kInfoAt + 24));
         }},
    };
    const TemporaryFolder folder;
    const Bytes good{read_content(kShared / "copcjs" / "ellipsoid.copc.laz")};
    const auto wanted = all_raw(lidar::read_las_info(kShared / "copcjs" / "ellipsoid.copc.laz"));
    REQUIRE(good.get<std::uint64_t>(kInfoAt + 48) >= 3 * 32);
    for (const Case& c : cases) {
        INFO(c.name);
        Bytes bytes = good;
        c.lie(bytes);
        const fs::path file = folder.path() / "liar.copc.laz";
        write_content(file, bytes.all);
        const Outcome outcome = index_in_child(file);
        INFO(outcome.text);
        CHECK(outcome.kind == Outcome::Kind::kError);
        CHECK(outcome.text.find("liar.copc.laz") != std::string::npos);
        CHECK(all_raw(lidar::read_las_info(file)) == wanted);
    }
}

TEST_CASE("a .lax file that lies is refused", "[voxelserver][lidar][lax][data]") {
    if (!there(kShared / "lazpy"))
        return;
    constexpr std::size_t kLevels = 24;
    constexpr std::size_t kMinX = 36;
    constexpr std::size_t kCells = 60;
    constexpr std::size_t kCell = 64;
    constexpr std::size_t kIntervals = 68;
    constexpr std::size_t kPoints = 72;
    constexpr std::size_t kFirst = 76;
    constexpr std::size_t kLast = 80;
    struct Case {
        const char* name;
        std::function<void(Bytes&)> lie;
    };
    const std::vector<Case> cases = {
        {"no index at all", [](Bytes& b) { b.all = "LASX"; }},
        {"empty", [](Bytes& b) { b.all.clear(); }},
        {"of another kind", [](Bytes& b) { b.set(12, std::uint32_t{1}); }},
        {"levels without end", [](Bytes& b) { b.set(kLevels, std::uint32_t{0xFFFFFFFF}); }},
        {"bounds that are no number", [](Bytes& b) { b.set(kMinX, std::nanf("")); }},
        {"four thousand million cells", [](Bytes& b) { b.set(kCells, std::uint32_t{0xFFFFFFFF}); }},
        {"a cell less", [](Bytes& b) { b.set(kCells, b.get<std::uint32_t>(kCells) - 1); }},
        {"a negative cell", [](Bytes& b) { b.set(kCell, std::int32_t{-1}); }},
        {"a cell below the tree",
         [](Bytes& b) { b.set(kCell, std::numeric_limits<std::int32_t>::max()); }},
        {"intervals without end", [](Bytes& b) { b.set(kIntervals, std::uint32_t{0xFFFFFFFF}); }},
        {"points too many", [](Bytes& b) { b.set(kPoints, b.get<std::uint32_t>(kPoints) + 1); }},
        {"an interval backwards", [](Bytes& b) { b.set(kFirst, b.get<std::uint32_t>(kLast) + 1); }},
        {"an interval beyond the points",
         [](Bytes& b) { b.set(kLast, std::uint32_t{0xFFFFFFFF}); }},
        {"bytes behind the last cell", [](Bytes& b) { b.all += "more"; }},
    };
    const TemporaryFolder folder;
    fs::copy_file(kShared / "lazpy/testdata/pt1_v2.laz", folder.path() / "a.laz");
    const Bytes good{read_content(kShared / "lazpy/testdata/pt1_v2.lax")};
    REQUIRE(good.all.substr(16, 4) == "LASQ");
    REQUIRE(good.all.substr(52, 4) == "LASV");
    for (const Case& c : cases) {
        INFO(c.name);
        Bytes bytes = good;
        c.lie(bytes);
        write_content(folder.path() / "a.lax", bytes.all);
        const Outcome outcome = index_in_child(folder.path() / "a.laz");
        INFO(outcome.text);
        CHECK(outcome.kind == Outcome::Kind::kError);
        CHECK(outcome.text.find("a.lax") != std::string::npos);
    }
}
