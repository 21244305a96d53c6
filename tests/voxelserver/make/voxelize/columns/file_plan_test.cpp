#include "voxelserver/make/voxelize/columns/square_reader.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/squares.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr std::uint64_t kFew = 10'000;  // points: 0.1 MiB
constexpr std::uint64_t kMany = 100'000'000;

/// A file of a square kilometre.
SquareSource make_file(std::uint64_t points) {
    SquareSource out;
    out.info.point_count = points;
    out.bounds = {0, 0, 1000, 1000};
    return out;
}

}  // namespace

TEST_CASE("squares and parts share memory by how many files fit", "[voxelserver][voxelize][plan]") {
    struct Case {
        const char* name;
        std::vector<std::uint64_t> points;  ///< of each file
        std::size_t squares_mib;
        std::size_t parts_mib;
    };
    const auto c = GENERATE(values<Case>({
        {"all fit", {kFew, kFew}, 80, 30},
        {"one does not", {kFew, kMany}, 40, 70},
        {"none fits", {kMany, kMany}, 0, 110},
        {"no file", {}, 80, 30},
    }));
    DYNAMIC_SECTION(c.name) {
        std::vector<SquareSource> files;
        for (const std::uint64_t points : c.points)
            files.push_back(make_file(points));
        const PointMemory memory = share_memory(240 * kMiB, files);
        CHECK(memory.squares == c.squares_mib * kMiB);
        CHECK(memory.parts == c.parts_mib * kMiB);
        CHECK(memory.columns == 40 * kMiB);
    }
}

TEST_CASE("what one box needs at once is there in however little memory",
          "[voxelserver][voxelize][plan]") {
    const std::vector<SquareSource> files{make_file(kFew)};
    const PointMemory memory = share_memory(1, files);
    CHECK(memory.squares == 0);
    CHECK(memory.parts == 8 * kMiB);
    CHECK(memory.columns == 16 * kMiB);
}

TEST_CASE("a file that does not fit is planned in blocks that fit a quarter of the parts",
          "[voxelserver][voxelize][plan]") {
    const std::vector<SquareSource> files{make_file(kFew), make_file(kMany)};
    for (const std::size_t parts_mib : {std::size_t{8}, std::size_t{100}, std::size_t{1000}}) {
        INFO(parts_mib);
        const auto plan = plan_files(files, {80 * kMiB, parts_mib * kMiB, 0}, nullptr);
        REQUIRE(plan.size() == 2);
        CHECK(plan[0].source == &files[0]);
        CHECK(plan[0].kept_whole);
        CHECK(plan[0].block_patches == 1);
        CHECK(plan[0].name.empty());
        CHECK_FALSE(plan[1].kept_whole);
        const double patch_bytes = kMany / 1e6 * sizeof(store::VoxelPoint) * grid::kPatchColumns;
        const auto list_patches = [](int edge) { return (edge + 2.0) * (edge + 2.0); };
        const int edge = plan[1].block_patches;
        const double quarter = static_cast<double>(parts_mib * kMiB) / 4;
        CHECK((edge == 1 || list_patches(edge) * patch_bytes <= quarter));
        CHECK(list_patches(edge + 1) * patch_bytes > 0.99 * quarter);
    }
}

TEST_CASE("the name of a square depends on what its points depend on, and on nothing else",
          "[voxelserver][voxelize][plan]") {
    const TemporaryFolder folder;
    std::vector<SquareSource> files{make_file(kFew)};
    SquareSource& file = files.front();
    file.info.path = folder.path() / "a.laz";
    file.info.crs = geo::Crs::from_text("EPSG:2154");
    write_content(file.info.path, "points");
    ClassTable classes;
    Settings settings;
    double voxel_m = 1;
    const auto name = [&] {
        const grid::Frame frame(*file.info.crs, voxel_m, 0, 0);
        const SquareRecipe recipe{frame, classes, settings};
        return plan_files(files, {80 * kMiB, 30 * kMiB, 0}, &recipe).front().name;
    };
    const std::string before = name();
    CHECK(before.starts_with("a-"));
    SECTION("the frame") {
        voxel_m = 0.5;
    }
    SECTION("the identity with which it was opened") {
        file.identity = {1, 2};
    }
    SECTION("a filter") {
        settings.points.drop_overlap = true;
    }
    SECTION("a class that is dropped") {
        classes.meaning[7].role = Role::kDrop;
    }
    SECTION("colours") {
        file.has_colour = true;
    }
    SECTION("how colours are stored") {
        file.colour_shift = 8;
    }
    SECTION("the unit of heights") {
        file.vertical_metres = 0.3048;
    }
    SECTION("the heights that are kept") {
        file.highest = 99;
    }
    SECTION("nothing of it") {
        settings.steps.bridges = false;
        classes.meaning[7].role = Role::kWater;
        CHECK(name() == before);
        return;
    }
    CHECK(name() != before);
}
