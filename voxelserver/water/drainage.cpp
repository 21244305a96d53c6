#include "voxelserver/water/drainage.hpp"

#include <algorithm>
#include <queue>

namespace terravox::water {
namespace {

constexpr std::int32_t kNone = Adjacency::kNone;
constexpr int kMaxOutletRounds = 16;
// An end so little above the lowest section is the outlet: the lowest section is lower only by
// noise.
constexpr double kEndRise_m = 0.1;

std::size_t at(std::int32_t i) {
    return static_cast<std::size_t>(i);
}

void rank(Drainage& d) {
    d.rank.resize(d.order.size());
    for (std::size_t k = 0; k < d.order.size(); ++k)
        d.rank[at(d.order[k])] = static_cast<std::int32_t>(k);
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
    out.ways.parent.assign(levels.size(), kNone);
    std::vector<char> reached(levels.size());
    std::priority_queue<Waiting> queue;
    for (const std::int32_t o : outlets) {
        queue.push({levels[at(o)], o, kNone});
        reached[at(o)] = 1;
    }
    while (!queue.empty()) {
        const Waiting now = queue.top();
        queue.pop();
        out.ways.order.push_back(now.section);
        out.ways.parent[at(now.section)] = now.from;
        out.filled[at(now.section)] = now.level;
        sections.each_neighbour(now.section, [&](std::int32_t n) {
            if (reached[at(n)] != 0)
                return;
            reached[at(n)] = 1;
            queue.push({std::max(now.level, levels[at(n)]), n, now.section});
        });
    }
    rank(out.ways);
    return out;
}

// Finds the outlet of a group of sections: the lowest dead end when it is nearly the lowest section
// of all, else the lowest section.
class OutletOf {
public:
    OutletOf(const RiverSections& sections, const std::vector<double>& levels)
        : m_sections(sections), m_levels(levels) {}
    void add(std::int32_t s) {
        if (lower(s, m_lowest))
            m_lowest = s;
        if (m_sections.begin[at(s) + 1] - m_sections.begin[at(s)] <= 1 && lower(s, m_end))
            m_end = s;
    }
    [[nodiscard]] std::int32_t section() const {
        return m_end != kNone && m_levels[at(m_end)] <= m_levels[at(m_lowest)] + kEndRise_m
                   ? m_end
                   : m_lowest;
    }
    [[nodiscard]] std::int32_t end() const { return m_end; }  ///< kNone: no dead end

private:
    [[nodiscard]] bool lower(std::int32_t a, std::int32_t b) const {
        return b == kNone || m_levels[at(a)] < m_levels[at(b)] ||
               (m_levels[at(a)] == m_levels[at(b)] && a < b);
    }
    const RiverSections& m_sections;
    const std::vector<double>& m_levels;
    std::int32_t m_lowest = kNone;
    std::int32_t m_end = kNone;
};

// The lowest end in each hollow, where it lies deeper than the rim. A hollow without an end is a
// measurement error.
std::vector<std::int32_t> hollows(const RiverSections& sections, const std::vector<double>& levels,
                                  const std::vector<double>& filled, double rim_m) {
    std::vector<char> seen(levels.size());
    std::vector<std::int32_t> out;
    std::vector<std::int32_t> stack;
    for (std::int32_t start = 0; start < sections.size(); ++start) {
        if (seen[at(start)] != 0 || !(filled[at(start)] > levels[at(start)]))
            continue;
        OutletOf hollow(sections, levels);
        stack.push_back(start);
        seen[at(start)] = 1;
        while (!stack.empty()) {
            const std::int32_t s = stack.back();
            stack.pop_back();
            hollow.add(s);
            sections.each_neighbour(s, [&](std::int32_t n) {
                if (seen[at(n)] != 0 || !(filled[at(n)] > levels[at(n)]))
                    return;
                seen[at(n)] = 1;
                stack.push_back(n);
            });
        }
        if (const std::int32_t end = hollow.end();
            end != kNone && filled[at(end)] - levels[at(end)] > rim_m)
            out.push_back(end);
    }
    return out;
}

}  // namespace

Drainage breadth_first(const RiverSections& sections, std::int32_t root) {
    Drainage out;
    out.parent.assign(at(sections.size()), kNone);
    std::vector<char> seen(at(sections.size()));
    out.order.push_back(root);
    seen[at(root)] = 1;
    for (std::size_t head = 0; head < out.order.size(); ++head)
        sections.each_neighbour(out.order[head], [&](std::int32_t n) {
            if (seen[at(n)] != 0)
                return;
            seen[at(n)] = 1;
            out.parent[at(n)] = out.order[head];
            out.order.push_back(n);
        });
    rank(out);
    return out;
}

Drainage drain(const RiverSections& sections, const std::vector<double>& levels, double rim_m) {
    OutletOf whole(sections, levels);
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
    std::vector<std::int32_t> pooled_into(count, kNone);
    std::vector<std::vector<std::int32_t>> above(count);
    const auto level = [&](std::int32_t b) { return sum[at(b)] / weight[at(b)]; };
    const auto higher = [&](std::int32_t a, std::int32_t b) {
        return level(a) != level(b) ? level(a) > level(b) : a > b;
    };
    for (std::size_t k = count; k-- > 0;) {
        const std::int32_t here = drainage.order[k];
        auto& heap = above[at(here)];
        std::make_heap(heap.begin(), heap.end(), higher);
        while (!heap.empty() && level(heap.front()) < level(here)) {
            const std::int32_t block = heap.front();
            std::pop_heap(heap.begin(), heap.end(), higher);
            heap.pop_back();
            sum[at(here)] += sum[at(block)];
            weight[at(here)] += weight[at(block)];
            pooled_into[at(block)] = here;
            auto& other = above[at(block)];
            if (other.size() > heap.size())
                heap.swap(other);
            for (const std::int32_t b : other) {
                heap.push_back(b);
                std::push_heap(heap.begin(), heap.end(), higher);
            }
            std::vector<std::int32_t>().swap(other);
        }
        if (const std::int32_t p = drainage.parent[at(here)]; p != kNone)
            above[at(p)].push_back(here);
    }
    std::vector<double> out(count);
    for (const std::int32_t s : drainage.order)
        out[at(s)] = pooled_into[at(s)] == kNone ? level(s) : out[at(pooled_into[at(s)])];
    return out;
}

void raise_to_lower(const RiverSections& sections, const Drainage& drainage,
                    std::vector<double>& levels) {
    for (const std::int32_t s : drainage.order)
        sections.each_neighbour(s, [&](std::int32_t n) {
            if (drainage.rank[at(n)] < drainage.rank[at(s)])
                levels[at(s)] = std::max(levels[at(s)], levels[at(n)]);
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
            if (drainage.rank[at(n)] > drainage.rank[at(s)])
                lower[at(s)] = std::min(lower[at(s)], lower[at(n)]);
        });
    }
    for (std::size_t i = 0; i < upper.size(); ++i)
        upper[i] = (upper[i] + lower[i]) / 2;
    return upper;
}

}  // namespace terravox::water
