#include "voxelserver/make/voxelize/columns/columns.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::voxelize {
namespace {

/// The groups into which points of a column are sorted: the last two roles of the class table are
/// objects like any other.
enum Group : std::uint8_t {
    kGroundGroup,
    kWaterGroup,
    kRoofGroup,
    kDeckGroup,
    kObjectGroup,
    kGroupCount
};

Group choose_group(Role role) noexcept {
    switch (role) {
        case Role::kGround: return kGroundGroup;
        case Role::kWater: return kWaterGroup;
        case Role::kBuilding: return kRoofGroup;
        case Role::kBridge: return kDeckGroup;
        default: return kObjectGroup;
    }
}

/// x and z are fixed point within the patch; without has_colour, colour.r is the brightness.
struct Seen : store::VoxelPoint {
    bool has_colour = false;
};

/// What points have in common.
struct Common {
    bool one_class = true;
    std::uint32_t r = 0;
    std::uint32_t g = 0;
    std::uint32_t b = 0;
    std::uint32_t coloured = 0;  ///< points that have a colour
    std::uint32_t brightness = 0;
    std::uint32_t lit = 0;  ///< points of which the brightness is known

    explicit Common(std::span<const Seen> points) noexcept {
        for (const Seen& s : points) {
            one_class = one_class && s.source_class == points[0].source_class;
            if (s.has_colour) {
                r += s.colour.r;
                g += s.colour.g;
                b += s.colour.b;
                ++coloured;
            } else {
                brightness += s.colour.r;
                lit += s.colour.r > 0 ? 1 : 0;
            }
        }
    }
    template <class Target>
    void put_colour(Target& target) const noexcept {
        target.has_colour = coloured > 0;
        if (coloured > 0)
            target.colour = {mean(r, coloured), mean(g, coloured), mean(b, coloured)};
    }
    [[nodiscard]] std::uint8_t mean_brightness() const noexcept {
        return lit == 0 ? 0 : mean(brightness, lit);
    }

private:
    static std::uint8_t mean(std::uint32_t sum, std::uint32_t count) noexcept {
        return static_cast<std::uint8_t>((sum + count / 2) / count);
    }
};

// The class of most points; the lower code wins a tie, so that order cannot matter.
std::uint8_t commonest_class(std::span<const Seen> points, const Common& common) {
    const std::uint8_t first = points[0].source_class;
    if (common.one_class)
        return first;
    std::array<std::uint32_t, 256> votes{};
    std::uint8_t best = first;
    for (const Seen& s : points) {
        const auto n = ++votes[s.source_class];
        if (n > votes[best] || (n == votes[best] && s.source_class < best))
            best = s.source_class;
    }
    return best;
}

/// @param points by rising y
/// @param out nothing seen before
void put_surface(std::span<const Seen> points, float height, Surface& out) {
    const Common common(points);
    out.height = height;
    out.source_class = commonest_class(points, common);
    common.put_colour(out);
    out.brightness = common.mean_brightness();
}

std::uint16_t saturated(std::size_t count) noexcept {
    return static_cast<std::uint16_t>(std::min<std::size_t>(count, UINT16_MAX));
}

void sum_up_objects(std::span<const Seen> points, std::vector<ObjectVoxel>& out) {
    for (std::size_t begin = 0; begin < points.size();) {
        const std::int32_t y = points[begin].y >> store::VoxelPoint::kHeightBits;
        std::size_t end = begin + 1;
        while (end < points.size() && points[end].y >> store::VoxelPoint::kHeightBits == y)
            ++end;
        // In its place: a copy of what has just been written in parts waits for all of it.
        ObjectVoxel& voxel = out.emplace_back();
        voxel.y = y;
        const auto group = points.subspan(begin, end - begin);
        const Common common(group);
        voxel.source_class = commonest_class(group, common);
        voxel.fraction =
            static_cast<std::uint8_t>(group.back().y >> (store::VoxelPoint::kHeightBits - 8));
        common.put_colour(voxel);
        begin = end;
    }
}

/// Sums for one water cell.
struct CellSums {
    double ground = 0;
    double water = 0;
    std::uint32_t ground_points = 0;
    std::uint32_t water_points = 0;
    std::uint32_t other_points = 0;
};

/// Sorts the points of one column into their groups, each by rising height.
class ColumnSorter {
public:
    explicit ColumnSorter(const ClassTable& classes) {
        for (std::size_t i = 0; i < 256; ++i)
            m_group[i] = choose_group(classes.meaning[i].role);
    }
    void clear() noexcept {
        for (auto& g : m_points)
            g.clear();
    }
    void add(const store::VoxelPoint& p, bool has_colour) {
        m_points[m_group[p.source_class]].push_back({p, has_colour});
    }
    // For points of several squares: those of one are sorted already. A stable order among equals
    // is not needed: they only contribute to sums.
    void sort() {
        for (auto& g : m_points)
            std::sort(g.begin(), g.end(), [](const Seen& a, const Seen& b) { return a.y < b.y; });
    }
    [[nodiscard]] std::span<const Seen> operator[](Group g) const noexcept { return m_points[g]; }

private:
    std::array<Group, 256> m_group{};
    std::array<std::vector<Seen>, kGroupCount> m_points;
};

float median(std::span<const Seen> points) noexcept {
    return points[points.size() / 2].height();
}

/// For points projected on an axis: the second from one end where there are enough, so that a
/// single stray point has no effect.
float nearly_lowest(std::vector<float>& along) {
    constexpr std::size_t kEnough = 4;
    const auto nth = along.begin() + (along.size() >= kEnough ? 1 : 0);
    std::nth_element(along.begin(), nth, along.end());
    return *nth;
}

// Where the edge of a roof cuts through a column, its ground points lie next to the building
// points, and a line separates them. Beneath a canopy no line does.
bool over(std::span<const Seen> roof, std::span<const Seen> ground) {
    constexpr float kOne = 1 << store::VoxelPoint::kPlanBits,
                    kBlur = 0.25f;  // voxels: possible error of the points' own places
    const auto centre = [](std::span<const Seen> points) {
        std::uint64_t x = 0, z = 0;  // exact, so that order cannot matter
        for (const Seen& s : points) {
            x += s.x;
            z += s.z;
        }
        const auto n = static_cast<float>(points.size());
        return std::pair{static_cast<float>(x) / n, static_cast<float>(z) / n};
    };
    const auto [rx, rz] = centre(roof);
    const auto [gx, gz] = centre(ground);
    const float dx = rx - gx;
    const float dz = rz - gz;
    const float length = std::sqrt(dx * dx + dz * dz);
    if (length < kBlur * kOne / 2)
        return roof.size() > 1;  // in the same place
    std::vector<float> roof_along;
    std::vector<float> ground_along;
    for (const Seen& s : roof)
        roof_along.push_back((s.x * dx + s.z * dz) / length);
    for (const Seen& s : ground)
        ground_along.push_back(-(s.x * dx + s.z * dz) / length);
    return -nearly_lowest(ground_along) - nearly_lowest(roof_along) > kBlur * kOne;
}

void sum_up(const ColumnSorter& points, Column& column, std::vector<ObjectVoxel>& objects,
            CellSums& cell) {
    if (const auto g = points[kGroundGroup]; !g.empty()) {
        put_surface(g, median(g), column.ground);
        column.ground_points = saturated(g.size());
        cell.ground_points += static_cast<std::uint32_t>(g.size());
        for (const Seen& s : g)
            cell.ground += s.height();
    }
    if (const auto g = points[kWaterGroup]; !g.empty()) {
        put_surface(g, median(g), column.water);
        column.water_points = saturated(g.size());
        cell.water_points += static_cast<std::uint32_t>(g.size());
        for (const Seen& s : g)
            cell.water += s.height();
    }
    if (const auto g = points[kRoofGroup]; !g.empty()) {
        put_surface(g, g.back().height(), column.roof);
        column.roof_points = saturated(g.size());
        column.roof_low = g.front().height();
        cell.other_points += static_cast<std::uint32_t>(g.size());
        column.roof_over_ground = column.ground.seen() &&
                                  column.roof_low - column.ground.height > 1 &&
                                  over(g, points[kGroundGroup]);
    }
    if (const auto g = points[kDeckGroup]; !g.empty()) {
        put_surface(g, median(g), column.deck);
        column.deck_points = saturated(g.size());
    }
    if (const auto g = points[kObjectGroup]; !g.empty()) {
        sum_up_objects(g, objects);
        cell.other_points += static_cast<std::uint32_t>(g.size());
    }
}

void finish_cells(std::span<const CellSums> sums, water::CellPatch& cells) {
    for (std::size_t i = 0; i < sums.size(); ++i) {
        water::WaterCell& cell = cells.cells[i];
        cell.water_points = saturated(sums[i].water_points);
        cell.ground_points = saturated(sums[i].ground_points);
        cell.other_points = saturated(sums[i].other_points);
        if (sums[i].water_points > 0)
            cell.water = static_cast<float>(sums[i].water / sums[i].water_points);
        if (sums[i].ground_points > 0)
            cell.ground = static_cast<float>(sums[i].ground / sums[i].ground_points);
    }
}

}  // namespace

