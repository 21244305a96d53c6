#include <cmath>
#include <numeric>

#include "tests/bench/accuracy/errors.hpp"
#include "tests/bench/accuracy/measures.hpp"

namespace terravox::bench {
namespace {

/// The runs of the columns under one crown, joined where they touch.
class Crown {
public:
    Crown(const VoxelField& found, const TreeTop& tree) : m_found(found) {
        const int reach = std::max(1, static_cast<int>(std::ceil(tree.radius_m)));
        const int column = static_cast<int>(tree.east_m);
        const int row = static_cast<int>(tree.south_m);
        m_side = 2 * reach + 1;
        m_first.assign(static_cast<std::size_t>(m_side) * static_cast<std::size_t>(m_side) + 1, 0);
        for (int r = 0; r < m_side; ++r)
            for (int c = 0; c < m_side; ++c) {
                const int dc = c - reach;
                const int dr = r - reach;
                if (dc * dc + dr * dr <= (tree.radius_m + 0.5) * (tree.radius_m + 0.5) &&
                    found.area().holds(column + dc, row + dr))
                    take(found.area().index(column + dc, row + dr));
                m_first[cell(c, r) + 1] = m_runs.size();
            }
        m_parent.resize(m_runs.size());
        std::iota(m_parent.begin(), m_parent.end(), std::size_t{0});
        join();
    }

    /// Whether the highest plant is joined to one that stands on the ground; true without any
    /// plant.
    [[nodiscard]] bool stands() {
        std::size_t top = m_runs.size();
        for (std::size_t i = 0; i < m_runs.size(); ++i)
            if (voxel::is_plant(m_runs[i].run.material) &&
                (top == m_runs.size() || m_runs[i].run.y1 > m_runs[top].run.y1))
                top = i;
        if (top == m_runs.size())
            return true;
        for (std::size_t i = 0; i < m_runs.size(); ++i)
            if (m_runs[i].on_ground && root(i) == root(top))
                return true;
        return false;
    }

private:
    struct Item {
        FoundRun run;
        bool on_ground;
    };
    [[nodiscard]] std::size_t cell(int c, int r) const noexcept {
        return static_cast<std::size_t>(r) * static_cast<std::size_t>(m_side) +
               static_cast<std::size_t>(c);
    }

    void take(std::size_t index) {
        const int ground = m_found.ground_top(index).value_or(-(1 << 20));
        for (const FoundRun& run : m_found.runs(index))
            if (run.y0 >= ground)
                m_runs.push_back({run, run.y0 == ground});
    }
    std::size_t root(std::size_t i) {
        while (m_parent[i] != i)
            i = m_parent[i] = m_parent[m_parent[i]];
        return i;
    }
    void join_cells(std::size_t a, std::size_t b, int apart) {
        for (std::size_t i = m_first[a]; i < m_first[a + 1]; ++i)
            for (std::size_t k = m_first[b]; k < m_first[b + 1]; ++k)
                if (m_runs[i].run.y0 < m_runs[k].run.y1 + apart &&
                    m_runs[k].run.y0 < m_runs[i].run.y1 + apart)
                    m_parent[root(i)] = root(k);
    }
    // Side by side: a common height. In one column: one directly upon the other.
    void join() {
        for (int r = 0; r < m_side; ++r)
            for (int c = 0; c < m_side; ++c) {
                join_cells(cell(c, r), cell(c, r), 1);
                if (c + 1 < m_side)
                    join_cells(cell(c, r), cell(c + 1, r), 0);
                if (r + 1 < m_side)
                    join_cells(cell(c, r), cell(c, r + 1), 0);
            }
    }

    const VoxelField& m_found;
    int m_side = 1;
    std::vector<std::size_t> m_first;
    std::vector<Item> m_runs;
    std::vector<std::size_t> m_parent;
};

}  // namespace

void measure_trees(const TruthPlace& truth, const VoxelField& found, Readings& readings) {
    const auto real = truth.trees();
    const auto& tops = found.trees();
    const TreeMatch match = match_trees(tops, real, kMinTree_m);
    Errors heights;
    Share floating;
    for (const auto& pair : match.pairs) {
        heights.add(tops[pair.found].height_m - real[pair.real].height_m);
        floating.add(!Crown(found, real[pair.real]).stands());
    }
    readings.add("trees: true", "trees", static_cast<double>(match.pairs.size() + match.missed));
    readings.add("trees: precision", "", match.precision());
    readings.add("trees: recall", "", match.recall());
    readings.add("trees: F1", "", match.f1(), at_least(0.8));
    readings.add("trees: height RMSE", "m", heights.rmse());
    readings.add("trees: height bias", "m", heights.bias());
    readings.add("trees: crowns that float", "share", floating.value());
}

}  // namespace terravox::bench
