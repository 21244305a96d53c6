// The three ways to the points of a file: whole, prepared, in parts.
#include <algorithm>
#include <atomic>
#include <fstream>
#include <new>
#include <set>
#include <thread>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/make/voxelize/columns/square_reader.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;
using voxelize::LoadedSquare;
using voxelize::PreparedSquares;
using voxelize::WholeDecoder;
namespace fs = std::filesystem;

namespace {

/// A strip of 30 x 400 m from south to north, as a file of four chunks; written once.
struct Strip {
    TemporaryFolder folder;
    fs::path file = folder.path() / "strip.laz";

    static const Strip& get() {
        static const Strip made;
        return made;
    }

private:
    Strip() {
        Cloud cloud;
        cloud.cover(0, 0, 30, 400, 0.25, 2,
                    [](double e, double n) { return 100 + e / 10 + n / 20; });
        cloud.write(file);
    }
};

/// A reader of a world of one file.
class OneFile {
public:
    explicit OneFile(const LidarWorldOptions& options)
        : m_sources(open_sources(options, m_settings)),
          m_report(m_sources.files, m_sources.classes),
          m_reader(options, m_sources.files, share_memory(options.memory_bytes, m_sources.files),
                   {m_sources.frame, m_sources.classes, m_settings, m_times}, m_report) {}

    [[nodiscard]] SquareReader& reader() { return m_reader; }
    [[nodiscard]] SquareState state() const { return m_reader.find_state(0).first; }
    [[nodiscard]] std::string error() const { return m_reader.find_state(0).second; }
    [[nodiscard]] std::uint64_t counted() const { return m_report.counts().kept; }
    [[nodiscard]] std::size_t file_points() const { return m_sources.point_count; }

    /// The rectangle of all patches of the file.
    [[nodiscard]] grid::PatchRect all() const {
        const grid::ColumnRect& b = m_sources.bounds;
        return {{b.min_x >> 6, b.min_z >> 6}, {(b.max_x >> 6) + 1, (b.max_z >> 6) + 1}};
    }
    /// The bytes of all points of some patches, in order.
    [[nodiscard]] std::multiset<std::string> points(const grid::PatchRect& wanted) {
        std::multiset<std::string> out;
        const Squares squares = m_reader.around(0, wanted);
        for (int pz = wanted.min.pz; pz < wanted.max.pz; ++pz)
            for (int px = wanted.min.px; px < wanted.max.px; ++px)
                for (const auto& square : squares)
                    for (const store::VoxelPoint& p : square->points({px, pz}))
                        out.emplace(reinterpret_cast<const char*>(&p), sizeof p);
        return out;
    }
    /// How many parts of the file have been decoded.
    [[nodiscard]] std::uint64_t decoded() const {
        for (const auto& stage : m_times.stages())
            if (stage.name == "point load")
                return stage.count;
        return 0;
    }

private:
    util::StageTimes m_times;
    Settings m_settings;
    Sources m_sources;
    LoadReport m_report;
    SquareReader m_reader;
};

grid::PatchRect patch_at(double east, double north) {
    const grid::PatchKey key{voxel_x(east) >> 6, voxel_z(north) >> 6};
    return {key, {key.px + 1, key.pz + 1}};
}

struct Fixture {
    TemporaryFolder folder;
    store::SquareFolder squares{folder.path(), std::uint64_t{1} << 30};
    const SquarePtr square = made_square(1, 5000, 12);
    const std::vector<std::string> names{"a", "b"};

    /// Changes a point of the square of the first file on disk.
    void damage() const {
        const fs::path file = files_ending(folder.path(), ".square").at(0);
        std::string bytes = read_content(file);
        bytes[bytes.size() - 1000] ^= 1;
        write_content(file, bytes);
    }
};

LoadedSquare loaded(std::size_t file) {
    return {made_square(static_cast<unsigned>(file) + 1, 10, 1), made_index(1, 3)};
}

SquarePtr keep_as_it_is(std::size_t, const LoadedSquare& square) {
    return square.square;
}

}  // namespace

TEST_CASE("a file is decoded whole the first time, and kept", "[voxelserver][voxelize][reader]") {
    OneFile file(OpenWorld::with(Strip::get().file));
    CHECK(file.state() == SquareState::kFetched);
    const Squares first = file.reader().around(0, patch_at(5, 5));
    REQUIRE(first.size() == 1);
    CHECK(file.decoded() == 4);
    CHECK(file.state() == SquareState::kPrepared);
    CHECK(file.counted() == file.file_points());
    CHECK(file.reader().around(0, patch_at(5, 395)) == first);
    CHECK(file.decoded() == 4);
}