std::shared_ptr<PatchColumns> init_columns(std::span<const PatchPoints> sources,
                                           const ClassTable& classes, int cell_voxels) {
    auto patch = std::make_shared<PatchColumns>();
    patch->cells.side = grid::kPatchSize / cell_voxels;
    patch->cells.cells.resize(static_cast<std::size_t>(patch->cells.side) *
                              static_cast<std::size_t>(patch->cells.side));
    patch->ground_height.fill(kNoHeight);
    std::vector<CellSums> sums(patch->cells.cells.size());
    ColumnSorter sorter(classes);
    std::vector<std::size_t> next(sources.size());
    float lowest = std::numeric_limits<float>::max();
    for (int i = 0; i < grid::kPatchColumns; ++i) {
        Column& column = patch->columns[static_cast<std::size_t>(i)];
        patch->objects_begin[static_cast<std::size_t>(i)] =
            static_cast<std::uint32_t>(patch->objects.size());
        sorter.clear();
        int used = 0;
        for (std::size_t s = 0; s < sources.size(); ++s) {
            const auto left = sources[s].points.subspan(next[s]);
            std::size_t count = 0;
            for (; count < left.size() && left[count].column() == i; ++count)
                sorter.add(left[count], sources[s].has_colour);
            if (count == 0)
                continue;
            next[s] += count;
            lowest = std::min(lowest, left.front().height());  // points of a column ascend
            ++used;
        }
        if (used == 0)
            continue;
        patch->any = true;
        const int x = i % grid::kPatchSize;
        const int z = i / grid::kPatchSize;
        patch->occupied[static_cast<std::size_t>(z)] |= std::uint64_t{1} << x;
        if (used > 1)
            sorter.sort();
        sum_up(
            sorter, column, patch->objects,
            sums[static_cast<std::size_t>(z / cell_voxels * patch->cells.side + x / cell_voxels)]);
        if (column.built_upon())
            patch->built[static_cast<std::size_t>(z)] |= std::uint64_t{1} << x;
        if (column.ground.seen())
            patch->ground[static_cast<std::size_t>(z)] |= std::uint64_t{1} << x;
        if (column.water.seen() && column.water_points >= column.ground_points)
            patch->wet[static_cast<std::size_t>(z)] |= std::uint64_t{1} << x;
        patch->ground_height[static_cast<std::size_t>(i)] = column.ground.height;
        patch->any_roof = patch->any_roof || column.roof.seen();
        patch->any_deck = patch->any_deck || column.deck.seen();
    }
    patch->objects_begin[grid::kPatchColumns] = static_cast<std::uint32_t>(patch->objects.size());
    patch->any_objects = !patch->objects.empty();
    if (patch->any)
        patch->lowest = lowest;
    finish_cells(sums, patch->cells);
    patch->objects.shrink_to_fit();
    return patch;
}

}  // namespace terravox::voxelize
