#include <fstream>
#include <set>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/box_builder.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/common/voxel/synthetic_world.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"
#include "voxelserver/out/export/core/job.hpp"
#include "voxelserver/out/export/core/journal.hpp"

using namespace terravox;
using namespace terravox::exports;
using terravox::test::contains;
using terravox::test::read_content;
using terravox::test::same_box;
using terravox::test::SyntheticWorld;
using terravox::test::TemporaryFolder;
using voxel::BoxKey;

namespace {

namespace fs = std::filesystem;

constexpr voxel::VoxelBounds kBounds{{-520, -5, 70}, {200, 300, 620}};

struct Written {
    std::uint64_t voxels;
    std::size_t holes;
};

Written write(voxel::World& world, const Part& part, const fs::path& file, int threads = 2) {
    const voxel::Palette palette;
    Meter meter("test", archive_steps(part, world.info()), true);
    Job job(world, part, file, palette, meter);
    job.name = "test";
    job.threads = threads;
    write_archive(job);
    return {job.voxels(), job.holes().size()};
}

std::unique_ptr<voxel::World> open(const fs::path& file) {
    return voxel::open_archive(voxel::archive::file_source(file));
}

template <class Each>
void each_box(const voxel::WorldInfo& info, const Each& each) {
    for (int level = 0; level < info.levels; ++level) {
        const voxel::BoxRange range = voxel::boxes_over(info.bounds, level);
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
            for (std::int32_t by = range.min.by; by < range.max.by; ++by)
                for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
                    each(BoxKey{level, bx, by, bz});
    }
}

}  // namespace

TEST_CASE("an archive of a world has the world's boxes on every level",
          "[raytracer][convert][archive]") {
    const TemporaryFolder folder;
    SyntheticWorld world(kBounds);
    const Written written = write(world, make_part(world.info(), {}), folder.path() / "a.tvx");
    CHECK(written.holes == 0);
    const auto archive = open(folder.path() / "a.tvx");
    CHECK(archive->info().bounds == kBounds);
    CHECK(archive->info().levels == world.info().levels);
    CHECK(archive->info().crs == "EPSG:3794");
    CHECK(archive->info().attribution == "nobody");
    each_box(world.info(), [&](const BoxKey& key) {
        INFO(voxel::to_string(key));
        CHECK(same_box(archive->box(key), world.box(key)));
    });
    std::uint64_t solid = 0;
    for (std::int32_t x = kBounds.min[0]; x < kBounds.max[0]; ++x)
        for (std::int32_t z = kBounds.min[2]; z < kBounds.max[2]; ++z)
            solid += static_cast<std::uint64_t>(SyntheticWorld::find_top(x, z) - kBounds.min[1]);
    CHECK(written.voxels == solid);
    CHECK_FALSE(fs::exists(folder.path() / "a.tvx.journal"));
}

TEST_CASE("the bytes of an archive depend neither on threads nor on breaks",
          "[raytracer][convert][archive]") {
    const TemporaryFolder folder;
    const fs::path one = folder.path() / "one.tvx";
    const fs::path many = folder.path() / "many.tvx";
    const fs::path broken = folder.path() / "broken.tvx";
    SyntheticWorld world(kBounds);
    const Part part = make_part(world.info(), {});
    const Written whole = write(world, part, one, 1);
    write(world, part, many, 5);
    CHECK((read_content(one) == read_content(many)));

    SyntheticWorld breaking(kBounds);
    breaking.breaks_at_bx = 0;
    CHECK_THROWS_AS(write(breaking, part, broken), std::runtime_error);
    CHECK(fs::exists(broken.string() + ".part"));
    CHECK_FALSE(fs::exists(broken));
    breaking.breaks_at_bx = 1 << 20;
    const int before = breaking.made;
    CHECK(write(breaking, part, broken).voxels == whole.voxels);
    CHECK((read_content(one) == read_content(broken)));
    CHECK(before > 0);
    CHECK(breaking.made - before < world.made / 2);  // what was written was not made again
}

