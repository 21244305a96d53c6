#include "voxelserver/make/worlds/minecraft/region_file.hpp"

#include <algorithm>

#include "common/util/error.hpp"

namespace terravox::minecraft {
namespace {

constexpr std::uint8_t kExternal = 0x80;
constexpr std::uint64_t kMaxSectors = 255;
constexpr std::size_t kChunkHeadBytes = 5;  // length, without itself; compression

std::uint32_t big_endian(const std::uint8_t* bytes) noexcept {
    return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
           std::uint32_t{bytes[2]} << 8 | bytes[3];
}

}  // namespace

RegionTable read_region_table(std::span<const std::uint8_t> head) {
    if (head.empty())
        throw util::Error("an empty file");
    if (head.size() < kRegionHeadBytes)
        throw util::Error(std::to_string(head.size()) + " bytes; a region has " +
                          std::to_string(kRegionHeadBytes) + " at least");
    RegionTable table;
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = big_endian(&head[4 * i]);
    return table;
}

PackedChunk read_packed(const ByteFile& region, std::uint32_t location,
                        std::vector<std::uint8_t>& buffer) {
    const std::uint64_t first = location >> 8;
    const std::uint64_t sectors = location & 0xFF;
    const std::uint64_t begin = first * kSectorBytes;
    if (first < 2 || sectors == 0)
        throw util::Error("it lies at sector " + std::to_string(first) + ", " +
                          std::to_string(sectors) + " long; allowed: from 2 on, 1 at least");
    if (begin + kChunkHeadBytes > region.size())
        throw util::Error("it lies at byte " + std::to_string(begin) +
                          ", past the end of the file (" + std::to_string(region.size()) +
                          " bytes)");
    // One read suffices for nearly all chunks; the rest of the sectors after the chunk costs less
    // than a second read.
    buffer.resize(
        static_cast<std::size_t>(std::min(sectors * kSectorBytes, region.size() - begin)));
    region.read(begin, buffer);
    const std::uint64_t length = big_endian(buffer.data());
    const std::uint8_t kind = buffer[4];
    if (length == 0)
        throw util::Error("it has a length of 0");
    if (length + 4 > buffer.size()) {
        // Some versions let a chunk grow beyond the number of sectors that the table can hold; the
        // file states its real length.
        if (sectors != kMaxSectors || length + 4 > region.size() - begin ||
            length > Inflater::kLimitBytes)
            throw util::Error("it has a length of " + std::to_string(length) + " in " +
                              std::to_string(buffer.size()) + " bytes of sectors");
        buffer.resize(static_cast<std::size_t>(length + 4));
        region.read(begin, buffer);
    }
    const int number = kind & ~kExternal;
    if (number < static_cast<int>(Compression::kGzip) ||
        number > static_cast<int>(Compression::kLz4))
        throw util::Error("it is packed by method " + std::to_string(number) +
                          "; allowed: 1 (gzip), 2 (zlib), 3 (none), 4 (lz4)");
    PackedChunk out{static_cast<Compression>(number), (kind & kExternal) != 0, {}};
    if (!out.external)
        out.bytes = std::span<const std::uint8_t>(buffer).subspan(
            kChunkHeadBytes, static_cast<std::size_t>(length - 1));
    return out;
}

}  // namespace terravox::minecraft
