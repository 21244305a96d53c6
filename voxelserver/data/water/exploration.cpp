#include "voxelserver/data/water/exploration.hpp"

#include <algorithm>
#include <string>

#include "common/util/error.hpp"

namespace terravox::water {

std::shared_ptr<const CellPatch> checked_cells(CellSource& source, PatchIndex patch, int side) {
    auto cells = source.cells(patch.x, patch.z);
    if (!cells || cells->side != side ||
        cells->cells.size() != static_cast<std::size_t>(side) * static_cast<std::size_t>(side))
        throw util::Error(
            "find water: patch " + std::to_string(patch.x) + ", " + std::to_string(patch.z) +
            " has " + (cells ? std::to_string(cells->cells.size()) : "no") + " cells; expected " +
            std::to_string(side) + " x " + std::to_string(side));
    return cells;
}

bool Exploration::run(CellPlace start, const Bounds& bounds) {
    m_bounds = bounds;
    const PatchIndex patch{floor_div(start.x, m_side), floor_div(start.z, m_side)};
    if (bounds.square)
        m_square = {floor_div(patch.x, *bounds.square), floor_div(patch.z, *bounds.square)};
    cross(patch, start.x - patch.x * m_side, start.z - patch.z * m_side);
    for (std::size_t head = 0; head < m_queue.size() && !m_exceeded; ++head)
        spread(m_queue[head]);
    m_queue.clear();
    return !m_exceeded;
}

// Loads the patch; null outside the square, or when the bounds are exceeded.
Exploration::Visited* Exploration::visit(PatchIndex patch) {
    if (m_bounds.square && !(PatchIndex{floor_div(patch.x, *m_bounds.square),
                                        floor_div(patch.z, *m_bounds.square)} == m_square))
        return nullptr;
    if (const auto found = m_visits.find(patch); found != m_visits.end())
        return &found->second;
    if (m_visits.size() >= m_bounds.patches) {
        m_exceeded = true;
        return nullptr;
    }
    Visited v;
    v.cells = checked_cells(m_source, patch, m_side);
    v.found.assign(v.cells->cells.size(), 0);
    if (m_bounds.oversize)
        if (const auto known = m_bounds.oversize->find(patch); known != m_bounds.oversize->end())
            v.oversize = &known->second;
    return &m_visits.emplace(patch, std::move(v)).first->second;
}

void Exploration::touch(PatchIndex patch, Visited& v, int x, int z) {
    const auto i = static_cast<std::size_t>(z * m_side + x);
    if (v.found[i] != 0 || !is_candidate(v.cells->cells[i], m_evidence))
        return;
    if (v.oversize && (*v.oversize)[i] != 0)
        m_exceeded = true;
    // It may be in the queue twice: the second time there is nothing to do.
    if (v.waiting.empty())
        m_queue.push_back(patch);
    v.found[i] = 1;
    ++v.count;
    v.waiting.push_back(static_cast<std::int32_t>(i));
}

void Exploration::cross(PatchIndex to, int x, int z) {
    if (Visited* v = visit(to))
        touch(to, *v, x, z);
}

void Exploration::spread(PatchIndex patch) {
    Visited& v = m_visits.find(patch)->second;
    const int last = m_side - 1;
    while (!v.waiting.empty() && !m_exceeded) {
        const int i = v.waiting.back();
        const int x = i % m_side;
        const int z = i / m_side;
        if (x == 0)
            cross({patch.x - 1, patch.z}, last, z);
        if (x == last)
            cross({patch.x + 1, patch.z}, 0, z);
        if (z == 0)
            cross({patch.x, patch.z - 1}, x, last);
        if (z == last)
            cross({patch.x, patch.z + 1}, x, 0);
        v.waiting.pop_back();
        if (x > 0)
            touch(patch, v, x - 1, z);
        if (x < last)
            touch(patch, v, x + 1, z);
        if (z > 0)
            touch(patch, v, x, z - 1);
        if (z < last)
            touch(patch, v, x, z + 1);
    }
}

void Exploration::list() {
    std::vector<const std::pair<const PatchIndex, Visited>*> sorted;
    for (const auto& entry : m_visits)
        if (entry.second.count > 0)
            sorted.push_back(&entry);
    std::sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) {
        return a->first.z != b->first.z ? a->first.z < b->first.z : a->first.x < b->first.x;
    });
    for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
        while (end < sorted.size() && sorted[end]->first.z == sorted[begin]->first.z)
            ++end;
        for (int z = 0; z < m_side; ++z)
            for (std::size_t p = begin; p < end; ++p) {
                const auto& [patch, v] = *sorted[p];
                for (int x = 0; x < m_side; ++x)
                    if (v.found[static_cast<std::size_t>(z * m_side + x)] != 0)
                        m_places.push_back({patch.x * m_side + x, patch.z * m_side + z});
            }
    }
}

voxel::InputExtent Exploration::reach() const noexcept {
    voxel::InputExtent out;
    for (const auto& [patch, v] : m_visits)
        out.add({patch.x, patch.z, patch.x + 1, patch.z + 1});
    return out;
}

const WaterCell* Exploration::find(CellPlace place) const {
    const PatchIndex patch{floor_div(place.x, m_side), floor_div(place.z, m_side)};
    const auto found = m_visits.find(patch);
    return found == m_visits.end()
               ? nullptr
               : &found->second.cells->at(place.x - patch.x * m_side, place.z - patch.z * m_side);
}

}  // namespace terravox::water
