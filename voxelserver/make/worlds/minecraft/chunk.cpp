#include "voxelserver/make/worlds/minecraft/chunk.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "voxelserver/make/worlds/minecraft/cells.hpp"
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
        throw util::Error("Blocks of " + std::to_string(raw.blocks.size()) +
                          " bytes; allowed: 32768");
    if (!raw.data.empty() && raw.data.size() != kColumnBlocks / 2)
        throw util::Error("Data of " + std::to_string(raw.data.size()) + " bytes; allowed: 16384");
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
            throw util::Error("it says that it is chunk " + std::to_string(*raw.x) + ", " +
                              std::to_string(*raw.z));
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

}  // namespace terravox::minecraft
