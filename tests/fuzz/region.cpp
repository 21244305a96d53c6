// Region files: the table, chunks in their sectors, how they are packed, and their blocks.
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"

#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/make/worlds/minecraft/chunk.hpp"

namespace terravox::fuzz {
namespace {

constexpr int kMaxChunks = 16;

class MemoryFile final : public minecraft::ByteFile {
public:
    explicit MemoryFile(Input bytes) : m_bytes(bytes) {}
    [[nodiscard]] std::uint64_t size() const noexcept override { return m_bytes.size(); }
    void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
        if (offset > m_bytes.size() || out.size() > m_bytes.size() - offset)
            throw util::Error("read the input: it ends before that");
        if (!out.empty())
            std::memcpy(out.data(), m_bytes.data() + offset, out.size());
    }

private:
    Input m_bytes;
};

}  // namespace

void run(Input input) {
    const MemoryFile file(input);
    const auto table = minecraft::read_region_table(input);
    minecraft::Inflater inflater;
    std::vector<std::uint8_t> buffer;
    minecraft::ChunkBlocks blocks;
    int left = kMaxChunks;
    for (const std::uint32_t location : table) {
        if (location == 0 || left-- == 0)
            continue;
        allow_errors([&] {
            const auto packed = minecraft::read_packed(file, location, buffer);
            minecraft::decode_chunk(inflater.unpack(packed.compression, packed.bytes), blocks);
        });
        if (left < 0)
            return;
    }
}

}  // namespace terravox::fuzz
