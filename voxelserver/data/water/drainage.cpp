#include "voxelserver/data/water/river.hpp"

#include <algorithm>
#include <queue>

#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {
namespace {

constexpr int kMaxOutletRounds = 16;
// An end so little above the lowest section is the outlet: the lowest section is lower only by
// noise.
constexpr double kEndRise_m = 0.1;

void rank(Drainage& d) {
    d.rank.resize(d.order.size());
    for (std::size_t k = 0; k < d.order.size(); ++k)
        d.rank[to_index(d.order[k])] = static_cast<std::int32_t>(k);
}

struct Flood {
    Drainage ways;
    std::vector<double> filled;  // the lowest level at which a section's water can flow off
};

Flood flood(const RiverSections& sections, const std::vector<double>& levels,
            const std::vector<std::int32_t>& outlets) {
    struct Waiting {
        double level;
        std::int32_t section;
        std::int32_t from;
        bool operator<(const Waiting& o) const noexcept {
            return level != o.level ? level > o.level : section > o.section;
        }
    };
    Flood out;
    out.filled.assign(levels.size(), 0);
    out.ways.parent.assign(levels.size(), Adjacency::kNone);
    std::vector<char> reached(levels.size());
    std::priority_queue<Waiting> queue;
    for (const std::int32_t o : outlets) {
        queue.push({levels[to_index(o)], o, Adjacency::kNone});
        reached[to_index(o)] = 1;
    }
    while (!queue.empty()) {
        const Waiting now = queue.top();
        queue.pop();
        out.ways.order.push_back(now.section);
        out.ways.parent[to_index(now.section)] = now.from;
        out.filled[to_index(now.section)] = now.level;
        sections.each_neighbour(now.section, [&](std::int32_t n) {
            if (reached[to_index(n)] != 0)
                return;
            reached[to_index(n)] = 1;
            queue.push({std::max(now.level, levels[to_index(n)]), n, now.section});
        });
    }
    rank(out.ways);
    return out;
}

// Finds the outlet of a group of sections: the lowest dead end when it is nearly the lowest section
// of all, else the lowest section.
class OutletFinder {
public:
    OutletFinder(const RiverSections& sections, const std::vector<double>& levels)
        : m_sections(sections), m_levels(levels) {}
    void add(std::int32_t s) {
        if (lower(s, m_lowest))
            m_lowest = s;
        if (m_sections.begin[to_index(s) + 1] - m_sections.begin[to_index(s)] <= 1 &&
            lower(s, m_end))
            m_end = s;
    }
    [[nodiscard]] std::int32_t section() const {
        return m_end != Adjacency::kNone &&
                       m_levels[to_index(m_end)] <= m_levels[to_index(m_lowest)] + kEndRise_m
                   ? m_end
                   : m_lowest;
    }
    [[nodiscard]] std::int32_t end() const { return m_end; }  ///< Adjacency::kNone: no dead end

private:
    [[nodiscard]] bool lower(std::int32_t a, std::int32_t b) const {
        return b == Adjacency::kNone || m_levels[to_index(a)] < m_levels[to_index(b)] ||
               (m_levels[to_index(a)] == m_levels[to_index(b)] && a < b);
    }
    const RiverSections& m_sections;
    const std::vector<double>& m_levels;
    std::int32_t m_lowest = Adjacency::kNone;
    std::int32_t m_end = Adjacency::kNone;
};

// The lowest end in each hollow, where it lies deeper than the rim. A hollow without an end is a
// measurement error.
std::vector<std::int32_t> hollows(const RiverSections& sections, const std::vector<double>& levels,
                                  const std::vector<double>& filled, double rim_m) {
    std::vector<char> seen(levels.size());
    std::vector<std::int32_t> out;
    std::vector<std::int32_t> stack;
    for (std::int32_t start = 0; start < sections.size(); ++start) {
        if (seen[to_index(start)] != 0 || !(filled[to_index(start)] > levels[to_index(start)]))
            continue;
        OutletFinder hollow(sections, levels);
        stack.push_back(start);
        seen[to_index(start)] = 1;
        while (!stack.empty()) {
            const std::int32_t s = stack.back();
            stack.pop_back();
            hollow.add(s);
            sections.each_neighbour(s, [&](std::int32_t n) {
                if (seen[to_index(n)] != 0 || !(filled[to_index(n)] > levels[to_index(n)]))
                    return;
                seen[to_index(n)] = 1;
                stack.push_back(n);
            });
        }
        if (const std::int32_t end = hollow.end();
            end != Adjacency::kNone && filled[to_index(end)] - levels[to_index(end)] > rim_m)
            out.push_back(end);
    }
    return out;
}

}  // namespace

