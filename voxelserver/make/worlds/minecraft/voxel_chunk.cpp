#include "voxelserver/make/worlds/minecraft/voxel_chunk.hpp"

#include <algorithm>
#include <bit>

#include "common/voxel/box_builder.hpp"

namespace terravox::minecraft {
namespace {

using voxel::VoxelAttr;

constexpr std::size_t kCells = kSectionVoxels;

// Both kinds of bits of a column are gathered in one word, opaque below and see-through above: one
// table to look up instead of two.
template <class Index>
void fill_bits(const Index* indices, const std::vector<VoxelAttr>& appearances,
               VoxelSection::Bits& bits) {
    std::vector<std::uint32_t> kinds;
    kinds.reserve(appearances.size());
    for (const VoxelAttr& appearance : appearances)
        kinds.push_back(appearance.material == voxel::Material::kAir ? 0u
                        : voxel::see_through(appearance.material)    ? 0x10000u
                                                                     : 1u);
    std::array<std::uint32_t, 256> columns{};
    for (unsigned y = 0; y < 16; ++y)
        for (std::size_t column = 0; column < 256; ++column)
            columns[column] |= kinds[indices[y * 256 + column]] << y;
    for (std::size_t column = 0; column < 256; ++column) {
        bits.opaque[column] = static_cast<std::uint16_t>(columns[column]);
        bits.clear[column] = static_cast<std::uint16_t>(columns[column] >> 16);
    }
}

template <class Index>
void fill_indices(const std::uint16_t* cells, const std::uint16_t* appearances, Index* out) {
    for (std::size_t i = 0; i < kCells; ++i)
        out[i] = static_cast<Index>(appearances[cells[i]]);
}

bool all_air(const std::vector<VoxelAttr>& appearances) noexcept {
    return std::all_of(appearances.begin(), appearances.end(), [](const VoxelAttr& appearance) {
        return appearance.material == voxel::Material::kAir;
    });
}

}  // namespace

std::size_t VoxelChunk::memory_bytes() const noexcept {
    std::size_t bytes = sizeof *this;
    for (const VoxelSection& s : sections)
        bytes += sizeof s + s.appearances.capacity() * sizeof(VoxelAttr) + (s.narrow ? kCells : 0) +
                 (s.wide ? 2 * kCells : 0) + (s.bits ? sizeof *s.bits : 0);
    return bytes;
}

// Blocks of the same appearance share an entry: most sections need few.
std::uint16_t VoxelMaker::appearance_index(const VoxelAttr& appearance, VoxelSection& out) const {
    const auto found = std::find(out.appearances.begin(), out.appearances.end(), appearance);
    if (found != out.appearances.end())
        return static_cast<std::uint16_t>(found - out.appearances.begin());
    out.appearances.push_back(appearance);
    return static_cast<std::uint16_t>(out.appearances.size() - 1);
}

void VoxelMaker::look_up_numbers(const ChunkSection& section, VoxelSection& out) {
    if (++m_stamp == 0) {
        std::fill(m_stamps.begin(), m_stamps.end(), 0u);
        m_stamp = 1;
    }
    int last = -1;  // runs are long: most cells are like the one before
    for (const std::uint16_t number : section.cells) {
        if (number == last)
            continue;
        last = number;
        if (m_stamps[number] == m_stamp)
            continue;
        m_stamps[number] = m_stamp;
        m_number_appearances[number] = appearance_index(m_block_appearances.of_number(number), out);
    }
}

VoxelSection VoxelMaker::make(const ChunkBlocks& blocks, const ChunkSection& section) {
    VoxelSection out;
    const std::uint16_t* appearances = m_number_appearances.data();
    if (section.numeric) {
        look_up_numbers(section, out);
    } else {
        m_attrs.resize(section.palette_size);
        m_appearances.resize(section.palette_size);
        m_block_appearances.of(
            std::span(blocks.palette).subspan(section.palette_begin, section.palette_size),
            m_attrs);
        for (std::size_t i = 0; i < m_attrs.size(); ++i)
            m_appearances[i] = appearance_index(m_attrs[i], out);
        appearances = m_appearances.data();
    }
    if (all_air(out.appearances)) {
        out.appearances.clear();
        return out;
    }
    if (out.appearances.size() == 1)
        return out;
    out.bits = std::make_unique_for_overwrite<VoxelSection::Bits>();
    if (out.appearances.size() <= 256) {
        out.narrow = std::make_unique_for_overwrite<std::uint8_t[]>(kCells);
        fill_indices(section.cells.data(), appearances, out.narrow.get());
        fill_bits(out.narrow.get(), out.appearances, *out.bits);
    } else {
        out.wide = std::make_unique_for_overwrite<std::uint16_t[]>(kCells);
        fill_indices(section.cells.data(), appearances, out.wide.get());
        fill_bits(out.wide.get(), out.appearances, *out.bits);
    }
    return out;
}

VoxelChunk VoxelMaker::make(const ChunkBlocks& blocks) {
    VoxelChunk out;
    for (const ChunkSection& section : blocks.sections()) {
        VoxelSection made = make(blocks, section);
        if (made.air())
            continue;
        if (out.sections.empty())
            out.first_y = section.y;
        out.sections.resize(static_cast<std::size_t>(section.y - out.first_y));  // air between
        out.sections.push_back(std::move(made));
    }
    return out;
}

namespace {

using voxel::BoxBuilder;
using voxel::kBoxSizeY;

constexpr int kSections = kBoxSizeY / 16;

// The sections of one chunk in a box, with the one below and the one above. nullptr: air.
using Stack = std::array<const VoxelSection*, kSections + 2>;

Stack make_stack(const VoxelChunk* chunk, std::int32_t first_section) noexcept {
    Stack out{};
    if (chunk == nullptr)
        return out;
    for (int i = 0; i < kSections + 2; ++i) {
        const VoxelSection* section = chunk->section(first_section - 1 + i);
        if (section != nullptr && !section->air())
            out[static_cast<std::size_t>(i)] = section;
    }
    return out;
}

bool bare(const Stack& stack) noexcept {
    return std::all_of(stack.begin(), stack.end(),
                       [](const VoxelSection* s) { return s == nullptr; });
}

/// Passes the bits of a column of voxels of one kind to the builder as runs.
class Runs {
public:
    Runs(BoxBuilder& builder, int x, int z, bool opaque) noexcept
        : m_builder(builder), m_x(x), m_z(z), m_opaque(opaque) {}
    /// The 16 voxels from y on; calls come in rising order without gaps.
    void add(int y, unsigned bits) noexcept {
        if (bits == (m_open ? 0xFFFFu : 0u))
            return;
        for (int at = 0; at < 16;) {
            // The next voxel that differs from those before it.
            const int change = std::countr_zero((m_open ? ~bits : bits) >> at);
            if (change >= 16 - at)
                return;
            at += change;
            if (m_open)
                m_builder.add(m_x, m_z, m_begin, y + at, m_opaque);
            else
                m_begin = y + at;
            m_open = !m_open;
        }
    }
    void end(int y) noexcept {
        if (m_open)
            m_builder.add(m_x, m_z, m_begin, y, m_opaque);
    }

private:
    BoxBuilder& m_builder;
    int m_x;
    int m_z;
    int m_begin = 0;
    bool m_opaque;
    bool m_open = false;
};

// For uniform sections: all bits or none.
bool uniform_opaque(const VoxelSection& section) noexcept {
    return !voxel::see_through(section.appearances.front().material);
}

void add_column(BoxBuilder& builder, const Stack& stack, int x, int z, std::size_t column,
                bool with_clear) {
    Runs opaque(builder, x, z, true), clear(builder, x, z, false);
    int y = -16;
    for (const VoxelSection* section : stack) {
        unsigned solid = 0;
        unsigned seen_through = 0;
        if (section != nullptr && section->bits) {
            solid = section->bits->opaque[column];
            seen_through = section->bits->clear[column];
        } else if (section != nullptr)
            (uniform_opaque(*section) ? solid : seen_through) = 0xFFFF;
        opaque.add(y, solid);
        if (with_clear)
            clear.add(y, seen_through);
        y += 16;
    }
    opaque.end(y);
    clear.end(y);
}

}  // namespace

std::shared_ptr<const voxel::Box> to_box(const ChunkPatch& patch, const voxel::BoxKey& key,
                                         std::int32_t lift) {
    const std::int32_t first_section = key.by * kSections - lift / 16;
    std::array<Stack, 36> stacks;
    bool any = false;
    for (std::size_t i = 0; i < patch.size(); ++i) {
        stacks[i] = make_stack(patch[i].get(), first_section);
        const std::size_t x = i % 6;
        const std::size_t z = i / 6;
        if (x > 0 && x < 5 && z > 0 && z < 5)
            any = any || std::any_of(stacks[i].begin() + 1, stacks[i].end() - 1,
                                     [](const auto* s) { return s != nullptr; });
    }
    if (!any)
        return nullptr;
    BoxBuilder builder;
    for (int cz = -1; cz < 5; ++cz)
        for (int cx = -1; cx < 5; ++cx) {
            const Stack& stack = stacks[static_cast<std::size_t>((cz + 1) * 6 + cx + 1)];
            if (bare(stack))
                continue;
            const bool inside = cx >= 0 && cx < 4 && cz >= 0 && cz < 4;
            // Of the chunks around, the row that touches the box; only opaque voxels can hide what
            // is inside.
            const int x0 = cx == -1 ? 15 : 0;
            const int x1 = cx == 4 ? 1 : 16;
            const int z0 = cz == -1 ? 15 : 0;
            const int z1 = cz == 4 ? 1 : 16;
            for (int z = z0; z < z1; ++z)
                for (int x = x0; x < x1; ++x)
                    add_column(builder, stack, cx * 16 + x, cz * 16 + z,
                               static_cast<std::size_t>(x + 16 * z), inside);
        }
    return builder.build(key, [&](int x, int y, int z) {
        const Stack& stack = stacks[static_cast<std::size_t>(((z >> 4) + 1) * 6 + (x >> 4) + 1)];
        return stack[static_cast<std::size_t>((y >> 4) + 1)]->at(
            static_cast<std::size_t>((x & 15) + 16 * (z & 15) + 256 * (y & 15)));
    });
}

}  // namespace terravox::minecraft
