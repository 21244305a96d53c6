#include "voxelserver/voxelize/columns.hpp"

#include <algorithm>

namespace terravox::voxelize {
namespace {

constexpr int kBits = VoxelPoint::kFractionBits;
constexpr float kOne = 1 << kBits;
constexpr std::size_t kColumnCount = kPatchSize * kPatchSize;

struct Seen {
    std::int32_t y;
    std::uint8_t source_class;
    std::uint8_t role;
    bool has_colour;
    voxel::Rgb8 colour;
};

// Means of colour over the points that have one.
struct ColourMean {
    std::uint32_t r = 0, g = 0, b = 0, count = 0;
    void add(const Seen& s) noexcept {
        if (!s.has_colour) return;
        r += s.colour.r, g += s.colour.g, b += s.colour.b, ++count;
    }
    template <class Target> void put(Target& target) const noexcept {
        target.has_colour = count > 0;
        if (count == 0) return;
        const auto mean = [&](std::uint32_t sum) { return static_cast<std::uint8_t>((sum + count / 2) / count); };
        target.colour = {mean(r), mean(g), mean(b)};
    }
};

// The class that most points have; the lower code wins a tie, so that order cannot matter.
std::uint8_t commonest_class(std::span<const Seen> points) {
    std::array<std::uint16_t, 256> votes{};
    std::uint8_t best = points[0].source_class;
    for (const Seen& s : points) {
        const auto n = ++votes[s.source_class];
        if (n > votes[best] || (n == votes[best] && s.source_class < best)) best = s.source_class;
    }
    return best;
}

// `points` sorted by rising y.
Surface surface_of(std::span<const Seen> points, std::int32_t y) {
    Surface out;
    out.height = static_cast<float>(y) / kOne;
    out.source_class = commonest_class(points);
    ColourMean colour;
    for (const Seen& s : points) colour.add(s);
    colour.put(out);
    return out;
}

void sum_up_objects(std::span<const Seen> points, std::vector<ObjectVoxel>& out) {
    for (std::size_t begin = 0; begin < points.size();) {
        const std::int32_t y = points[begin].y >> kBits;
        std::size_t end = begin + 1;
        while (end < points.size() && points[end].y >> kBits == y) ++end;
        ObjectVoxel voxel;
        voxel.y = y;
        const auto group = points.subspan(begin, end - begin);
        voxel.source_class = commonest_class(group);
        ColourMean colour;
        for (const Seen& s : group) colour.add(s);
        colour.put(voxel);
        out.push_back(voxel);
        begin = end;
    }
}

}  // namespace

std::shared_ptr<const PatchColumns> init_columns(std::span<const PatchPoints> sources, const ClassTable& classes) {
    auto patch = std::make_shared<PatchColumns>();
    // Step 1: counting sort of all points by column.
    const auto column_of = [](const VoxelPoint& p) {
        return static_cast<std::size_t>((p.z >> kBits & (kPatchSize - 1)) * kPatchSize + (p.x >> kBits & (kPatchSize - 1)));
    };
    std::array<std::uint32_t, kColumnCount + 1> begin{};
    for (const PatchPoints& source : sources)
        for (const VoxelPoint& p : source.points) ++begin[column_of(p) + 1];
    for (std::size_t i = 0; i < kColumnCount; ++i) begin[i + 1] += begin[i];
    std::vector<Seen> seen(begin[kColumnCount]);
    patch->any = !seen.empty();
    auto next = begin;
    for (const PatchPoints& source : sources)
        for (const VoxelPoint& p : source.points) {
            Seen s{p.y, p.source_class, static_cast<std::uint8_t>(classes.meaning[p.source_class].role), source.has_colour, {}};
            const auto channel = [&](std::size_t c) { return static_cast<std::uint8_t>(std::min(p.rgb[c] >> source.colour_shift, 255)); };
            if (source.has_colour) s.colour = {channel(0), channel(1), channel(2)};
            seen[next[column_of(p)]++] = s;
        }

    // Step 2: each column, its points sorted by role and height.
    for (std::size_t i = 0; i < kColumnCount; ++i) {
        const std::span<Seen> points(seen.data() + begin[i], begin[i + 1] - begin[i]);
        Column& column = patch->columns[i];
        column.objects_begin = column.objects_end = static_cast<std::uint32_t>(patch->objects.size());
        if (points.empty()) continue;
        const auto group_of = [](const Seen& s) {
            const auto role = static_cast<Role>(s.role);
            return role == Role::kVegetation || role == Role::kSurface ? static_cast<int>(Role::kObject) : static_cast<int>(role);
        };
        std::sort(points.begin(), points.end(), [&](const Seen& a, const Seen& b) {
            const int ga = group_of(a), gb = group_of(b);
            return ga != gb ? ga < gb : a.y != b.y ? a.y < b.y : a.source_class < b.source_class;
        });
        for (std::size_t from = 0; from < points.size();) {
            std::size_t to = from + 1;
            while (to < points.size() && group_of(points[to]) == group_of(points[from])) ++to;
            const std::span<const Seen> group = points.subspan(from, to - from);
            const std::int32_t median = group[group.size() / 2].y;
            switch (static_cast<Role>(group_of(group[0]))) {
                case Role::kGround: column.ground = surface_of(group, median); break;
                case Role::kWater: column.water = surface_of(group, median); break;
                case Role::kBridge: column.deck = surface_of(group, median); break;
                case Role::kBuilding: column.roof = surface_of(group, group.back().y); break;
                default: sum_up_objects(group, patch->objects); break;
            }
            from = to;
        }
        column.objects_end = static_cast<std::uint32_t>(patch->objects.size());
    }
    patch->objects.shrink_to_fit();
    return patch;
}

}  // namespace terravox::voxelize
