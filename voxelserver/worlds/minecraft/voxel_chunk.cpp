#include "voxelserver/worlds/minecraft/voxel_chunk.hpp"

#include <algorithm>

namespace terravox::minecraft {
namespace {

using voxel::VoxelAttr;

constexpr std::size_t kCells = kSectionVoxels;

// Both kinds of bits of a column are gathered in one word, opaque below and see-through above: one
// table to look up instead of two.
template <class Index>
void fill_bits(const Index* indices, const std::vector<VoxelAttr>& looks,
               VoxelSection::Bits& bits) {
    std::vector<std::uint32_t> kinds;
    kinds.reserve(looks.size());
    for (const VoxelAttr& look : looks)
        kinds.push_back(look.material == voxel::Material::kAir ? 0u
                        : voxel::see_through(look.material)    ? 0x10000u
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
void fill_indices(const std::uint16_t* cells, const std::uint16_t* looks, Index* out) {
    for (std::size_t i = 0; i < kCells; ++i)
        out[i] = static_cast<Index>(looks[cells[i]]);
}

bool all_air(const std::vector<VoxelAttr>& looks) noexcept {
    return std::all_of(looks.begin(), looks.end(), [](const VoxelAttr& look) {
        return look.material == voxel::Material::kAir;
    });
}

}  // namespace

std::size_t VoxelChunk::memory_bytes() const noexcept {
    std::size_t bytes = sizeof *this;
    for (const VoxelSection& s : sections)
        bytes += sizeof s + s.looks.capacity() * sizeof(VoxelAttr) + (s.narrow ? kCells : 0) +
                 (s.wide ? 2 * kCells : 0) + (s.bits ? sizeof *s.bits : 0);
    return bytes;
}

// Blocks of the same look share an entry: most sections need few.
std::uint16_t VoxelMaker::look_index(const VoxelAttr& look, VoxelSection& out) const {
    const auto found = std::find(out.looks.begin(), out.looks.end(), look);
    if (found != out.looks.end())
        return static_cast<std::uint16_t>(found - out.looks.begin());
    out.looks.push_back(look);
    return static_cast<std::uint16_t>(out.looks.size() - 1);
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
        m_number_looks[number] = look_index(m_book.of_number(number), out);
    }
}

VoxelSection VoxelMaker::make(const ChunkBlocks& blocks, const ChunkSection& section) {
    VoxelSection out;
    const std::uint16_t* looks = m_number_looks.data();
    if (section.numeric) {
        look_up_numbers(section, out);
    } else {
        m_attrs.resize(section.palette_size);
        m_looks.resize(section.palette_size);
        m_book.of(std::span(blocks.palette).subspan(section.palette_begin, section.palette_size),
                  m_attrs);
        for (std::size_t i = 0; i < m_attrs.size(); ++i)
            m_looks[i] = look_index(m_attrs[i], out);
        looks = m_looks.data();
    }
    if (all_air(out.looks)) {
        out.looks.clear();
        return out;
    }
    if (out.looks.size() == 1)
        return out;
    out.bits = std::make_unique_for_overwrite<VoxelSection::Bits>();
    if (out.looks.size() <= 256) {
        out.narrow = std::make_unique_for_overwrite<std::uint8_t[]>(kCells);
        fill_indices(section.cells.data(), looks, out.narrow.get());
        fill_bits(out.narrow.get(), out.looks, *out.bits);
    } else {
        out.wide = std::make_unique_for_overwrite<std::uint16_t[]>(kCells);
        fill_indices(section.cells.data(), looks, out.wide.get());
        fill_bits(out.wide.get(), out.looks, *out.bits);
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

}  // namespace terravox::minecraft
