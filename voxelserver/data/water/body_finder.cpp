#include "voxelserver/data/water/body_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>

#include "common/util/error.hpp"
#include "voxelserver/data/water/body_levels.hpp"

namespace terravox::water {

std::shared_ptr<const CellPatch> checked_cells(CellSource& source, PatchIndex patch, int side) {
    auto cells = source.cells(patch.x, patch.z);
    if (!cells || cells->side != side ||
        cells->cells.size() != static_cast<std::size_t>(side) * static_cast<std::size_t>(side))
        throw util::Error("find water: patch {}, {} has {} cells; expected {} x {}", patch.x,
                          patch.z, cells ? std::to_string(cells->cells.size()) : "no", side, side);
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

namespace {

constexpr std::size_t kSmallPatches = 9;  // a body around one corner, and its neighbours
constexpr std::size_t kMinPatches = 16;
constexpr std::size_t kRecordBytes = 200;  // memory of a cached patch, apart from its cells
constexpr std::uint16_t kUnexplored = 0;
static_assert(64 * 64 / 2 < UINT16_MAX, "parts of a patch that touch nowhere must have numbers");

const WaterOptions& checked(const WaterOptions& o) {
    const auto fail = [](const std::string& what) { throw util::Error("find water: " + what); };
    if (o.cell_voxels < 1 || 64 % o.cell_voxels != 0)
        fail("cells of " + std::to_string(o.cell_voxels) + " voxels; allowed: a divisor of 64");
    if (!(o.voxel_m > 0) || !std::isfinite(o.voxel_m))
        fail("voxels of " + std::to_string(o.voxel_m) + " m; allowed: above 0");
    if (o.max_body_patches < kMinPatches)
        fail("bodies of at most " + std::to_string(o.max_body_patches) +
             " patches; allowed: " + std::to_string(kMinPatches) + " or more");
    return o;
}

// Edge of the squares along which very large bodies are divided, in patches: a square never exceeds
// the limit.
std::int32_t square_edge(std::size_t patches) {
    std::int32_t edge = 1;
    while (static_cast<std::size_t>(edge) * 2 * static_cast<std::size_t>(edge) * 2 <= patches &&
           edge < 1 << 12)
        edge *= 2;
    return edge;
}

}  // namespace

// Two locks. m_known guards the cache; it is held for look-ups and to store the result of an
// exploration. m_exploring is held while a large body is explored, so that two threads do not do
// the same long work; a thread that holds it may lock m_known, never the other way round.
class WaterBodies::Impl {
public:
    Impl(CellSource& source, const WaterOptions& options)
        : m_source(source), m_options(checked(options)), m_side(64 / options.cell_voxels) {}

    float level(CellPlace place, voxel::InputExtent* reach) {
        const Answer answer = answer_for(place);
        if (reach)
            reach->add(answer.reach);
        return answer.level;
    }

    [[nodiscard]] bool may_be_water(const WaterCell& cell) const noexcept {
        return is_candidate(cell, m_options.evidence);
    }

    std::size_t memory_bytes() const {
        const std::shared_lock lock(m_known);
        return m_bytes;
    }

private:
    struct Answer {
        float level = kNoLevel;
        voxel::InputExtent reach;
    };
    struct Record {
        std::vector<std::uint16_t>
            found_by;  // for each cell the exploration below that found it, from 1; kUnexplored
        std::vector<voxel::InputExtent> explorations;
        std::vector<float> level;  // empty until water is found
        [[nodiscard]] Answer answer(std::size_t cell) const {
            return {level.empty() ? kNoLevel : level[cell], explorations[found_by[cell] - 1u]};
        }
    };

    Answer answer_for(CellPlace place) {
        const PatchIndex patch = make_patch(place);
        if (const auto known = recall(place))
            return *known;
        const auto cells = checked_cells(m_source, patch, m_side);
        if (is_candidate(cells->cells[index_in(patch, place)], m_options.evidence))
            return explore(place);
        return {kNoLevel, {patch.x, patch.z, patch.x + 1, patch.z + 1}};
    }

    [[nodiscard]] PatchIndex make_patch(CellPlace place) const noexcept {
        return {floor_div(place.x, m_side), floor_div(place.z, m_side)};
    }
    [[nodiscard]] std::size_t index_in(PatchIndex patch, CellPlace place) const noexcept {
        return static_cast<std::size_t>((place.z - patch.z * m_side) * m_side + place.x -
                                        patch.x * m_side);
    }

    [[nodiscard]] std::optional<Answer> recall(CellPlace place) const {
        const PatchIndex patch = make_patch(place);
        const std::size_t i = index_in(patch, place);
        const std::shared_lock lock(m_known);
        const auto found = m_records.find(patch);
        if (found == m_records.end() || found->second.found_by[i] == kUnexplored)
            return std::nullopt;
        return found->second.answer(i);
    }

    Record& record(PatchIndex patch, std::size_t cells) {
        Record& r = m_records[patch];
        if (r.found_by.empty()) {
            r.found_by.assign(cells, kUnexplored);
            m_bytes += kRecordBytes + cells * sizeof(std::uint16_t);
        }
        return r;
    }

    // Should another thread find it again, it is the same exploration with the same reach.
    void note(PatchIndex patch, const CellFlags& cells, const voxel::InputExtent& reach) {
        Record& r = record(patch, cells.size());
        std::uint16_t number = kUnexplored;
        for (std::size_t k = 0; k < cells.size(); ++k) {
            if (cells[k] == 0 || r.found_by[k] != kUnexplored)
                continue;
            if (number == kUnexplored) {
                r.explorations.push_back(reach);
                m_bytes += sizeof reach;
                number = static_cast<std::uint16_t>(r.explorations.size());
            }
            r.found_by[k] = number;
        }
    }

    Answer explore(CellPlace start) {
        if (Exploration small(m_source, m_side, m_options.evidence);
            small.run(start, {kSmallPatches, {}, nullptr}))
            return remember(small, small.reach(), start);
        const std::lock_guard exploring(m_exploring);
        if (const auto known = recall(start))
            return *known;  // found meanwhile by another thread
        {
            Exploration whole(m_source, m_side, m_options.evidence);
            if (whole.run(start, {m_options.max_body_patches, {}, &m_oversize}))
                return remember(whole, whole.reach(), start);
            whole.for_each_patch(
                [&](PatchIndex p, const CellFlags& found) { merge(m_oversize[p], found); });
        }
        Exploration cut(m_source, m_side, m_options.evidence);
        const std::int32_t edge = square_edge(m_options.max_body_patches);
        if (!cut.run(start, {m_options.max_body_patches, edge, nullptr}))
            throw util::Error("find water: a square of {} patches exceeds {}", edge,
                              m_options.max_body_patches);
        return remember(cut, kAnywhere, start);
    }

    static void merge(CellFlags& into, const CellFlags& from) {
        if (into.empty())
            into.assign(from.size(), 0);
        for (std::size_t k = 0; k < from.size(); ++k)
            into[k] |= from[k];
    }

    // @return the level of one of its cells, computed here, since other threads may clear the cache
    // at any time
    Answer remember(Exploration& found, const voxel::InputExtent& reach, CellPlace place) {
        found.list();
        const double voxel_m = m_options.voxel_m;
        const double cell_m = m_options.cell_voxels * voxel_m;
        const std::vector<FoundBody> bodies = judge(found, m_options.evidence, cell_m, voxel_m);
        std::vector<std::vector<float>> levels;
        for (const FoundBody& b : bodies)
            levels.push_back(body_levels(b.body, {cell_m, voxel_m, m_options.equalize}));
        const std::lock_guard lock(m_known);
        if (m_bytes > m_options.memory_bytes) {
            m_records.clear();
            m_bytes = 0;
        }
        found.for_each_patch([&](PatchIndex p, const CellFlags& flags) { note(p, flags, reach); });
        for (std::size_t b = 0; b < bodies.size(); ++b)
            write(bodies[b].body.places, levels[b]);
        return m_records.find(make_patch(place))->second.answer(index_in(make_patch(place), place));
    }

    void write(const std::vector<CellPlace>& places, const std::vector<float>& levels) {
        PatchIndex patch;
        Record* r = nullptr;
        for (std::size_t k = 0; k < places.size(); ++k) {
            if (const PatchIndex p = make_patch(places[k]); !r || !(p == patch)) {
                patch = p;
                r = &m_records.find(p)->second;
            }
            if (r->level.empty()) {
                r->level.assign(r->found_by.size(), kNoLevel);
                m_bytes += r->level.size() * sizeof(float);
            }
            r->level[index_in(patch, places[k])] = levels[k];
        }
    }

    CellSource& m_source;
    const WaterOptions m_options;
    const int m_side;
    mutable std::shared_mutex m_known;
    std::unordered_map<PatchIndex, Record, PatchIndexHash> m_records;
    std::size_t m_bytes = 0;
    std::mutex m_exploring;
    FlaggedPatches m_oversize;  // guarded by m_exploring
};

WaterBodies::WaterBodies(CellSource& source, const WaterOptions& options)
    : m_impl(std::make_unique<Impl>(source, options)) {}
WaterBodies::~WaterBodies() = default;
float WaterBodies::level(std::int32_t cx, std::int32_t cz, voxel::InputExtent* reach) {
    return m_impl->level({cx, cz}, reach);
}
bool WaterBodies::may_be_water(const WaterCell& cell) const noexcept {
    return m_impl->may_be_water(cell);
}
std::size_t WaterBodies::memory_bytes() const {
    return m_impl->memory_bytes();
}

float WaterBodies::level_near(std::int32_t cx, std::int32_t cz, voxel::InputExtent* reach) {
    constexpr std::array<CellPlace, 9> kOrder{
        {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
    for (const CellPlace step : kOrder)
        if (const float found = level(cx + step.x, cz + step.z, reach); !std::isnan(found))
            return found;
    return kNoLevel;
}

}  // namespace terravox::water