TEST_CASE("a file that was prepared is mapped, with the same points, and counted",
          "[voxelserver][voxelize][reader]") {
    const TemporaryFolder cache;
    auto options = OpenWorld::with(Strip::get().file);
    const auto wanted = OneFile(options).points(OneFile(options).all());
    options.cache_dir = cache.path();
    OneFile first(options);
    CHECK(first.points(first.all()) == wanted);
    CHECK(files_ending(cache.path() / "squares", ".square").size() == 1);
    OneFile second(options);
    CHECK(second.state() == SquareState::kPrepared);
    CHECK(second.points(second.all()) == wanted);
    CHECK(second.decoded() == 0);
    CHECK(second.counted() == second.file_points());
}

TEST_CASE("a file that does not fit is read in parts, never whole, with the same points",
          "[voxelserver][voxelize][reader]") {
    auto options = OpenWorld::with(Strip::get().file);
    const auto wanted = OneFile(options).points(OneFile(options).all());
    REQUIRE(wanted.size() == 192'000);
    const TemporaryFolder cache;
    options.cache_dir = cache.path();
    options.memory_bytes = 1;
    OneFile file(options);
    CHECK(file.state() == SquareState::kFetched);
    CHECK(file.points(file.all()) == wanted);
    CHECK(file.state() == SquareState::kPrepared);
    CHECK(files_ending(cache.path() / "squares", ".square").empty());
}

TEST_CASE("a file with an index is read in parts until half of it would have been decoded",
          "[voxelserver][voxelize][reader]") {
    const TemporaryFolder cache;
    auto options = OpenWorld::with(Strip::get().file);
    options.cache_dir = cache.path();
    const auto wanted = OneFile(options).points(patch_at(5, 5));
    const fs::path square = files_ending(cache.path() / "squares", ".square").at(0);
    fs::remove(square);
    OneFile file(options);
    CHECK(file.points(patch_at(5, 5)) == wanted);
    CHECK(file.decoded() == 1);
    CHECK(file.state() == SquareState::kFetched);
    CHECK_FALSE(fs::exists(square));
    CHECK(file.points(file.all()).size() == file.file_points());
    CHECK(fs::exists(square));
    CHECK(file.state() == SquareState::kPrepared);
}

TEST_CASE("a file that cannot be decoded has failed, and is not tried again",
          "[voxelserver][voxelize][reader][damage]") {
    const TemporaryFolder folder;
    const fs::path path = folder.path() / "damaged.laz";
    fs::copy(Strip::get().file, path);
    OneFile file(OpenWorld::with(path));
    const auto size = fs::file_size(path);
    std::fstream(path, std::ios::in | std::ios::out | std::ios::binary)
            .seekp(static_cast<std::streamoff>(size / 3))
        << std::string(size / 3, '\x5a');
    CHECK_THROWS_WITH(file.points(file.all()), contains("damaged.laz"));
    const std::string reason = file.error();
    const std::uint64_t decoded = file.decoded();
    CHECK(file.state() == SquareState::kFailed);
    CHECK_THAT(reason, contains("damaged.laz"));
    CHECK_THROWS_WITH(file.points(file.all()), reason);
    CHECK(file.decoded() == decoded);
}

TEST_CASE("without a cache folder nothing is prepared", "[voxelserver][voxelize][prepared]") {
    PreparedSquares prepared(nullptr, {"", ""});
    const SquarePtr square = made_square(1, 100, 2);
    CHECK_FALSE(prepared.holds(1));
    CHECK(prepared.find(1) == nullptr);
    CHECK(prepared.keep(1, square) == square);
    CHECK_FALSE(prepared.holds(1));
}

TEST_CASE("a square that was kept is found by later runs, under its own file",
          "[voxelserver][voxelize][prepared]") {
    Fixture f;
    PreparedSquares first(&f.squares, f.names);
    CHECK(first.find(0) == nullptr);
    const SquarePtr mapped = first.keep(0, f.square);
    CHECK(mapped != f.square);
    CHECK(same_square(*mapped, *f.square));
    PreparedSquares second(&f.squares, f.names);
    CHECK(second.holds(0));
    CHECK_FALSE(second.holds(1));
    REQUIRE(second.find(0));
    CHECK(same_square(*second.find(0), *f.square));
    CHECK(second.find(1) == nullptr);
}

TEST_CASE("a damaged square counts as absent, with a warning",
          "[voxelserver][voxelize][prepared][damage]") {
    Fixture f;
    const Warnings warnings;
    (void)PreparedSquares(&f.squares, f.names).keep(0, f.square);
    f.damage();
    PreparedSquares prepared(&f.squares, f.names);
    CHECK(prepared.holds(0));
    CHECK(prepared.find(0) == nullptr);
    CHECK(warnings.count("it is made again") == 1);
    CHECK(prepared.keep(0, f.square) != nullptr);
    CHECK(prepared.find(0));
    CHECK(warnings.count("") == 1);
}

TEST_CASE("all checksums of a square are verified once in a run, then those of what is read",
          "[voxelserver][voxelize][prepared][damage]") {
    Fixture f;
    const Warnings warnings;
    PreparedSquares prepared(&f.squares, f.names);
    (void)prepared.keep(0, f.square);
    REQUIRE(prepared.find(0));
    f.damage();
    const SquarePtr found = prepared.find(0);
    REQUIRE(found);
    CHECK(warnings.text().empty());
    CHECK_THROWS_AS(same_square(*found, *f.square), util::Error);
}

TEST_CASE("a file is decoded, and what keeps it says which square to use",
          "[voxelserver][voxelize][decoder]") {
    const SquarePtr mapped = made_square(9, 10, 1);
    std::vector<std::size_t> files;
    WholeDecoder decoder(2, loaded, [&](std::size_t file, const LoadedSquare& given) {
        files.push_back(file);
        CHECK(same_square(*given.square, *loaded(file).square));
        CHECK(same_index(given.index, made_index(1, 3)));
        return mapped;
    });
    CHECK(decoder.decode(1) == mapped);
    CHECK(decoder.decode(0) == mapped);
    CHECK(files == std::vector<std::size_t>{1, 0});
}

TEST_CASE("a damaged file is tried once, and fails with the same message each time",
          "[voxelserver][voxelize][decoder][damage]") {
    int tries = 0;
    WholeDecoder decoder(
        2,
        [&](std::size_t file) {
            ++tries;
            if (file == 0)
                throw util::Error("read a.laz: cut short");
            return loaded(file);
        },
        keep_as_it_is);
    for (int i = 0; i < 3; ++i)
        CHECK_THROWS_WITH(decoder.decode(0), "read a.laz: cut short");
    CHECK(tries == 1);
    CHECK(decoder.decode(1));
}

TEST_CASE("a failure that is not the file's is not cached", "[voxelserver][voxelize][decoder]") {
    int tries = 0;
    SECTION("no memory to decode it") {
        WholeDecoder decoder(
            1,
            [&](std::size_t file) {
                if (++tries == 1)
                    throw std::bad_alloc();
                return loaded(file);
            },
            keep_as_it_is);
        CHECK_THROWS_AS(decoder.decode(0), std::bad_alloc);
        CHECK(decoder.decode(0));
    }
    SECTION("it could not be kept") {
        WholeDecoder decoder(1, loaded, [&](std::size_t, const LoadedSquare& given) {
            if (++tries == 1)
                throw util::Error("write the square: no space left");
            return given.square;
        });
        CHECK_THROWS_AS(decoder.decode(0), util::Error);
        CHECK(decoder.decode(0));
    }
}

TEST_CASE("one file at a time is decoded and kept", "[voxelserver][voxelize][decoder]") {
    constexpr std::size_t kFiles = 4;
    std::atomic<int> running{0};
    std::atomic<int> max_running{0};
    WholeDecoder decoder(
        kFiles,
        [&](std::size_t file) {
            max_running = std::max(max_running.load(), ++running);
            std::this_thread::yield();
            return loaded(file);
        },
        [&](std::size_t, const LoadedSquare& given) {
            std::this_thread::yield();
            --running;
            return given.square;
        });
    std::vector<std::thread> threads;
    for (std::size_t file = 0; file < kFiles; ++file)
        threads.emplace_back([&, file] {
            for (int i = 0; i < 100; ++i)
                (void)decoder.decode(file);
        });
    for (std::thread& thread : threads)
        thread.join();
    CHECK(max_running == 1);
}
