// The three ways to the points of a file: whole, prepared, in parts.
#include "voxelserver/make/voxelize/columns/square_reader.hpp"

#include <fstream>
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;
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
        : m_classes(load_class_table(options.classes)),
          m_sources(open_sources(options, m_classes, m_settings)),
          m_report(m_sources.files, m_classes),
          m_reader(options, m_sources.files, share_memory(options.memory_bytes, m_sources.files),
                   {m_sources.frame, m_classes, m_settings, m_times}, m_report) {}

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
    ClassTable m_classes;
    Sources m_sources;
    LoadReport m_report;
    SquareReader m_reader;
};

grid::PatchRect patch_at(double east, double north) {
    const grid::PatchKey key{voxel_x(east) >> 6, voxel_z(north) >> 6};
    return {key, {key.px + 1, key.pz + 1}};
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
