#include "voxelserver/make/worlds/minecraft/chunk_reader.hpp"

#include "common/util/error.hpp"

namespace terravox::minecraft {

const ChunkBlocks& ChunkReader::read(const ChunkRef& chunk) {
    const ChunkStore::Bytes bytes = m_store.read(chunk, m_reader);
    m_compression = bytes.compression;
    decode_chunk(bytes.nbt, m_blocks);
    if (m_store.knows_place(chunk) && m_blocks.place && *m_blocks.place != chunk.place)
        throw util::Error("it stands at the wrong place: it says that it is chunk " +
                          std::to_string(m_blocks.place->x) + ", " +
                          std::to_string(m_blocks.place->z));
    return m_blocks;
}

}  // namespace terravox::minecraft
