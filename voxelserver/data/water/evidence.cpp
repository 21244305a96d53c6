#include "voxelserver/data/water/evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace terravox::water {
namespace {

// Fewer cells with returns do not determine flatness; the shore is used instead.
constexpr std::size_t kMinWetLevels = 5;

bool water_seen(const WaterCell& c) noexcept {
    return c.water_points > 0 && std::isfinite(c.water);
}
bool ground_seen(const WaterCell& c) noexcept {
    return c.ground_points > 0 && std::isfinite(c.ground);
}

// Where a cell is water, its returns are those of the surface, whatever their class.
LevelSample surface(const WaterCell& c, bool wet) noexcept {
    if (water_seen(c))
        return {c.water, c.water_points};
    if (wet && ground_seen(c))
        return {c.ground, c.ground_points};
    return {};
}

class Judge {
public:
    Judge(const Candidates& candidates, const Evidence& evidence, double cell_m, double voxel_m)
        : m_candidates(candidates),
          m_evidence(evidence),
          m_cell_m2(cell_m * cell_m),
          m_voxel_m(voxel_m),
          m_adjacency(candidates.places()) {
        for (const CellPlace place : candidates.places())
            m_cells.push_back(candidates.find(place));
        m_water.assign(m_cells.size(), 0);
        m_chosen = m_water;
        m_wet = m_water;
    }

    std::vector<FoundBody> bodies() {
        if (m_evidence.by_photo)
            accept([](const WaterCell& c) { return is_wet(c); },
                   [&](const Members& m) { return wet_water(m); }, &m_wet);
        if (m_evidence.by_class || m_evidence.by_void)
            accept([](const WaterCell& c) { return is_open(c); },
                   [&](const Members& m) { return class_water(m) || void_water(m); }, nullptr);
        std::vector<FoundBody> out;
        for (Members& members : parts(m_water))
            out.push_back(body(std::move(members)));
        return out;
    }

private:
    using Members = std::vector<std::int32_t>;

    [[nodiscard]] const WaterCell& cell(std::int32_t i) const {
        return *m_cells[static_cast<std::size_t>(i)];
    }
    [[nodiscard]] double area_m2(const Members& m) const {
        return static_cast<double>(m.size()) * m_cell_m2;
    }

    [[nodiscard]] std::vector<Members> parts(const std::vector<char>& flag) const {
        std::int32_t count = 0;
        const std::vector<std::int32_t> part = m_adjacency.parts(flag, &count);
        std::vector<Members> out(static_cast<std::size_t>(count));
        for (std::size_t i = 0; i < part.size(); ++i)
            if (part[i] != Adjacency::kNone)
                out[static_cast<std::size_t>(part[i])].push_back(static_cast<std::int32_t>(i));
        return out;
    }

    // Each connected part of one kind of cells that passes the test is water.
    template <class Kind, class Test>
    void accept(const Kind& kind, const Test& test, std::vector<char>* note) {
        std::vector<char> flag(m_cells.size());
        for (std::size_t i = 0; i < flag.size(); ++i)
            flag[i] = kind(*m_cells[i]) ? 1 : 0;
        for (const Members& members : parts(flag)) {
            if (!test(members))
                continue;
            for (const std::int32_t i : members) {
                m_water[static_cast<std::size_t>(i)] = 1;
                if (note)
                    (*note)[static_cast<std::size_t>(i)] = 1;
            }
        }
    }

    [[nodiscard]] bool class_water(const Members& members) const {
        if (!m_evidence.by_class)
            return false;
        std::uint64_t returns = 0;
        for (const std::int32_t i : members)
            if (water_seen(cell(i)))
                returns += cell(i).water_points;
        return returns >= m_evidence.fewest_returns;
    }

