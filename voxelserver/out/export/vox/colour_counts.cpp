#include "voxelserver/out/export/vox/colour_counts.hpp"

#include <algorithm>

namespace terravox::exports {

void ColourCounts::add(voxel::Rgb8 c) {
    Sum& sum = m_sums[key_of(c)];
    ++sum.count;
    sum.r += c.r;
    sum.g += c.g;
    sum.b += c.b;
    while (m_sums.size() > kMaxCells)
        coarsen();
}

void ColourCounts::coarsen() {
    ++m_shift;
    std::unordered_map<std::uint32_t, Sum> next;
    for (const auto& [key, sum] : m_sums) {
        Sum& to = next[key >> 1 & 0x7F7F7F];
        to.count += sum.count;
        to.r += sum.r;
        to.g += sum.g;
        to.b += sum.b;
    }
    m_sums = std::move(next);
}

std::vector<ColourCounts::Cell> ColourCounts::cells() const {
    std::vector<Cell> out;
    out.reserve(m_sums.size());
    for (const auto& [key, sum] : m_sums) {
        const auto mean = [&](std::uint64_t s) {
            return static_cast<std::uint8_t>((s + sum.count / 2) / sum.count);
        };
        out.push_back({key, sum.count, {mean(sum.r), mean(sum.g), mean(sum.b)}});
    }
    std::sort(out.begin(), out.end(), [](const Cell& a, const Cell& b) { return a.key < b.key; });
    return out;
}

}  // namespace terravox::exports
