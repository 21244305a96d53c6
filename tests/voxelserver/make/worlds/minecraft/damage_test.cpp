#include <algorithm>
#include <functional>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_world.hpp"
#include "voxelserver/make/worlds/minecraft/world_info.hpp"

namespace terravox::minecraft {
namespace {

using test::Bytes;
using test::Made;
using test::MadeChunk;
using test::MadeRegion;
using test::MadeWorld;
using test::NbtWriter;
using test::TemporaryFolder;

MadeChunk flat_chunk(int x, int z) {
    MadeChunk out;
    out.x = x;
    out.z = z;
    out.sections[0].fill(1);
    return out;
}

// A region of two good chunks, at 0, 0 and `far`, around what `spoil` adds.
template <class Spoil>
Bytes region_with(const Spoil& spoil, const MadeChunk& far) {
    MadeRegion region;
    region.put(0, test::chunk_nbt(flat_chunk(0, 0), Made::kFlat));
    spoil(region);
    region.put(far.x + 32 * far.z, test::chunk_nbt(far, Made::kFlat));
    return region.bytes;
}

// From the first place of the region's table to its last.
Bytes good_region() {
    return region_with([](MadeRegion&) {}, flat_chunk(31, 31));
}

TEST_CASE("a damaged chunk is air, named with its file, place and reason, and the rest is there",
          "[raytracer][minecraft]") {
    const Bytes good = test::chunk_nbt(flat_chunk(5, 0), Made::kFlat);
    Bytes broken = test::deflated(good, false);
    broken[broken.size() / 2] ^= 0x55;
    struct Case {
        const char* name;
        std::function<void(MadeRegion&)> spoil;
        const char* reason;
    };
    const std::vector<Case> cases = {
        {"past the end", [](MadeRegion& r) { r.set_location(5, 5000, 1); },
         "past the end of the file"},
        {"in the table", [](MadeRegion& r) { r.set_location(5, 1, 1); }, "it lies at sector 1"},
        {"of no sectors", [](MadeRegion& r) { r.set_location(5, 2, 0); }, "0 long"},
        {"longer than its sectors",
         [&](MadeRegion& r) {
             const std::size_t begin = r.put(5, good);
             r.bytes[begin + 2] = 0x7F;
         },
         "in 4096 bytes of sectors"},
        {"longer than a file", [&](MadeRegion& r) { r.bytes[r.put(5, good)] = 0xFF; },
         "it has a length of"},
        {"of length 0",
         [&](MadeRegion& r) {
             const std::size_t begin = r.put(5, good);
             std::fill_n(r.bytes.begin() + static_cast<std::ptrdiff_t>(begin), 4, std::uint8_t{0});
         },
         "a length of 0"},
        {"packed in an unknown way", [&](MadeRegion& r) { r.put_packed(5, 9, good); },
         "packed by method 9"},
        {"packed in a way of its own", [&](MadeRegion& r) { r.put_packed(5, 127, good); },
         "packed by method 127"},
        {"broken zlib", [&](MadeRegion& r) { r.put_packed(5, 2, broken); }, "broken zlib data"},
        {"at the wrong place",
         [&](MadeRegion& r) { r.put(5, test::chunk_nbt(flat_chunk(6, 0), Made::kFlat)); },
         "wrong place: it says that it is chunk 6, 0"},
        {"in a file that is not there", [&](MadeRegion& r) { r.put_packed(5, 0x82, {}); },
         "c.5.0.mcc, which is not there"},
    };
    for (const Case& c : cases)
        DYNAMIC_SECTION(c.name) {
            const TemporaryFolder folder;
            test::write_bytes(folder.path() / "region/r.0.0.mca",
                              region_with(c.spoil, flat_chunk(8, 1)));
            MadeWorld expected;
            expected.chunk(0, 0) = flat_chunk(0, 0);
            expected.chunk(8, 1) = flat_chunk(8, 1);
            const auto world = test::open_made(folder.path());
            CHECK(test::differing_voxels(*world, expected) == 0);  // reads each box
            REQUIRE(world->damage().size() == 1);
            CHECK_THAT(world->damage()[0], test::contains("region/r.0.0.mca, chunk 5, 0: "));
            CHECK_THAT(world->damage()[0], test::contains(c.reason));
            const WorldFacts facts = describe(folder.path(), "", true, 1);
            CHECK(facts.dimensions.at(0).chunks == 3);
            CHECK(facts.dimensions.at(0).damaged == 1);
            CHECK(facts.dimensions.at(0).damage == world->damage());
            CHECK(facts.dimensions.at(0).blocks ==
                  std::map<std::string, std::int64_t>{{"minecraft:stone", 8192}});
        }
}

TEST_CASE("a region that is shorter than its head is named, and the others are there",
          "[raytracer][minecraft]") {
    for (const std::size_t size : {1, 4095, 4096, 8191}) {
        const TemporaryFolder folder;
        test::write_bytes(folder.path() / "region/r.0.0.mca", good_region());
        test::write_bytes(folder.path() / "region/r.1.0.mca", Bytes(size, 0));
        test::write_bytes(folder.path() / "region/r.2.0.mca",
                          Bytes(8192, 0));  // no chunks is no harm
        const auto world = test::open_made(folder.path());
        INFO(size << " bytes");
        CHECK(world->info().bounds.max[0] == 512);
        REQUIRE(world->damage().size() == 1);
        CHECK_THAT(world->damage()[0], test::contains("region/r.1.0.mca: "));
    }
}

TEST_CASE("a region of no bytes is no damage, as in the game", "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    test::write_bytes(folder.path() / "region/r.1.0.mca", {});
    CHECK_THROWS_WITH(test::open_made(folder.path()),
                      test::contains("no chunks in its dimension overworld"));
    test::write_bytes(folder.path() / "region/r.0.0.mca", good_region());
    CHECK(test::open_made(folder.path())->damage().empty());
    const WorldFacts facts = describe(folder.path(), "", false, 1);
    CHECK(facts.dimensions.at(0).damage.empty());
    CHECK(facts.dimensions.at(0).notes ==
          std::vector<std::string>{"region/r.1.0.mca: an empty file, without chunks"});
}

TEST_CASE(
    "chunks in files of their own, and chunks of more sectors than the table can say, are read",
    "[raytracer][minecraft]") {
    const MadeChunk external = flat_chunk(-32, 5);
    const MadeChunk large = flat_chunk(-31, 5);
    Bytes nbt = test::chunk_nbt(large, Made::kFlat);
    NbtWriter padding;  // before the chunk's own end
    padding.byte_array("padding", Bytes(1'100'000, 3));
    nbt.insert(nbt.end() - 1, padding.bytes.begin(), padding.bytes.end());
    MadeRegion region;
    region.put_packed(32 * 5, 0x82, {});
    const std::size_t begin = region.put(32 * 5 + 1, nbt, 3);
    region.set_location(32 * 5 + 1, static_cast<std::uint32_t>(begin / 4096), 255);
    const TemporaryFolder folder;
    test::write_bytes(folder.path() / "region/r.-1.0.mca", region.bytes);
    test::write_bytes(folder.path() / "region/c.-32.5.mcc",
                      test::deflated(test::chunk_nbt(external, Made::kFlat), false));
    MadeWorld expected;
    expected.chunk(-32, 5) = external;
    expected.chunk(-31, 5) = large;
    const auto world = test::open_made(folder.path());
    CHECK(test::differing_voxels(*world, expected) == 0);
    CHECK(world->damage().empty());
}

TEST_CASE("regions that lie beyond the end of the world are passed over and noted",
          "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    test::write_bytes(folder.path() / "region/r.0.0.mca", good_region());
    for (const char* name : {"r.2147483647.0.mca", "r.0.-65537.mca"})
        test::write_bytes(folder.path() / "region" / name, good_region());
    for (const char* name :
         {"r.99999999999.0.mca", "r.01.0.mca", "r.-0.1.mca", "r..1.mca", "r.1.mca", "c.1.mcc"})
        test::write_bytes(folder.path() / "region" / name, {1});
    CHECK(test::open_made(folder.path())->info().bounds.max[0] == 512);
    CHECK(describe(folder.path(), "", false, 1).dimensions.at(0).notes.size() == 2);
}

}  // namespace
}  // namespace terravox::minecraft
