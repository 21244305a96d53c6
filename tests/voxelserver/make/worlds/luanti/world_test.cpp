#include <atomic>
#include <thread>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_luanti.hpp"

namespace terravox::luanti {
namespace {

using test::TemporaryFolder;
using test::luanti::differing_voxels;
using test::luanti::find_voxel;
using test::luanti::MadeBlock;
using test::luanti::MadeWorld;
using test::luanti::open_made;
using test::luanti::random_world;
using test::luanti::Schema;
using voxel::Material;

MadeBlock make_full(const std::string& node) {
    MadeBlock out;
    out.names.push_back(node);
    out.ids.fill(1);
    return out;
}

TEST_CASE("every voxel is the node that stands there, in any version and schema", "[luanti]") {
    const int version = GENERATE(25, 28, 29);
    const Schema schema = GENERATE(Schema::kEncoded, Schema::kXyz);
    const TemporaryFolder folder;
    const std::uint64_t seed = 40 + static_cast<std::uint64_t>(version);
    CAPTURE(version, schema == Schema::kXyz, seed);
    const MadeWorld made = random_world(seed);
    made.write(folder.path() / "world", version, schema);
    const auto world = open_made(folder.path() / "world");
    CHECK(differing_voxels(*world, made) == 0);
    CHECK(world->damage().empty());
}

TEST_CASE("the game's north is the voxels' north", "[luanti]") {
    const TemporaryFolder folder;
    MadeWorld made;
    MadeBlock& block = made.blocks[{0, 0, 0}];
    block.names = {"air", "default:stone"};
    block.set(2, 3, 5, 1);
    made.write(folder.path(), 29, Schema::kXyz);
    const auto world = open_made(folder.path());
    CHECK(find_voxel(*world, 2, 3, -6) == Material::kRock);
    const voxel::VoxelBounds b = world->info().bounds;
    CHECK(b == voxel::VoxelBounds{{0, 3, -16}, {16, 4, 0}});
}

TEST_CASE("the farthest blocks that a key has room for are read", "[luanti]") {
    const Schema schema = GENERATE(Schema::kEncoded, Schema::kXyz);
    const TemporaryFolder folder;
    MadeWorld made;
    made.blocks[{-2048, -2048, -2048}] = make_full("default:stone");
    made.blocks[{2047, 2047, 2047}] = make_full("default:glass");
    made.write(folder.path(), 29, schema);
    const auto world = open_made(folder.path());
    CHECK(world->info().bounds ==
          voxel::VoxelBounds{{-32768, -32768, -32768}, {32768, 32768, 32768}});
    CHECK(find_voxel(*world, -32768, -32768, 32767) == Material::kRock);
    CHECK(find_voxel(*world, 32767, 32767, -32768) == Material::kGlass);
    CHECK(find_voxel(*world, 0, 0, 0) == Material::kAir);
    const int top = world->info().levels - 1;
    const voxel::BoxRange all = voxel::boxes_over(world->info().bounds, top);
    CHECK(world->may_hold(all));
    CHECK_FALSE(world->may_hold({{0, 0, 0, 0}, {0, 4, 1, 4}}));
    CHECK(world->damage().empty());
}

TEST_CASE("blocks of air do not widen a world", "[luanti]") {
    const TemporaryFolder folder;
    MadeWorld made;
    made.blocks[{0, 0, 0}] = make_full("default:stone");
    made.blocks[{40, 9, 40}] = make_full("ignore");
    made.blocks[{-40, 9, 0}] = MadeBlock{};
    made.write(folder.path(), 28, Schema::kEncoded);
    const auto world = open_made(folder.path());
    CHECK(world->info().bounds == voxel::VoxelBounds{{0, 0, -16}, {16, 16, 0}});
    CHECK(world->column(0, 10, -11).empty());
}

TEST_CASE("a wide world is framed by a part of its blocks, and whole all the same", "[luanti]") {
    const TemporaryFolder folder;
    MadeWorld made;
    for (int x = 0; x < 40; ++x)
        made.blocks[{x, 0, 0}] = make_full("default:stone");
    made.blocks[{39, 5, 0}] = MadeBlock{};
    made.write(folder.path(), 29, Schema::kXyz);
    LuantiWorldOptions options;
    options.path = folder.path();
    options.max_surveyed = 8;
    const auto world = open_luanti_world(options, test::luanti::shipped_nodes());
    CHECK(world->info().bounds == voxel::VoxelBounds{{0, 0, -16}, {640, 96, 0}});
    CHECK_FALSE(world->info().framed.empty());
    CHECK(world->info().framed.max[1] == 16);
    for (int x = 0; x < 40; ++x)
        CHECK(find_voxel(*world, 16 * x, 15, -1) == Material::kRock);
}

TEST_CASE("boxes are the same for any number of threads that read them", "[luanti]") {
    const TemporaryFolder folder;
    const MadeWorld made = random_world(3);
    made.write(folder.path(), 29, Schema::kEncoded);
    const auto alone = open_made(folder.path());
    const auto shared = open_made(folder.path());
    std::atomic<int> differing{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int level = 0; level < shared->info().levels; ++level) {
                const voxel::BoxRange range = voxel::boxes_over(shared->info().bounds, level);
                for (auto bx = range.min.bx; bx < range.max.bx; ++bx) {
                    for (auto bz = range.min.bz; bz < range.max.bz; ++bz) {
                        const voxel::BoxKey key{level, bx, range.min.by, bz};
                        const auto a = alone->box(key);
                        const auto b = shared->box(key);
                        differing += (a ? a->checksum() : 0) != (b ? b->checksum() : 0) ? 1 : 0;
                    }
                }
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    CHECK(differing == 0);
}

TEST_CASE("options out of range are refused", "[luanti]") {
    const TemporaryFolder folder;
    random_world(1).write(folder.path(), 29, Schema::kXyz);
    LuantiWorldOptions options;
    options.path = folder.path();
    options.memory_bytes = std::size_t{15} << 20;
    CHECK_THROWS_WITH(open_luanti_world(options, test::luanti::shipped_nodes()),
                      test::contains("15 MiB of memory; allowed: at least 16"));
    options.memory_bytes = std::size_t{16} << 20;
    options.max_surveyed = 0;
    CHECK_THROWS_WITH(open_luanti_world(options, test::luanti::shipped_nodes()),
                      test::contains("looks through 0 map blocks; allowed: at least 1"));
}

}  // namespace
}  // namespace terravox::luanti
