#include <algorithm>

#include "voxelserver/make/worlds/minecraft/chunk.hpp"

namespace terravox::minecraft {

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
