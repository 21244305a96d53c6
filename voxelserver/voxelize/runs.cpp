#include "voxelserver/voxelize/runs.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::voxelize {

namespace {

using voxel::Material;
using voxel::VoxelAttr;

constexpr double kTierLow_m = 1.0, kTierMedium_m = 3.0;  // tops of low and medium vegetation where the source has no tiers
constexpr double kClutter_m = 0.5;    // unclassified things lower than this are the ground's roughness
constexpr double kWaterDepth_m = 2.5;  // a bed that a clear lake shows near its shore; deepening by distance is a later step
constexpr double kSoil_m = 2.5;
constexpr double kCliff_m = 3.0;  // no soil holds where the ground drops by more to the next column
constexpr double kSteepRoof_m = 3.0;  // drop between neighbouring columns of one roof
constexpr double kDeckThickness_m = 1.0;
constexpr double kNearGround_m = 2.5;  // higher things must hang on something: birds and stray returns do not
constexpr double kCanopyGap_m = 3.0;  // foliage between two returns of one crown

std::int32_t floor_y(float height) { return static_cast<std::int32_t>(std::floor(height)); }
std::int32_t in_voxels(double metres, double voxel_m) { return std::max(1, static_cast<std::int32_t>(std::lround(metres / voxel_m))); }

VoxelAttr attr_of(Material material, const Surface& s) {
    VoxelAttr attr;
    attr.material = material;
    attr.source_class = s.source_class;
    if (s.has_colour) attr.colour = s.colour, attr.flags = VoxelAttr::kHasColour;
    return attr;
}

}  // namespace

class RunsBuilder {
public:
    explicit RunsBuilder(const RunsInput& input) : m_in(input) {}

    PatchRuns build() {
        PatchRuns out;
        constexpr int kSide = PatchRuns::kSide;
        out.m_begin.assign(kSide * kSide + 1, 0);
        bool any = false;
        std::size_t i = 0;
        for (int z = -1; z <= kPatchSize; ++z)
            for (int x = -1; x <= kPatchSize; ++x, ++i) {
                m_runs.clear();
                if (m_in.surveyed.at(x, z) != 0) column(x, z);
                out.m_runs.insert(out.m_runs.end(), m_runs.begin(), m_runs.end());
                out.m_begin[i + 1] = static_cast<std::uint32_t>(out.m_runs.size());
                const bool inner = x >= 0 && z >= 0 && x < kPatchSize && z < kPatchSize;
                if (!inner || m_runs.empty()) continue;
                out.m_min_y = any ? std::min(out.m_min_y, m_runs.front().y0) : m_runs.front().y0;
                out.m_max_y = any ? std::max(out.m_max_y, m_runs.back().y1) : m_runs.back().y1;
                any = true;
            }
        return out;
    }

private:
    void column(int x, int z) {
        const Column& col = m_in.window.column(x, z);
        const Surface& roof = m_in.roofs.at(x, z);
        float ground = m_in.ground.at(x, z);
        const float water = water_level(col, roof, x, z);
        if (!std::isnan(water)) ground = std::min(ground, water);
        std::int32_t top = floor_y(ground);
        if (!std::isnan(water)) {
            const std::int32_t surface = floor_y(water), bed = surface - in_voxels(kWaterDepth_m, m_in.voxel_m);
            terrain(bed, VoxelAttr{Material::kSand, 0, 0, 0, {}, 0}, 0);
            push(bed + 1, surface + 1, attr_of(Material::kWater, col.water));
            top = surface;
        } else {
            terrain(top, ground_attr(col), soil(x, z));
        }
        if (roof.seen()) building(roof, top, x, z);
        if (col.deck.seen()) {
            const std::int32_t y = floor_y(col.deck.height);
            push(std::max(y + 1 - in_voxels(kDeckThickness_m, m_in.voxel_m), top + 1), y + 1, attr_of(meaning(col.deck.source_class).material, col.deck));
        }
        objects(col, x, z, top, roof.seen());
    }

    // A column is water when its cell belongs to a water body and nothing solid was seen in it.
    [[nodiscard]] float water_level(const Column& col, const Surface& roof, int x, int z) const {
        if (roof.seen()) return kNoHeight;
        if (col.water.seen()) {
            const float level = m_in.terrain.water_near(m_in.x0 + x, m_in.z0 + z);
            return std::isnan(level) ? col.water.height : level;
        }
        return col.ground.seen() ? kNoHeight : m_in.terrain.water(m_in.x0 + x, m_in.z0 + z);
    }

    [[nodiscard]] const ClassMeaning& meaning(std::uint8_t source_class) const { return m_in.classes.meaning[source_class]; }

    [[nodiscard]] VoxelAttr ground_attr(const Column& col) const {
        if (col.ground.seen()) return attr_of(meaning(col.ground.source_class).material, col.ground);
        return VoxelAttr{Material::kGround, 0, 0, 0, {}, 0};
    }

    void terrain(std::int32_t top, const VoxelAttr& attr, std::int16_t soil_voxels) {
        push(std::min(m_in.floor_y, top), top + 1, attr);
        m_runs.back().terrain = true;
        m_runs.back().soil = soil_voxels;
    }

