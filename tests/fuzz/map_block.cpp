// Map blocks of Luanti: their streams, their nodes, and the names of these.
//
// libFuzzer does not compress, an attacker does: each input is also read as what a stream holds,
// and as what follows the streams of an older block.
#include "voxelserver/make/worlds/luanti/map_block.hpp"

#include "tests/fuzz/fuzz.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_map_block.hpp"

namespace terravox::fuzz {
namespace {

using test::luanti::BigEndian;
using test::luanti::Bytes;

void read(Input blob) {
    luanti::MapBlockReader reader;
    allow_errors([&] {
        const luanti::MapBlock& block = reader.read(blob);
        expect(block.names.size() <= luanti::kBlockNodes, "a block has no more names than nodes");
        for (const luanti::MapBlock::Name& entry : block.names)
            expect(!entry.name.empty() && entry.name.size() <= luanti::MapBlock::kMaxNameBytes,
                   "a name's length is in range");
    });
}

}  // namespace

void run(Input input) {
    static const Bytes nodes = test::luanti::deflated(Bytes(luanti::kBlockNodes * 4));
    read(input);
    const Bytes bytes(input.begin(), input.end());
    BigEndian newer;
    read(newer.u8(29).put(test::luanti::zstd_frame(bytes)).bytes);
    BigEndian older;
    older.u8(28).u8(0).u16(0).u8(2).u8(2).put(nodes).put(test::luanti::deflated({1, 2}));
    read(older.put(bytes).bytes);
}

}  // namespace terravox::fuzz
