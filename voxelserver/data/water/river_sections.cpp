#include "voxelserver/data/water/river.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {
namespace {

constexpr std::int32_t kStep = 5, kDiagonal = 7, kKnight = 11;  // chamfer units: 5 per cell
constexpr std::int32_t kRing = 2 * kStep;
constexpr int kNotch = 3;  // sections
constexpr int kNotchRounds = 3;

// The cell reached last by a flood fill is at an end of the body.
std::int32_t find_end(const Adjacency& adjacency) {
    std::vector<char> seen(to_index(adjacency.size()));
    std::vector<std::int32_t> queue{0};
    seen[0] = 1;
    for (std::size_t head = 0; head < queue.size(); ++head)
        for (const std::int32_t n : adjacency.around(queue[head]))
            if (n != Adjacency::kNone && seen[to_index(n)] == 0) {
                seen[to_index(n)] = 1;
                queue.push_back(n);
            }
    return queue.back();
}

template <class Visit>
void visit_far(const Adjacency& adjacency, std::int32_t i, const Visit& visit) {
    for (const std::int32_t n : adjacency.around(i))
        if (n != Adjacency::kNone)
            visit(n, kStep);
    for (const Side x_side : {kWest, kEast})
        for (const Side z_side : {kNorth, kSouth}) {
            const std::int32_t corner = adjacency.diagonal(i, x_side, z_side);
            if (corner == Adjacency::kNone)
                continue;
            visit(corner, kDiagonal);
            // A knight's move passes between two cells: both must be water.
            if (adjacency.neighbour(i, x_side) != Adjacency::kNone)
                if (const std::int32_t n = adjacency.neighbour(corner, x_side);
                    n != Adjacency::kNone)
                    visit(n, kKnight);
            if (adjacency.neighbour(i, z_side) != Adjacency::kNone)
                if (const std::int32_t n = adjacency.neighbour(corner, z_side);
                    n != Adjacency::kNone)
                    visit(n, kKnight);
        }
}

std::vector<std::int32_t> distances(const Adjacency& adjacency, std::int32_t start) {
    constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
    std::vector<std::int32_t> d(to_index(adjacency.size()), kFar);
    std::array<std::vector<std::int32_t>, kKnight + 1> buckets;  // by distance, modulo their number
    d[to_index(start)] = 0;
    buckets[0].push_back(start);
    std::size_t waiting = 1;
    for (std::int32_t now = 0; waiting > 0; ++now) {
        auto& bucket = buckets[to_index(now % (kKnight + 1))];
        for (const std::int32_t i : bucket) {
            --waiting;
            if (d[to_index(i)] != now)
                continue;  // has already been reached by a shorter path
            visit_far(adjacency, i, [&](std::int32_t n, std::int32_t step) {
                if (now + step >= d[to_index(n)])
                    return;
                d[to_index(n)] = now + step;
                buckets[to_index((now + step) % (kKnight + 1))].push_back(n);
                ++waiting;
            });
        }
        bucket.clear();
    }
    return d;
}

// Labels the connected parts of rings, with corners as connections, since a ring is thin and would
// otherwise fall apart.
std::vector<std::int32_t> ring_parts(const Adjacency& adjacency,
                                     const std::vector<std::int32_t>& ring, std::int32_t& count) {
    std::vector<std::int32_t> part(ring.size(), Adjacency::kNone), stack;
    count = 0;
    for (std::int32_t start = 0; start < adjacency.size(); ++start) {
        if (part[to_index(start)] != Adjacency::kNone)
            continue;
        part[to_index(start)] = count;
        stack.push_back(start);
        while (!stack.empty()) {
            const std::int32_t i = stack.back();
            stack.pop_back();
            const auto take = [&](std::int32_t n) {
                if (n == Adjacency::kNone || part[to_index(n)] != Adjacency::kNone ||
                    ring[to_index(n)] != ring[to_index(i)])
                    return;
                part[to_index(n)] = count;
                stack.push_back(n);
            };
            for (const std::int32_t n : adjacency.around(i))
                take(n);
            for (const Side x_side : {kWest, kEast})
                for (const Side z_side : {kNorth, kSouth})
                    take(adjacency.diagonal(i, x_side, z_side));
        }
        ++count;
    }
    return part;
}

void link(RiverSections& out, const Adjacency& adjacency) {
    std::vector<std::uint64_t> pairs;
    const auto add = [&](std::int32_t a, std::int32_t b) {
        const std::uint64_t pair =
            static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
        if (pairs.size() < 2 ||
            (pairs[pairs.size() - 1] != pair && pairs[pairs.size() - 2] != pair))
            pairs.push_back(pair);
    };
    for (std::int32_t i = 0; i < adjacency.size(); ++i)
        for (const std::int32_t n : adjacency.around(i))
            if (n != Adjacency::kNone && out.section_of[to_index(n)] != out.section_of[to_index(i)])
                add(out.section_of[to_index(i)], out.section_of[to_index(n)]);
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    out.begin.assign(out.cells.size() + 1, 0);
    out.neighbours.clear();
    for (const std::uint64_t pair : pairs) {
        ++out.begin[static_cast<std::size_t>(pair >> 32) + 1];
        out.neighbours.push_back(static_cast<std::int32_t>(pair & 0xffffffff));
    }
    for (std::size_t s = 0; s < out.cells.size(); ++s)
        out.begin[s + 1] += out.begin[s];
}

// Finds chains of at most kNotch sections from a dead end to a section with three or more
// neighbours.
// @return the section that each one is merged into (itself: it stays)
std::vector<std::int32_t> notches(const RiverSections& s) {
    std::vector<std::int32_t> to(to_index(s.size())), degree(to_index(s.size()));
    for (std::int32_t i = 0; i < s.size(); ++i) {
        to[to_index(i)] = i;
        degree[to_index(i)] =
            static_cast<std::int32_t>(s.begin[to_index(i) + 1] - s.begin[to_index(i)]);
    }
    for (std::int32_t leaf = 0; leaf < s.size(); ++leaf) {
        if (degree[to_index(leaf)] != 1 || to[to_index(leaf)] != leaf)
            continue;
        std::array<std::int32_t, kNotch> chain{};
        int length = 0;
        std::int32_t now = leaf;
        std::int32_t before = Adjacency::kNone;
        while (length < kNotch && degree[to_index(now)] <= 2) {
            chain[to_index(length++)] = now;
            std::int32_t next = Adjacency::kNone;
            s.each_neighbour(now, [&](std::int32_t n) {
                if (n != before && to[to_index(n)] == n)
                    next = n;
            });
            before = now;
            now = next;
            if (now == Adjacency::kNone)
                break;
        }
        if (now == Adjacency::kNone || degree[to_index(now)] <= 2)
            continue;
        for (int k = 0; k < length; ++k)
            to[to_index(chain[to_index(k)])] = now;
        --degree[to_index(now)];
    }
    return to;
}

bool merge_notches(RiverSections& s, const Adjacency& adjacency) {
    const std::vector<std::int32_t> to = notches(s);
    std::vector<std::int32_t> number(to_index(s.size()), Adjacency::kNone);
    std::int32_t count = 0;
    for (std::int32_t i = 0; i < s.size(); ++i)
        if (to[to_index(i)] == i)
            number[to_index(i)] = count++;
    if (count == s.size())
        return false;
    std::vector<double> along(to_index(count));
    std::vector<std::uint32_t> cells(to_index(count));
    for (std::int32_t i = 0; i < s.size(); ++i) {
        std::int32_t target = i;
        while (to[to_index(target)] != target)
            target = to[to_index(target)];
        if (target == i)
            along[to_index(number[to_index(i)])] = s.along_m[to_index(i)];
        else
            number[to_index(i)] = number[to_index(target)];
        cells[to_index(number[to_index(i)])] += s.cells[to_index(i)];
    }
    for (std::int32_t& section : s.section_of)
        section = number[to_index(section)];
    s.along_m = std::move(along);
    s.cells = std::move(cells);
    link(s, adjacency);
    return true;
}

}  // namespace