TEST_CASE("what the journal says and the part does not have is begun anew",
          "[raytracer][convert][archive]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tvx";
    const fs::path good = folder.path() / "good.tvx";
    SyntheticWorld world(kBounds);
    const Part part = make_part(world.info(), {});
    write(world, part, good);
    std::ofstream(file.string() + ".journal") << "test\n100 99999999 3/0/0/1 ;\n";
    const Written written = write(world, part, file);
    CHECK((read_content(file) == read_content(good)));
    CHECK(written.voxels > 1000);
}

TEST_CASE("a box that cannot be loaded is a hole of the archive and of all above it",
          "[raytracer][convert][archive]") {
    const TemporaryFolder folder;
    SyntheticWorld world(kBounds);
    world.fails_at_bx = 2;
    const Written written = write(world, make_part(world.info(), {}), folder.path() / "a.tvx");
    CHECK(written.holes > 0);
    const auto archive = open(folder.path() / "a.tvx");
    CHECK_THROWS_WITH(archive->box({0, 2, 0, 3}), contains("not today"));
    CHECK_THROWS_WITH(archive->box({archive->info().levels - 1, 0, 0, 0}), contains("not today"));
    CHECK(archive->box({0, 1, 0, 3}) != nullptr);
}

TEST_CASE("an archive of a part and a level holds that alone, as level 0",
          "[raytracer][convert][archive]") {
    const TemporaryFolder folder;
    SyntheticWorld world(kBounds);
    const Part part = make_part(world.info(), {1, {0, -600, 200, -400}, {0, 40}});
    const Written written = write(world, part, folder.path() / "a.tvx");
    const auto archive = open(folder.path() / "a.tvx");
    CHECK(archive->info().voxel_m == 2);
    CHECK(archive->info().crs_units_per_voxel == 2);
    CHECK(archive->info().bounds == part.bounds);
    CHECK((part.bounds.min[0] == 0 && part.bounds.max[0] == 100 && part.bounds.min[2] == 200 &&
           part.bounds.max[2] == 300 && part.bounds.max[1] == 20));
    const voxel::BoxRange range = voxel::boxes_over(archive->info().bounds, 0);
    std::uint64_t solid = 0;
    for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
        for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz) {
            const auto from = world.box({1, bx, 0, bz});
            const auto to = archive->box({0, bx, 0, bz});
            REQUIRE(from);
            REQUIRE(to);
            bool same = true;
            for (int x = 0; x < 64; ++x)
                for (int z = 0; z < 64; ++z)
                    for (int y = 0; y < 256; ++y) {
                        const auto expected = part.holds(bx * 64 + x, y, bz * 64 + z)
                                                  ? from->voxel(x, y, z)
                                                  : std::nullopt;
                        same = same && to->solid(x, y, z) == expected.has_value();
                        solid += expected ? 1 : 0;
                        const bool seen = y == 255 ||
                                          !part.holds(bx * 64 + x, y + 1, bz * 64 + z) ||
                                          !from->solid(x, y + 1, z);
                        same = same && (!expected || !seen || to->voxel(x, y, z) == expected);
                    }
            CHECK(same);
        }
    CHECK(written.voxels == solid);
    CHECK(archive->box({0, -1, 0, 3}) == nullptr);
    // Above, only what lies in the part.
    std::array<std::shared_ptr<const voxel::Box>, 8> children;
    for (int i = 0; i < 8; ++i)
        children[static_cast<std::size_t>(i)] = archive->box({0, i & 1, i >> 2, 4 + (i >> 1 & 1)});
    CHECK(same_box(archive->box({1, 0, 0, 2}), voxel::downsample({1, 0, 0, 2}, children)));
}

