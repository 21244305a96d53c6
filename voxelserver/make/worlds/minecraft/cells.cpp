#include "voxelserver/make/worlds/minecraft/cells.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

#include "common/util/error.hpp"

namespace terravox::minecraft {
namespace {

constexpr std::size_t kCells = kSectionVoxels;
// Snapshot 20w17a of 1.16: an index no longer runs across two longs.
constexpr std::int64_t kFirstPadded = 2529;

std::uint64_t big_endian_long(const std::uint8_t* bytes) noexcept {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes, sizeof value);
    return std::endian::native == std::endian::little ? __builtin_bswap64(value) : value;
}

// With the number of bits known, the compiler turns the inner loop into a few wide steps.
template <unsigned kBits>
void unpack_padded(const NbtLongs& data, std::uint16_t* cells) noexcept {
    constexpr std::size_t kEach = 64 / kBits;
    constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
    const std::uint8_t* at = data.bytes;
    std::size_t i = 0;
    for (; i + kEach <= kCells; i += kEach, at += 8) {
        const std::uint64_t word = big_endian_long(at);
        for (std::size_t k = 0; k < kEach; ++k)
            cells[i + k] = static_cast<std::uint16_t>(word >> (k * kBits) & kMask);
    }
    if constexpr (kCells % kEach != 0)
        for (std::uint64_t word = big_endian_long(at); i < kCells; ++i, word >>= kBits)
            cells[i] = static_cast<std::uint16_t>(word & kMask);
}

void unpack_padded(const NbtLongs& data, unsigned bits, std::uint16_t* cells) noexcept {
    switch (bits) {
        case 4: return unpack_padded<4>(data, cells);
        case 5: return unpack_padded<5>(data, cells);
        case 6: return unpack_padded<6>(data, cells);
        case 7: return unpack_padded<7>(data, cells);
        case 8: return unpack_padded<8>(data, cells);
        case 9: return unpack_padded<9>(data, cells);
        case 10: return unpack_padded<10>(data, cells);
        case 11: return unpack_padded<11>(data, cells);
        default: return unpack_padded<12>(data, cells);
    }
}

void unpack_straddling(const NbtLongs& data, unsigned bits, std::uint16_t* cells) noexcept {
    const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
    const std::uint8_t* at = data.bytes;
    std::uint64_t word = 0;
    unsigned left = 0;  // bits of `word` that are still to come, its lowest
    for (std::size_t i = 0; i < kCells; ++i) {
        std::uint64_t value = word;
        if (left < bits) {
            word = big_endian_long(at);
            at += 8;
            value |= word << left;
            word = bits - left == 64 ? 0 : word >> (bits - left);
            left += 64;
        } else {
            word >>= bits;
        }
        left -= bits;
        cells[i] = static_cast<std::uint16_t>(value & mask);
    }
}

std::string at_section(const ChunkSection& section) {
    return "section y = " + std::to_string(section.y) + ": ";
}

std::size_t padded_longs(unsigned bits) noexcept {
    const std::size_t each = 64 / bits;
    return (kCells + each - 1) / each;
}

}  // namespace

void unpack_cells(const NbtLongs& data, std::uint32_t palette_size,
                  std::optional<std::int64_t> data_version, ChunkSection& out) {
    if (palette_size == 0 || palette_size > kCells)
        throw util::Error(at_section(out) + "a palette of " + std::to_string(palette_size) +
                          " blocks; allowed: 1 to 4096");
    out.numeric = false;
    out.uniform = palette_size == 1;
    if (out.uniform) {
        out.cells[0] = 0;
        return;
    }
    const unsigned bits = std::max(4u, static_cast<unsigned>(std::bit_width(palette_size - 1)));
    const bool padded =
        data_version ? *data_version >= kFirstPadded : data.count == padded_longs(bits);
    if (padded && data.count == padded_longs(bits)) {
        unpack_padded(data, bits, out.cells.data());
    } else if (const std::size_t wide = data.count / 64;
               !padded && data.count % 64 == 0 && wide >= bits && wide <= 14) {
        unpack_straddling(data, static_cast<unsigned>(wide),
                          out.cells.data());  // a writer may use more bits than needed
    } else {
        throw util::Error(at_section(out) + std::to_string(data.count) +
                          " longs of indices for a palette of " + std::to_string(palette_size) +
                          " blocks; allowed: " +
                          std::to_string(padded ? padded_longs(bits) : std::size_t{64} * bits));
    }
    const std::uint16_t largest = *std::max_element(out.cells.begin(), out.cells.end());
    if (largest >= palette_size)
        throw util::Error(at_section(out) + "index " + std::to_string(largest) +
                          " into a palette of " + std::to_string(palette_size) + " blocks");
}

void numeric_cells(std::span<const std::uint8_t> blocks, std::span<const std::uint8_t> add,
                   std::span<const std::uint8_t> data, ChunkSection& out) {
    const auto check = [&](const char* name, std::size_t size, std::size_t allowed) {
        if (size != allowed)
            throw util::Error(at_section(out) + name + " of " + std::to_string(size) +
                              " bytes; allowed: " + std::to_string(allowed));
    };
    check("Blocks", blocks.size(), kCells);
    if (!add.empty())
        check("Add", add.size(), kCells / 2);
    if (!data.empty())
        check("Data", data.size(), kCells / 2);
    out.numeric = true;
    out.uniform = false;
    for (std::size_t i = 0; i < kCells; i += 2) {
        const unsigned both = data.empty() ? 0u : data[i / 2];
        const unsigned high = add.empty() ? 0u : add[i / 2];
        out.cells[i] =
            static_cast<std::uint16_t>((high & 15) << 12 | unsigned{blocks[i]} << 4 | (both & 15));
        out.cells[i + 1] = static_cast<std::uint16_t>((high >> 4) << 12 |
                                                      unsigned{blocks[i + 1]} << 4 | both >> 4);
    }
}

void column_cells(std::span<const std::uint8_t> blocks, std::span<const std::uint8_t> data,
                  int section, ChunkSection& out) {
    out.numeric = true;
    out.uniform = false;
    out.y = section;
    for (std::size_t x = 0; x < 16; ++x)
        for (std::size_t z = 0; z < 16; ++z) {
            const std::size_t first = (x * 16 + z) * 128 + static_cast<std::size_t>(section) * 16;
            for (std::size_t y = 0; y < 16; ++y) {
                const unsigned low_data =
                    data.empty() ? 0u : unsigned{data[(first + y) / 2]} >> (4 * (y & 1)) & 15;
                out.cells[y * 256 + z * 16 + x] =
                    static_cast<std::uint16_t>(unsigned{blocks[first + y]} << 4 | low_data);
            }
        }
}

}  // namespace terravox::minecraft