    [[nodiscard]] bool wet_water(const Members& members) {
        if (area_m2(members) < m_evidence.min_wet_m2)
            return false;
        std::vector<float> levels;
        for (const std::int32_t i : members)
            if (const LevelSample s = surface(cell(i), true); s.weight > 0)
                levels.push_back(s.level);
        if (levels.size() < kMinWetLevels)
            return level_shore(members);
        const double spread =
            static_cast<double>(quantile(levels, 0.9)) - static_cast<double>(quantile(levels, 0.1));
        return spread * m_voxel_m < m_evidence.flat_wet_m;
    }

    [[nodiscard]] bool void_water(const Members& members) {
        if (!m_evidence.by_void)
            return false;
        if (mostly_in_water(members))
            return true;
        if (area_m2(members) < m_evidence.min_void_m2)
            return false;
        return thick(members) && level_shore(members);
    }

    // A gap in a lake seen on the photo: the glint of a wave neither looks wet nor gives returns.
    [[nodiscard]] bool mostly_in_water(const Members& members) const {
        std::size_t water = 0;
        std::size_t edges = 0;
        for (const std::int32_t i : members)
            for (const std::int32_t n : m_adjacency.around(i)) {
                if (n != Adjacency::kNone && is_open(cell(n)))
                    continue;
                ++edges;
                water += n != Adjacency::kNone && m_wet[static_cast<std::size_t>(n)] != 0 ? 1 : 0;
            }
        return 2 * water > edges;
    }

    // Whether it has enough cells with all eight neighbours inside. (All open neighbours of an open
    // cell are in its part.)
    [[nodiscard]] bool thick(const Members& members) const {
        std::size_t inner = 0;
        for (const std::int32_t i : members) {
            bool all = true;
            for (const std::int32_t n : m_adjacency.around(i))
                all = all && n != Adjacency::kNone && is_open(cell(n));
            for (const Side x_side : {kWest, kEast})
                for (const Side z_side : {kNorth, kSouth}) {
                    const std::int32_t n = m_adjacency.diagonal(i, x_side, z_side);
                    all = all && n != Adjacency::kNone && is_open(cell(n));
                }
            inner += all ? 1 : 0;
        }
        return static_cast<double>(inner) >=
               m_evidence.inner_share_of_void * static_cast<double>(members.size());
    }

    [[nodiscard]] Shore shore(const Members& members) {
        for (const std::int32_t i : members)
            m_chosen[static_cast<std::size_t>(i)] = 1;
        Shore out = find_shore(m_candidates, m_adjacency, members, m_chosen);
        for (const std::int32_t i : members)
            m_chosen[static_cast<std::size_t>(i)] = 0;
        return out;
    }

    [[nodiscard]] bool level_shore(const Members& members) {
        const Shore s = shore(members);
        return !s.at_survey_edge && is_level_shore(s, m_evidence, m_voxel_m);
    }

    [[nodiscard]] FoundBody body(Members members) {
        FoundBody out;
        for (const std::int32_t i : members) {
            out.body.places.push_back(m_candidates.places()[static_cast<std::size_t>(i)]);
            out.body.samples.push_back(surface(cell(i), m_wet[static_cast<std::size_t>(i)] != 0));
        }
        out.body.shore = shore(members).heights();
        out.members = std::move(members);
        return out;
    }

    const Candidates& m_candidates;
    const Evidence& m_evidence;
    double m_cell_m2;
    double m_voxel_m;
    Adjacency m_adjacency;
    std::vector<const WaterCell*> m_cells;
    std::vector<char> m_water;
    std::vector<char> m_chosen;
    std::vector<char> m_wet;
};

}  // namespace

bool is_open(const WaterCell& c) noexcept {
    if (!c.covered)
        return false;
    const std::uint32_t others = std::uint32_t{c.ground_points} + c.other_points;
    return others == 0 || (water_seen(c) && c.water_points > 2 * others);
}

bool is_wet(const WaterCell& c) noexcept {
    return c.covered && c.looks_wet &&
           c.other_points <= std::uint32_t{c.ground_points} + c.water_points;
}

