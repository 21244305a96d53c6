#include "voxelserver/make/worlds/minecraft/chunk.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

#include "common/util/error.hpp"
#include "voxelserver/make/worlds/minecraft/nbt.hpp"

namespace terravox::minecraft {
namespace {

// Snapshot 20w49a of 1.17: before it, blocks lie from y = 0 to 255.
constexpr std::int64_t kFirstOfAnyHeight = 2685;
constexpr std::size_t kMaxSections = 1024;  // a longer list is not from a chunk

bool is_integer(NbtType type) noexcept {
    return type >= NbtType::kByte && type <= NbtType::kLong;
}

// A section as stored in the file, to be unpacked once the chunk's version is known, which may be
// the last field.
struct RawSection {
    std::optional<std::int64_t> y;
    std::span<const std::uint8_t> blocks;
    std::span<const std::uint8_t> add;
    std::span<const std::uint8_t> data;
    std::uint32_t palette_begin = 0;
    std::uint32_t palette_size = 0;
    bool has_palette = false;
    NbtLongs indices;
};

struct RawChunk {
    std::optional<std::int64_t> x;
    std::optional<std::int64_t> z;
    std::vector<RawSection> sections;
    std::span<const std::uint8_t> blocks, data;  // in columns, before Anvil
    bool has_columns = false;
    bool has_sections = false;
};

void read_palette(NbtReader& in, ChunkBlocks& out, RawSection& section) {
    const NbtList list = in.list();
    if (list.count != 0 && list.type != NbtType::kCompound)
        throw NbtError("a palette that is no list of compounds");
    if (list.count > static_cast<std::uint32_t>(kSectionVoxels))
        throw NbtError("a palette of " + std::to_string(list.count) +
                       " blocks; allowed: up to 4096");
    section.has_palette = true;
    section.palette_begin = static_cast<std::uint32_t>(out.palette.size());
    section.palette_size = list.count;
    for (std::uint32_t i = 0; i < list.count; ++i) {
        const std::size_t begin = in.position();
        in.skip(NbtType::kCompound);
        out.palette.push_back(in.since(begin));
    }
}

// Fields of a section, and, since 1.18, of the compound in it that holds its blocks.
void read_section(NbtReader& in, ChunkBlocks& out, RawSection& section, bool inner) {
    NbtField field;
    while (in.next(field)) {
        const std::string_view name = field.name;
        if (inner && name == "palette" && field.type == NbtType::kList)
            read_palette(in, out, section);
        else if (inner && name == "data" && field.type == NbtType::kLongs)
            section.indices = in.long_array();
        else if (inner)
            in.skip(field.type);
        else if (name == "Y" && is_integer(field.type))
            section.y = in.integer(field.type);
        else if (name == "block_states" && field.type == NbtType::kCompound)
            read_section(in, out, section, true);
        else if (name == "Palette" && field.type == NbtType::kList)
            read_palette(in, out, section);
        else if (name == "BlockStates" && field.type == NbtType::kLongs)
            section.indices = in.long_array();
        else if (name == "Blocks" && field.type == NbtType::kBytes)
            section.blocks = in.byte_array();
        else if (name == "Add" && field.type == NbtType::kBytes)
            section.add = in.byte_array();
        else if (name == "Data" && field.type == NbtType::kBytes)
            section.data = in.byte_array();
        else
            in.skip(field.type);
    }
}

void read_sections(NbtReader& in, ChunkBlocks& out, RawChunk& raw) {
    const NbtList list = in.list();
    raw.has_sections = true;
    if (list.count == 0)
        return;
    if (list.type != NbtType::kCompound)
        throw NbtError("sections that are no compounds");
    if (list.count > kMaxSections)
        throw NbtError(std::to_string(list.count) + " sections; allowed: up to " +
                       std::to_string(kMaxSections));
    for (std::uint32_t i = 0; i < list.count; ++i)
        read_section(in, out, raw.sections.emplace_back(), false);
}

// Fields of the whole file, and, before 1.18, of the compound `Level` in it.
void read_chunk(NbtReader& in, ChunkBlocks& out, RawChunk& raw, bool within_level) {
    NbtField field;
    while (in.next(field)) {
        const std::string_view name = field.name;
        if (!within_level && name == "Level" && field.type == NbtType::kCompound)
            read_chunk(in, out, raw, true);
        else if (name == "xPos" && is_integer(field.type))
            raw.x = in.integer(field.type);
        else if (name == "zPos" && is_integer(field.type))
            raw.z = in.integer(field.type);
        else if (name == "DataVersion" && is_integer(field.type))
            out.data_version = in.integer(field.type);
        else if (name == "Status" && field.type == NbtType::kString)
            out.status = in.string();
        else if ((name == "sections" || name == "Sections") && field.type == NbtType::kList)
            read_sections(in, out, raw);
        else if (name == "Blocks" && field.type == NbtType::kBytes) {
            raw.blocks = in.byte_array();
            raw.has_columns = true;
        } else if (name == "Data" && field.type == NbtType::kBytes)
            raw.data = in.byte_array();
        else
            in.skip(field.type);
    }
}

bool any(std::span<const std::uint8_t> bytes) noexcept {
    return std::any_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte != 0; });
}