TEST_CASE("a part is what lies in area, heights and level, and nothing else is allowed",
          "[raytracer][convert][part]") {
    voxel::WorldInfo placed;
    placed.bounds = {{1000, 0, -5000}, {2000, 300, -4000}};
    placed.crs = "EPSG:3794";
    placed.crs_units_per_voxel = 0.5;
    placed.voxel_m = 0.5;
    placed.levels = 4;
    CHECK(make_part(placed, {}).bounds == placed.bounds);
    CHECK(make_part(placed, {0, {600, 2100, 700, 2200}, {}}).bounds ==
          voxel::VoxelBounds{{1200, 0, -4400}, {1400, 300, -4200}});
    CHECK(make_part(placed, {0, {}, {10, 20.1}}).bounds ==
          voxel::VoxelBounds{{1000, 20, -5000}, {2000, 41, -4000}});
    CHECK(make_part(placed, {2, {}, {}}).bounds ==
          voxel::VoxelBounds{{250, 0, -1250}, {500, 75, -1000}});
    CHECK_THROWS_WITH(make_part(placed, {4, {}, {}}), contains("level 4; allowed: 0 to 3"));
    CHECK_THROWS_WITH(make_part(placed, {0, {700, 2100, 600, 2200}, {}}), contains("--area"));
    CHECK_THROWS_WITH(make_part(placed, {0, {}, {20, 10}}), contains("--heights"));
    CHECK_THROWS_WITH(make_part(placed, {0, {0, 0, 10, 10}, {}}), contains("nothing of the world"));

    voxel::WorldInfo endless;
    endless.bounds = {{-(1 << 24), 0, -(1 << 24)}, {1 << 24, 300, 1 << 24}};
    endless.framed = {{-256, 0, -256}, {256, 300, 256}};
    endless.levels = 19;
    CHECK(make_part(endless, {}).bounds == endless.framed);
    CHECK(make_part(endless, {0, {1000, 2000, 1100, 2200}, {}}).bounds ==
          voxel::VoxelBounds{{1000, 0, 2000}, {1100, 300, 2200}});
}

TEST_CASE("an archive knows the typical heights of its world, in its own voxels",
          "[raytracer][convert][part]") {
    voxel::WorldInfo world;
    world.bounds = {{0, -40, 0}, {64, 500, 64}};
    world.levels = 2;
    CHECK_FALSE(archive_info(make_part(world, {1, {}, {}}), world).typical_heights);
    world.typical_heights = voxel::HeightRange{-7, 83};
    CHECK(archive_info(make_part(world, {}), world).typical_heights == world.typical_heights);
    CHECK(archive_info(make_part(world, {1, {}, {}}), world).typical_heights ==
          voxel::HeightRange{-4, 42});
}

TEST_CASE("two conversions to one place do not spoil each other", "[raytracer][convert][journal]") {
    const TemporaryFolder folder;
    const Journal journal(folder.path() / "j", "a");
    CHECK_THROWS_WITH(Journal(folder.path() / "j", "b"), contains("another conversion"));
}

TEST_CASE("a link at the name of a journal is refused, and leads to what it led to",
          "[raytracer][convert][journal]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "precious") << "as it was";
    fs::create_symlink("precious", folder.path() / "j");
    CHECK_THROWS_WITH(Journal(folder.path() / "j", "a"), contains("j is a symbolic link"));
    CHECK(fs::file_size(folder.path() / "precious") == 9);
}

TEST_CASE("a journal is continued when it is the same conversion's, whatever its end",
          "[raytracer][convert][journal]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "j";
    {
        Journal journal(file, "a b");
        CHECK_FALSE(journal.has("r.0.0"));
        journal.add("r.0.0", 10, 100);
        journal.add("r.0.1", 20, 300);
        CHECK(journal.has("r.0.0"));
    }
    std::ofstream(file, std::ios::app) << "30 500 r.0.";  // the power went here
    {
        Journal journal(file, "a b");
        CHECK(journal.has("r.0.0"));
        CHECK(journal.has("r.0.1"));
        CHECK_FALSE(journal.has("r.0."));
        CHECK(journal.voxels_before() == 30);
        CHECK(journal.files_before() == 2);
        CHECK(journal.end_before() == 300);
        journal.add("r.0.2", 5, 600);
    }
    CHECK(Journal(file, "a b").end_before() == 600);
    CHECK(Journal(file, "a c").files_before() == 0);
    Journal journal(file, "a c");
    journal.remove();
    CHECK_FALSE(fs::exists(file));
}
