#include "voxelserver/make/worlds/minecraft/voxel_chunk.hpp"

#include <algorithm>

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

}  // namespace terravox::minecraft