Drainage breadth_first(const RiverSections& sections, std::int32_t root) {
    Drainage out;
    out.parent.assign(to_index(sections.size()), Adjacency::kNone);
    std::vector<char> seen(to_index(sections.size()));
    out.order.push_back(root);
    seen[to_index(root)] = 1;
    for (std::size_t head = 0; head < out.order.size(); ++head)
        sections.each_neighbour(out.order[head], [&](std::int32_t n) {
            if (seen[to_index(n)] != 0)
                return;
            seen[to_index(n)] = 1;
            out.parent[to_index(n)] = out.order[head];
            out.order.push_back(n);
        });
    rank(out);
    return out;
}

Drainage drain(const RiverSections& sections, const std::vector<double>& levels, double rim_m) {
    OutletFinder whole(sections, levels);
    for (std::int32_t s = 0; s < sections.size(); ++s)
        whole.add(s);
    std::vector<std::int32_t> outlets{whole.section()};
    for (int round = 0;; ++round) {
        Flood f = flood(sections, levels, outlets);
        const std::vector<std::int32_t> more = round < kMaxOutletRounds
                                                   ? hollows(sections, levels, f.filled, rim_m)
                                                   : std::vector<std::int32_t>{};
        if (more.empty())
            return std::move(f.ways);
        outlets.insert(outlets.end(), more.begin(), more.end());
    }
}

std::vector<double> isotonic(const Drainage& drainage, const std::vector<double>& levels,
                             const std::vector<double>& weights) {
    // From the ends down: a section that is higher than the lowest block above it is pooled with
    // that block, and so on. Blocks are named by their lowest section; each waits in its parent's
    // heap, and heaps are merged the smaller into the larger.
    const std::size_t count = levels.size();
    std::vector<double> sum(count);
    std::vector<double> weight = weights;
    for (std::size_t i = 0; i < count; ++i)
        sum[i] = levels[i] * weights[i];
    std::vector<std::int32_t> pooled_into(count, Adjacency::kNone);
    std::vector<std::vector<std::int32_t>> above(count);
    const auto level = [&](std::int32_t b) { return sum[to_index(b)] / weight[to_index(b)]; };
    const auto higher = [&](std::int32_t a, std::int32_t b) {
        return level(a) != level(b) ? level(a) > level(b) : a > b;
    };
    for (std::size_t k = count; k-- > 0;) {
        const std::int32_t here = drainage.order[k];
        auto& heap = above[to_index(here)];
        std::make_heap(heap.begin(), heap.end(), higher);
        while (!heap.empty() && level(heap.front()) < level(here)) {
            const std::int32_t block = heap.front();
            std::pop_heap(heap.begin(), heap.end(), higher);
            heap.pop_back();
            sum[to_index(here)] += sum[to_index(block)];
            weight[to_index(here)] += weight[to_index(block)];
            pooled_into[to_index(block)] = here;
            auto& other = above[to_index(block)];
            if (other.size() > heap.size())
                heap.swap(other);
            for (const std::int32_t b : other) {
                heap.push_back(b);
                std::push_heap(heap.begin(), heap.end(), higher);
            }
            std::vector<std::int32_t>().swap(other);
        }
        if (const std::int32_t p = drainage.parent[to_index(here)]; p != Adjacency::kNone)
            above[to_index(p)].push_back(here);
    }
    std::vector<double> out(count);
    for (const std::int32_t s : drainage.order)
        out[to_index(s)] = pooled_into[to_index(s)] == Adjacency::kNone
                               ? level(s)
                               : out[to_index(pooled_into[to_index(s)])];
    return out;
}

void raise_to_lower(const RiverSections& sections, const Drainage& drainage,
                    std::vector<double>& levels) {
    for (const std::int32_t s : drainage.order)
        sections.each_neighbour(s, [&](std::int32_t n) {
            if (drainage.rank[to_index(n)] < drainage.rank[to_index(s)])
                levels[to_index(s)] = std::max(levels[to_index(s)], levels[to_index(n)]);
        });
}

std::vector<double> between_envelopes(const RiverSections& sections, const Drainage& drainage,
                                      const std::vector<double>& levels) {
    std::vector<double> upper = levels;
    std::vector<double> lower = levels;
    raise_to_lower(sections, drainage, upper);
    for (std::size_t k = drainage.order.size(); k-- > 0;) {
        const std::int32_t s = drainage.order[k];
        sections.each_neighbour(s, [&](std::int32_t n) {
            if (drainage.rank[to_index(n)] > drainage.rank[to_index(s)])
                lower[to_index(s)] = std::min(lower[to_index(s)], lower[to_index(n)]);
        });
    }
    for (std::size_t i = 0; i < upper.size(); ++i)
        upper[i] = (upper[i] + lower[i]) / 2;
    return upper;
}

}  // namespace terravox::water