RiverSections make_sections(const Adjacency& adjacency, double cell_m) {
    std::vector<std::int32_t> ring = distances(adjacency, find_end(adjacency));
    for (std::int32_t& r : ring)
        r /= kRing;
    RiverSections out;
    out.length_m = cell_m * kRing / kStep;
    std::int32_t count = 0;
    out.section_of = ring_parts(adjacency, ring, count);
    out.along_m.resize(to_index(count));
    out.cells.resize(to_index(count));
    for (std::size_t i = 0; i < ring.size(); ++i) {
        out.along_m[to_index(out.section_of[i])] = ring[i] * out.length_m;
        ++out.cells[to_index(out.section_of[i])];
    }
    link(out, adjacency);
    for (int round = 0; round < kNotchRounds && merge_notches(out, adjacency); ++round) {
    }
    return out;
}

std::vector<SectionSample> section_samples(const RiverSections& sections,
                                           const std::vector<LevelSample>& samples, float reference,
                                           double voxel_m) {
    // Counting sort by section, then a weighted median in each.
    std::vector<std::size_t> begin(to_index(sections.size()) + 1);
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (samples[i].weight > 0)
            ++begin[to_index(sections.section_of[i]) + 1];
    for (std::size_t s = 1; s < begin.size(); ++s)
        begin[s] += begin[s - 1];
    std::vector<WeightedLevel> levels(begin.back());
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t i = 0; i < samples.size(); ++i)
        if (samples[i].weight > 0)
            levels[next[to_index(sections.section_of[i])]++] = {samples[i].level,
                                                                samples[i].weight};
    std::vector<SectionSample> out(to_index(sections.size()));
    for (std::size_t s = 0; s < out.size(); ++s) {
        std::sort(levels.begin() + static_cast<std::ptrdiff_t>(begin[s]),
                  levels.begin() + static_cast<std::ptrdiff_t>(begin[s + 1]));
        std::uint64_t sum = 0;
        std::uint64_t below = 0;
        for (std::size_t k = begin[s]; k < begin[s + 1]; ++k)
            sum += levels[k].weight;
        for (std::size_t k = begin[s]; k < begin[s + 1]; ++k)
            if ((below += levels[k].weight) * 2 >= sum) {
                out[s] = {(static_cast<double>(levels[k].level) - static_cast<double>(reference)) *
                              voxel_m,
                          static_cast<double>(sum)};
                break;
            }
    }
    return out;
}

}  // namespace terravox::water