    [[nodiscard]] std::int16_t soil(int x, int z) const {
        const float here = m_in.ground.at(x, z);
        float drop = 0;
        for (const float there : {m_in.ground.at(x - 1, z), m_in.ground.at(x + 1, z), m_in.ground.at(x, z - 1), m_in.ground.at(x, z + 1)})
            drop = std::max(drop, here - there);
        return drop * m_in.voxel_m > kCliff_m ? std::int16_t{0} : static_cast<std::int16_t>(in_voxels(kSoil_m, m_in.voxel_m));
    }

    void building(const Surface& roof, std::int32_t ground_top, int x, int z) {
        const std::int32_t roof_y = floor_y(roof.height);
        VoxelAttr attr = attr_of(meaning(roof.source_class).material, roof);
        if (roof_y <= ground_top) {  // a roof no higher than the ground: a garage, a terrace
            m_runs.back().attr = attr;
            return;
        }
        VoxelAttr wall = attr;
        wall.material = Material::kWall;
        wall.flags = 0, wall.colour = {};  // seen from above, a point's colour is the roof's, not the wall's
        const std::int32_t skin = roof_bottom(roof_y, x, z);
        push(ground_top + 1, skin, wall);
        push(std::max(skin, ground_top + 1), roof_y + 1, attr);
    }

    // A steep roof shows its flank: it is roof down to the next column's roof. A greater drop is a wall between two parts.
    [[nodiscard]] std::int32_t roof_bottom(std::int32_t roof_y, int x, int z) const {
        const std::int32_t steepest = in_voxels(kSteepRoof_m, m_in.voxel_m);
        std::int32_t bottom = roof_y;
        for (const Surface* next : {&m_in.roofs.at(x - 1, z), &m_in.roofs.at(x + 1, z), &m_in.roofs.at(x, z - 1), &m_in.roofs.at(x, z + 1)}) {
            if (!next->seen()) continue;
            const std::int32_t y = floor_y(next->height);
            if (roof_y - y <= steepest) bottom = std::min(bottom, y + 1);
        }
        return bottom;
    }

    void objects(const Column& col, int x, int z, std::int32_t top, bool roofed) {
        const PatchColumns& patch = m_in.window.patch_at(x, z);
        const std::int32_t gap = in_voxels(kCanopyGap_m, m_in.voxel_m);
        for (std::uint32_t i = col.objects_begin; i < col.objects_end; ++i) {
            const ObjectVoxel& o = patch.objects[i];
            const ClassMeaning& m = meaning(o.source_class);
            const double height_m = (o.y - top) * m_in.voxel_m;
            if (o.y < m_runs.back().y1) {
                // In or below what is there already. Plants on the ground colour it green.
                if (m.role == Role::kVegetation && o.y == top && !roofed && m_runs.back().terrain && m_runs.back().attr.material == Material::kGround)
                    m_runs.back().attr.material = Material::kGrass;
                continue;
            }
            if (m.role == Role::kSurface && height_m < kClutter_m) continue;
            if (height_m > kNearGround_m && isolated(x, z, o.y)) continue;
            VoxelAttr attr;
            attr.material = m.tiers ? tier(height_m) : m.material;
            attr.source_class = o.source_class;
            if (o.has_colour) attr.colour = o.colour, attr.flags = VoxelAttr::kHasColour;
            const bool plant = m.role == Role::kVegetation || m.role == Role::kSurface;
            Run& last = m_runs.back();
            const bool on_crown = plant && !last.terrain && last.y1 < o.y && last.y1 + gap >= o.y && last.attr.source_class == o.source_class;
            push(on_crown ? last.y1 : o.y, o.y + 1, attr);
        }
    }

    // Nothing else within two voxels sideways and three up and down.
    [[nodiscard]] bool isolated(int x, int z, std::int32_t y) const {
        constexpr int kAround = 2, kAbove = 3;
        for (int dz = -kAround; dz <= kAround; ++dz)
            for (int dx = -kAround; dx <= kAround; ++dx) {
                const PatchColumns& patch = m_in.window.patch_at(x + dx, z + dz);
                const Column& col = m_in.window.column(x + dx, z + dz);
                for (const Surface* s : {&col.roof, &col.deck, &col.ground})
                    if (s->seen() && std::abs(floor_y(s->height) - y) <= kAbove) return false;
                for (std::uint32_t i = col.objects_begin; i < col.objects_end; ++i) {
                    const std::int32_t dy = std::abs(patch.objects[i].y - y);
                    if (dy <= kAbove && (dx != 0 || dz != 0 || dy != 0)) return false;
                }
            }
        return true;
    }

    [[nodiscard]] static Material tier(double height_m) {
        return height_m < kTierLow_m ? Material::kLowVegetation : height_m < kTierMedium_m ? Material::kMediumVegetation : Material::kHighVegetation;
    }

    void push(std::int32_t y0, std::int32_t y1, const VoxelAttr& attr) {
        if (!m_runs.empty()) y0 = std::max(y0, m_runs.back().y1);
        if (y0 < y1) m_runs.push_back({y0, y1, attr});
    }

    const RunsInput& m_in;
    std::vector<Run> m_runs;
};

PatchRuns make_runs(const RunsInput& input) { return RunsBuilder(input).build(); }

}  // namespace terravox::voxelize