// Whether a section holds only air, determined without unpacking: for heights where nothing may
// lie.
bool is_bare(const RawSection& raw, const ChunkBlocks& out) {
    if (!raw.has_palette)
        return !any(raw.blocks) && !any(raw.add);
    return raw.palette_size == 0 ||
           (raw.palette_size == 1 &&
            out.palette[raw.palette_begin].find("minecraft:air") != std::string_view::npos);
}

void unpack_section(const RawSection& raw, ChunkBlocks& out) {
    if (!raw.has_palette && raw.blocks.empty())
        return;  // holds light only
    const bool any_height =
        out.data_version.value_or(0) >= kFirstOfAnyHeight || (raw.has_palette && !out.data_version);
    const std::int64_t lowest = any_height ? kLowestSection : 0;
    const std::int64_t highest = any_height ? kHighestSection : 15;
    if (!raw.y || *raw.y < lowest || *raw.y > highest) {
        if (is_bare(raw, out))
            return;
        out.oddities.push_back(
            "section y = " + (raw.y ? std::to_string(*raw.y) : std::string("missing")) +
            " is left out; allowed: " + std::to_string(lowest) + " to " + std::to_string(highest));
        return;
    }
    if (raw.has_palette ? raw.palette_size == 0 && raw.indices.empty()
                        : !any(raw.blocks) && !any(raw.add) && raw.blocks.size() == kSectionVoxels)
        return;
    ChunkSection& section = out.add_section();
    section.y = static_cast<std::int32_t>(*raw.y);
    section.palette_begin = raw.palette_begin;
    section.palette_size = raw.palette_size;
    if (raw.has_palette)
        unpack_cells(raw.indices, raw.palette_size, out.data_version, section);
    else
        numeric_cells(raw.blocks, raw.add, raw.data, section);
}

void unpack_columns(const RawChunk& raw, ChunkBlocks& out) {
    if (raw.blocks.size() != kColumnBlocks)
        throw util::Error("Blocks of {} bytes; allowed: 32768", raw.blocks.size());
    if (!raw.data.empty() && raw.data.size() != kColumnBlocks / 2)
        throw util::Error("Data of {} bytes; allowed: 16384", raw.data.size());
    out.alpha = true;
    for (int section = 0; section < 8; ++section) {
        ChunkSection& to = out.add_section();
        column_cells(raw.blocks, raw.data, section, to);
    }
}

bool is_finished(std::string_view status) noexcept {
    if (status.starts_with("minecraft:"))
        status.remove_prefix(10);
    // The last two: 1.13.
    return status.empty() || status == "full" || status == "fullchunk" || status == "postprocessed";
}

}  // namespace

void decode_chunk(std::span<const std::uint8_t> nbt, ChunkBlocks& out) {
    out.clear();
    RawChunk raw;
    NbtReader in(nbt);
    in.enter_root();
    read_chunk(in, out, raw, false);
    if (!raw.has_sections && !raw.has_columns && !raw.x)
        throw util::Error("it is no chunk: neither sections nor Blocks nor xPos are in it");
    if (raw.x && raw.z) {
        const auto fits = [](std::int64_t v) { return v >= INT32_MIN && v <= INT32_MAX; };
        if (!fits(*raw.x) || !fits(*raw.z))
            throw util::Error("it says that it is chunk {}, {}", *raw.x, *raw.z);
        out.place =
            ChunkPlace{static_cast<std::int32_t>(*raw.x), static_cast<std::int32_t>(*raw.z)};
    }
    out.finished = is_finished(out.status);
    for (const RawSection& section : raw.sections)
        unpack_section(section, out);
    if (raw.has_columns && raw.sections.empty())
        unpack_columns(raw, out);
    out.sort_sections();
}