bool is_candidate(const WaterCell& c, const Evidence& evidence) noexcept {
    return ((evidence.by_class || evidence.by_void) && is_open(c)) ||
           (evidence.by_photo && is_wet(c));
}

std::vector<FoundBody> judge(const Candidates& candidates, const Evidence& evidence, double cell_m,
                             double voxel_m) {
    return Judge(candidates, evidence, cell_m, voxel_m).bodies();
}

namespace {

constexpr double kSideLow = 0.2;  // quantile of the heights on a side that counts as its low shore
constexpr std::size_t kMinCells = 4;

// Levels of the low shore on the four sides of the middle, voxels; sides without a cell are
// omitted.
std::vector<float> low_sides(const Shore& shore) {
    double x = 0;
    double z = 0;
    for (const Shore::Cell& c : shore.ground) {
        x += c.place.x;
        z += c.place.z;
    }
    x /= static_cast<double>(shore.ground.size());
    z /= static_cast<double>(shore.ground.size());
    std::array<std::vector<float>, 4> sides;
    for (const Shore::Cell& c : shore.ground) {
        const double dx = c.place.x - x;
        const double dz = c.place.z - z;
        const int side =
            std::abs(dx) > std::abs(dz) ? (dx < 0 ? kWest : kEast) : (dz < 0 ? kNorth : kSouth);
        sides[static_cast<std::size_t>(side)].push_back(c.ground);
    }
    std::vector<float> out;
    for (auto& side : sides)
        if (!side.empty())
            out.push_back(quantile(side, kSideLow));
    return out;
}

}  // namespace

std::vector<float> Shore::heights() const {
    std::vector<float> out;
    for (const Cell& c : ground)
        out.push_back(c.ground);
    return out;
}

Shore find_shore(const Candidates& candidates, const Adjacency& adjacency,
                 const std::vector<std::int32_t>& members, const std::vector<char>& chosen) {
    constexpr std::array<CellPlace, 4> kSteps{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    std::vector<CellPlace> ring;
    for (const std::int32_t i : members)
        for (std::size_t side = 0; side < 4; ++side) {
            const std::int32_t n = adjacency.around(i)[side];
            if (n != Adjacency::kNone && chosen[static_cast<std::size_t>(n)] != 0)
                continue;
            const CellPlace here = candidates.places()[static_cast<std::size_t>(i)];
            ring.push_back({here.x + kSteps[side].x, here.z + kSteps[side].z});
        }
    std::sort(ring.begin(), ring.end(),
              [](CellPlace a, CellPlace b) { return a.z != b.z ? a.z < b.z : a.x < b.x; });
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    Shore out;
    for (const CellPlace place : ring) {
        const WaterCell* cell = candidates.find(place);
        if (!cell)
            continue;
        if (!cell->covered)
            out.at_survey_edge = true;
        else if (cell->ground_points > 0 && std::isfinite(cell->ground))
            out.ground.push_back({place, cell->ground});
        else
            ++out.other;
    }
    return out;
}

bool is_level_shore(const Shore& shore, const Evidence& evidence, double voxel_m) {
    const std::size_t count = shore.ground.size();
    if (count < kMinCells ||
        static_cast<double>(count) <
            evidence.ground_share_of_shore * static_cast<double>(count + shore.other))
        return false;
    std::vector<float> heights = shore.heights();
    const double low_half =
        static_cast<double>(quantile(heights, 0.45)) - static_cast<double>(quantile(heights, 0.05));
    if (!(low_half * voxel_m < evidence.flat_shore_m))
        return false;
    const std::vector<float> sides = low_sides(shore);
    const auto [low, high] = std::minmax_element(sides.begin(), sides.end());
    return (static_cast<double>(*high) - static_cast<double>(*low)) * voxel_m <
           evidence.flat_shore_m;
}

}  // namespace terravox::water
