#include "raytracer/analyse/objects/connected_cells.hpp"

#include <string>
#include <utility>

#include "common/util/error.hpp"

namespace terravox::analyse {

void check_stop(const std::stop_token& stop) {
    if (stop.stop_requested())
        throw util::Error("interrupted");
}

RowLabels::RowLabels(int columns)
    : m_parents(1, kNone), m_row(static_cast<std::size_t>(columns), kNone) {}

std::int32_t RowLabels::joined(std::int32_t label) noexcept {
    while (m_parents[static_cast<std::size_t>(label)] != label) {
        auto& parent = m_parents[static_cast<std::size_t>(label)];
        // The way is halved for those that follow.
        parent = m_parents[static_cast<std::size_t>(parent)];
        label = parent;
    }
    return label;
}

std::int32_t RowLabels::new_label() {
    if (last() == kMaxLabels)
        throw util::Error("find the buildings: more than " + std::to_string(kMaxLabels) +
                          " pieces of them; allowed: fewer, by a smaller --area or a coarser "
                          "--resolution");
    const std::int32_t label = last() + 1;
    m_parents.push_back(label);
    return label;
}

ConnectedCells::ConnectedCells(CellFile& cells, double cell_m2, const std::stop_token& stop)
    : m_cells(cells), m_stop(stop) {
    RowLabels labels(cells.columns());
    EnergyRows rows(cells, {0, 0, cells.columns(), cells.rows()});
    const auto join = [&](std::int32_t kept, std::int32_t dropped) {
        // A label of this row has no sums yet.
        const auto from = m_growing.find(dropped);
        if (from == m_growing.end())
            return;
        m_growing[kept].sums.add(from->second.sums);
        m_growing.erase(from);
    };
    while (rows.next()) {
        check_stop(stop);
        labels.next([&](int x) { return rows.is_building(x); }, join);
        for (int x = 0; x < cells.columns(); ++x) {
            const std::int32_t label = labels.row()[static_cast<std::size_t>(x)];
            if (label == RowLabels::kNone)
                continue;
            Growing& growing = m_growing[labels.joined(label)];
            growing.sums.add(rows.at(x), cell_m2);
            growing.last_row = rows.row();
        }
        finish_above(rows.row(), cell_m2);
    }
    finish_above(cells.rows(), cell_m2);
    m_numbers.resize(static_cast<std::size_t>(labels.last()) + 1);
    number_all();
    for (std::size_t label = 1; label < m_numbers.size(); ++label) {
        const auto joined =
            static_cast<std::size_t>(labels.joined(static_cast<std::int32_t>(label)));
        m_numbers[label] = m_numbers[joined];
    }
}

void ConnectedCells::finish_above(int row, double cell_m2) {
    for (auto at = m_growing.begin(); at != m_growing.end();) {
        if (at->second.last_row == row) {
            ++at;
            continue;
        }
        if (m_done.size() == kMaxObjects)
            throw util::Error("find the buildings: more than " + std::to_string(kMaxObjects) +
                              "; allowed: fewer, by a smaller --area");
        m_done.emplace(at->first, facts_of(at->second.sums, cell_m2));
        at = m_growing.erase(at);
    }
}

void ConnectedCells::number_all() {
    m_facts.reserve(m_done.size());
    for (const auto& [label, facts] : m_done) {
        m_facts.push_back(facts);
        m_numbers[static_cast<std::size_t>(label)] = static_cast<std::int32_t>(m_facts.size());
    }
    m_done.clear();
}

}  // namespace terravox::analyse
