// NBT: as a chunk of any generation, as level.dat, and passed over as a whole.
#include "voxelserver/make/worlds/minecraft/nbt.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/make/worlds/minecraft/chunk.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::fuzz {
namespace {

void check_sections(const minecraft::ChunkBlocks& blocks) {
    for (const auto& section : blocks.sections()) {
        expect(section.y >= minecraft::kLowestSection && section.y <= minecraft::kHighestSection,
               "a section lies within the allowed heights");
        if (section.numeric)
            continue;
        expect(section.palette_begin + std::uint64_t{section.palette_size} <= blocks.palette.size(),
               "a section's palette is there");
        for (const std::uint16_t cell : section.cells)
            expect(cell < section.palette_size, "a cell is in its palette");
    }
}

}  // namespace

void run(Input input) {
    allow_errors([&] {
        minecraft::NbtReader reader(input);
        reader.enter_root();
        minecraft::NbtField field;
        while (reader.next(field)) {
            (void)minecraft::to_utf8(field.name);
            reader.skip(field.type);
        }
    });
    allow_errors([&] { (void)minecraft::read_level_dat(input, "the input"); });
    minecraft::ChunkBlocks blocks;
    minecraft::decode_chunk(input, blocks);
    check_sections(blocks);
}

}  // namespace terravox::fuzz
