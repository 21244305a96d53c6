#include "voxelserver/make/worlds/luanti/map_block.hpp"

#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_map_block.hpp"

namespace terravox::luanti {
namespace {

using test::contains;
using test::luanti::BigEndian;
using test::luanti::body_29;
using test::luanti::Bytes;
using test::luanti::deflated;
using test::luanti::MadeBlock;
using test::luanti::map_block_blob;
using test::luanti::node_bytes;
using test::luanti::zstd_frame;

MadeBlock two_kinds() {
    MadeBlock out;
    out.names = {"air", "default:stone"};
    out.set(1, 2, 3, 1);
    return out;
}

Bytes zstd_block(const Bytes& body) {
    BigEndian out;
    return out.u8(29).put(zstd_frame(body)).bytes;
}

TEST_CASE("a map block of any version holds the nodes that were stored", "[luanti]") {
    const int version = GENERATE(25, 26, 27, 28, 29);
    MadeBlock made;
    for (int i = 1; i < 300; ++i)
        made.names.push_back("mod:node_" + std::to_string(i));
    std::mt19937 random(7);
    for (std::uint16_t& id : made.ids)
        id = static_cast<std::uint16_t>(random() % made.names.size());
    MapBlockReader reader;
    const Bytes blob = map_block_blob(made, version);
    for (int again = 0; again < 2; ++again) {
        const MapBlock& block = reader.read(blob);
        CHECK(block.version == version);
        CHECK(block.ids == made.ids);
        REQUIRE(block.names.size() == made.names.size());
        for (std::size_t i = 0; i < made.names.size(); ++i) {
            CHECK(block.names[i].id == i);
            CHECK(block.names[i].name == made.names[i]);
        }
    }
}

TEST_CASE("a damaged map block is refused with its reason", "[luanti]") {
    const MadeBlock good = two_kinds();
    const Bytes body = body_29(good);
    const auto changed = [&](std::size_t at, std::uint8_t byte) {
        Bytes out = body;
        out.at(at) = byte;
        return zstd_block(out);
    };
    // Offsets in the body: flags 0, lighting 1, time 3, version of the names 7, their count 8, the
    // first name's id 10, length 12, text 14; the second's id 17, length 19, text 21; widths 34.
    MadeBlock long_name = good;
    long_name.names[1].assign(257, 'x');
    Bytes cut_zstd = zstd_block(body);
    cut_zstd.resize(cut_zstd.size() - 4);
    Bytes flipped = zstd_block(body);
    flipped[1] ^= 0xFF;
    const Bytes older = map_block_blob(good, 28);
    Bytes broken_zlib = older;
    broken_zlib[6] ^= 0xFF;
    BigEndian few_nodes;
    few_nodes.u8(28).u8(0).u16(0).u8(2).u8(2).put(deflated(Bytes(100)));
    BigEndian one_byte_ids;
    one_byte_ids.u8(28).u8(0).u16(0).u8(1).u8(2);
    BigEndian bomb;
    bomb.u8(29).put(zstd_frame(Bytes((std::size_t{16} << 20) + 1)));
    BigEndian older_bomb;
    older_bomb.u8(28).u8(0).u16(0).u8(2).u8(2).put(deflated(node_bytes(good)));
    older_bomb.put(deflated(Bytes((std::size_t{16} << 20) + 1)));
    struct Case {
        const char* name;
        Bytes blob;
        const char* reason;
    };
    const std::vector<Case> cases = {
        {"no bytes", {}, "ends too early"},
        {"the version alone", {29}, "broken zstd data"},
        {"older than names", {24, 0, 0}, "format version 24; allowed: 25 to 29"},
        {"newer", {30, 0, 0}, "format version 30; allowed: 25 to 29"},
        {"a frame that is none", flipped, "broken zstd data"},
        {"a frame cut short", cut_zstd, "broken zstd data: it ends within its frame"},
        {"names of another version", changed(7, 1), "the version of the node names is 1"},
        {"too many names", changed(8, 0x20), "names 8194 nodes; allowed: up to 4096"},
        {"an empty name", changed(13, 0), "a node name of 0 bytes; allowed: 1 to 256"},
        {"a long name", zstd_block(body_29(long_name)), "a node name of 257 bytes"},
        {"an id named twice", changed(18, 0), "names node id 0 twice"},
        {"narrow ids", changed(34, 1), "the width of node ids is 1; allowed: 2"},
        {"wide parameters", changed(35, 3), "the width of node parameters is 3; allowed: 2"},
        {"nodes that end", zstd_block(Bytes(body.begin(), body.begin() + 9000)), "ends too early"},
        {"a bomb", bomb.bytes, "decompresses to more than 16 MiB; allowed: up to that"},
        {"an older one of narrow ids", one_byte_ids.bytes, "the width of node ids is 1"},
        {"an older one that is broken", broken_zlib, "broken zlib data"},
        {"an older one of few nodes", few_nodes.bytes, "node data of 100 bytes; allowed: 16384"},
        {"an older bomb", older_bomb.bytes, "decompresses to more than 16 MiB"},
        {"an older one without names", Bytes(older.begin(), older.end() - 40), "ends too early"},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        MapBlockReader reader;
        CHECK_THROWS_WITH(reader.read(c.blob), contains(c.reason));
        CHECK(reader.read(map_block_blob(good, 29)).ids == good.ids);
    }
}

TEST_CASE("no cut or changed byte of a map block leads a reader astray", "[luanti]") {
    const int version = GENERATE(28, 29);
    const Bytes good = map_block_blob(two_kinds(), version);
    MapBlockReader reader;
    std::mt19937 random(11);
    for (std::size_t i = 0; i < good.size(); ++i) {
        Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(i));
        Bytes changed = good;
        changed[i] ^= static_cast<std::uint8_t>(1 + random() % 255);
        for (const Bytes& blob : {cut, changed}) {
            try {
                const std::size_t names = reader.read(blob).names.size();
                CHECK(names <= kBlockNodes);
            } catch (const util::Error&) {  // the right answer to a damaged block
            }
        }
    }
}

}  // namespace
}  // namespace terravox::luanti
