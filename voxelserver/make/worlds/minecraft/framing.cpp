#include "voxelserver/make/worlds/minecraft/framing.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include "common/voxel/world.hpp"

namespace terravox::minecraft {
namespace {

constexpr std::int32_t kCell = 8;  // chunks across: parts are connected when their cells touch

struct Cell {
    std::size_t chunks = 0;
    ChunkArea area;
    bool taken = false;
};
using Cells =
    std::map<ChunkPlace, Cell>;  // ordered, so that the first one does not depend on hashes

void add(Cell& to, std::size_t chunks, const ChunkArea& area) {
    to.area =
        to.chunks == 0
            ? area
            : ChunkArea{{std::min(to.area.min.x, area.min.x), std::min(to.area.min.z, area.min.z)},
                        {std::max(to.area.max.x, area.max.x), std::max(to.area.max.z, area.max.z)}};
    to.chunks += chunks;
}

// All cells connected with a cell.
Cell part_from(Cells& cells, Cells::iterator first) {
    Cell out;
    std::vector<Cells::iterator> open{first};
    first->second.taken = true;
    while (!open.empty()) {
        const auto at = open.back();
        open.pop_back();
        add(out, at->second.chunks, at->second.area);
        for (std::int32_t i = 0; i < 9; ++i) {
            const auto next = cells.find({at->first.x + i % 3 - 1, at->first.z + i / 3 - 1});
            if (next == cells.end() || next->second.taken)
                continue;
            next->second.taken = true;
            open.push_back(next);
        }
    }
    return out;
}

}  // namespace

std::optional<ChunkArea> main_part(std::span<const ChunkPlace> places) {
    Cells cells;
    for (const ChunkPlace& p : places)
        add(cells[{voxel::floor_div(p.x, kCell), voxel::floor_div(p.z, kCell)}], 1,
            {p, {p.x + 1, p.z + 1}});
    Cell largest;
    for (auto cell = cells.begin(); cell != cells.end(); ++cell) {
        if (cell->second.taken)
            continue;
        const Cell part = part_from(cells, cell);
        if (part.chunks > largest.chunks)
            largest = part;
    }
    if (largest.chunks == places.size())
        return std::nullopt;
    return largest.area;
}

}  // namespace terravox::minecraft