namespace {

constexpr std::size_t kCells = kSectionVoxels;
// Snapshot 20w17a of 1.16: an index no longer runs across two longs.
constexpr std::int64_t kFirstPadded = 2529;
// Snapshot 21w39a of 1.18: the game refuses indices of more bits than the palette needs.
constexpr std::int64_t kFirstOfExactBits = 2836;

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
        case 12: return unpack_padded<12>(data, cells);
        default: return unpack_padded<16>(data, cells);
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

// Bits of the indices in so many longs, 0 where they are too few or none fit. Where indices do not
// run across longs, a length may stand for several numbers of bits; the games of 1.16 and 1.17 take
// the largest.
unsigned find_bits(std::size_t longs, unsigned needed, bool padded, bool exact) noexcept {
    constexpr std::size_t kMostPadded = 16, kMostStraddling = 14;
    if (padded && longs == padded_longs(needed))
        return needed;
    const std::size_t wide = longs / 64;
    if (exact || wide < needed || wide > (padded ? kMostPadded : kMostStraddling) ||
        longs != (padded ? padded_longs(static_cast<unsigned>(wide)) : 64 * wide))
        return 0;
    return static_cast<unsigned>(wide);
}

}  // namespace

void unpack_cells(const NbtLongs& data, std::uint32_t palette_size,
                  std::optional<std::int64_t> data_version, ChunkSection& out) {
    if (palette_size == 0 || palette_size > kCells)
        throw util::Error("{}a palette of {} blocks; allowed: 1 to 4096", at_section(out),
                          palette_size);
    out.numeric = false;
    out.uniform = palette_size == 1;
    if (out.uniform) {
        out.cells[0] = 0;
        return;
    }
    const unsigned bits = std::max(4u, static_cast<unsigned>(std::bit_width(palette_size - 1)));
    const bool exact = data_version.value_or(0) >= kFirstOfExactBits;
    bool padded = data_version.value_or(kFirstPadded) >= kFirstPadded;
    unsigned found = find_bits(data.count, bits, padded, exact);
    if (found == 0 && !data_version) {
        padded = false;
        found = find_bits(data.count, bits, padded, exact);
    }
    if (found == 0)
        throw util::Error("{}{} longs of indices for a palette of {} blocks; allowed: {}{}",
                          at_section(out), data.count, palette_size,
                          padded ? padded_longs(bits) : std::size_t{64} * bits,
                          exact ? "" : ", or those of more bits");
    if (padded)
        unpack_padded(data, found, out.cells.data());
    else
        unpack_straddling(data, found, out.cells.data());
    const std::uint16_t largest = *std::max_element(out.cells.begin(), out.cells.end());
    if (largest >= palette_size)
        throw util::Error("{}index {} into a palette of {} blocks", at_section(out), largest,
                          palette_size);
}

void numeric_cells(std::span<const std::uint8_t> blocks, std::span<const std::uint8_t> add,
                   std::span<const std::uint8_t> data, ChunkSection& out) {
    const auto check = [&](const char* name, std::size_t size, std::size_t allowed) {
        if (size != allowed)
            throw util::Error("{}{} of {} bytes; allowed: {}", at_section(out), name, size,
                              allowed);
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

ChunkSection& ChunkBlocks::add_section() {
    constexpr std::size_t kUsual = 24;
    if (m_count == m_sections.size())
        m_sections.resize(std::max(kUsual, 2 * m_count));
    ChunkSection& out = m_sections[m_count++];
    out.y = 0;
    out.numeric = out.uniform = false;
    out.palette_begin = out.palette_size = 0;
    return out;
}

void ChunkBlocks::clear() noexcept {
    place.reset();
    data_version.reset();
    status = {};
    finished = true;
    alpha = false;
    palette.clear();
    oddities.clear();
    m_count = 0;
}

// Mostly sorted already. Of two at one height the later counts, as in the game.
void ChunkBlocks::sort_sections() {
    const auto begin = m_sections.begin();
    const auto end = begin + static_cast<std::ptrdiff_t>(m_count);
    const auto lower = [](const ChunkSection& a, const ChunkSection& b) { return a.y < b.y; };
    if (!std::is_sorted(begin, end, lower))
        std::stable_sort(begin, end, lower);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < m_count; ++i) {
        if (kept > 0 && m_sections[kept - 1].y == m_sections[i].y) {
            oddities.push_back("section y = " + std::to_string(m_sections[i].y) +
                               " is there twice: the last counts");
            --kept;
        }
        if (kept != i)
            m_sections[kept] = m_sections[i];
        ++kept;
    }
    m_count = kept;
}

}  // namespace terravox::minecraft
