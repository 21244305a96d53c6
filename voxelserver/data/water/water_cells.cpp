#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {

Adjacency::Adjacency(const std::vector<CellPlace>& places)
    : m_neighbours(places.size(), {kNone, kNone, kNone, kNone}) {
    std::size_t above = 0;  // advances along the row to the north
    for (std::size_t i = 0; i < places.size(); ++i) {
        const CellPlace here = places[i];
        if (i > 0 && places[i - 1].z == here.z && places[i - 1].x + 1 == here.x) {
            m_neighbours[i][kWest] = static_cast<std::int32_t>(i - 1);
            m_neighbours[i - 1][kEast] = static_cast<std::int32_t>(i);
        }
        while (above < i && (places[above].z < here.z - 1 ||
                             (places[above].z == here.z - 1 && places[above].x < here.x)))
            ++above;
        if (places[above] == CellPlace{here.x, here.z - 1}) {
            m_neighbours[i][kNorth] = static_cast<std::int32_t>(above);
            m_neighbours[above][kSouth] = static_cast<std::int32_t>(i);
        }
    }
}

std::vector<std::int32_t> Adjacency::parts(const std::vector<char>& flag,
                                           std::int32_t* count) const {
    std::vector<std::int32_t> part(m_neighbours.size(), kNone), stack;
    std::int32_t parts = 0;
    for (std::int32_t start = 0; start < size(); ++start) {
        if (flag[static_cast<std::size_t>(start)] == 0 ||
            part[static_cast<std::size_t>(start)] != kNone)
            continue;
        stack.push_back(start);
        part[static_cast<std::size_t>(start)] = parts;
        while (!stack.empty()) {
            const std::int32_t i = stack.back();
            stack.pop_back();
            for (const std::int32_t n : around(i)) {
                if (n == kNone || flag[static_cast<std::size_t>(n)] == 0 ||
                    part[static_cast<std::size_t>(n)] != kNone)
                    continue;
                part[static_cast<std::size_t>(n)] = parts;
                stack.push_back(n);
            }
        }
        ++parts;
    }
    if (count)
        *count = parts;
    return part;
}

}  // namespace terravox::water
