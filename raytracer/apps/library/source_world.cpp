#include "raytracer/apps/library/source_world.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox {

VoxelSource::~VoxelSource() = default;
PointSource::~PointSource() = default;

namespace {

static_assert(VoxelSource::kWidth == voxel::kBoxSizeX && VoxelSource::kWidth == voxel::kBoxSizeZ &&
              VoxelSource::kHeight == voxel::kBoxSizeY);

void refuse(const std::string& what) {
    throw util::UsageError("open a world of one's own: " + what);
}

voxel::WorldInfo make_info(const WorldInfo& own) {
    constexpr std::int32_t kFarthest = 1 << 26;
    if (!(own.voxel_m > 0 && own.voxel_m <= 1000))
        refuse("voxel_m = " + std::to_string(own.voxel_m) + "; allowed: above 0, up to 1000");
    for (std::size_t a = 0; a < 3; ++a)
        if (own.block.min[a] >= own.block.max[a] || own.block.min[a] < -kFarthest ||
            own.block.max[a] > kFarthest)
            refuse("block = " + std::to_string(own.block.min[a]) + " to " +
                   std::to_string(own.block.max[a]) +
                   " along an axis; allowed: rising, -2^26 to 2^26");
    voxel::WorldInfo out;
    out.title = own.title;
    out.bounds = {own.block.min, own.block.max};
    out.voxel_m = own.voxel_m;
    out.levels = voxel::levels_for(out.bounds);
    out.licence = own.licence;
    out.attribution = own.attribution;
    if (own.crs.empty())
        return out;
    const geo::Crs crs = geo::Crs::from_text(own.crs);
    if (crs.geographic())
        refuse("crs = " + own.crs + ", in degrees; allowed: one in metres or feet");
    out.crs = crs.name();
    out.crs_wkt = crs.wkt();
    out.crs_units_per_voxel = own.voxel_m / crs.metres_per_unit();
    const double x = (out.bounds.min[0] + out.bounds.max[0]) / 2.0 * out.crs_units_per_voxel;
    const double y = -(out.bounds.min[2] + out.bounds.max[2]) / 2.0 * out.crs_units_per_voxel;
    out.centre = geo::map_place(crs, x, y);
    return out;
}

std::size_t to_number(int x, int y, int z) noexcept {
    return static_cast<std::size_t>((y * voxel::kBoxSizeZ + z) * voxel::kBoxSizeX + x);
}

voxel::Material to_material(const Voxel& own) noexcept {
    return static_cast<voxel::Material>(own.material < voxel::kMaterialCount
                                            ? own.material
                                            : static_cast<std::uint8_t>(voxel::Material::kUnknown));
}

voxel::VoxelAttr to_attr(const Voxel& own) noexcept {
    voxel::VoxelAttr out;
    out.material = to_material(own);
    out.source_class = own.source_class;
    if (own.has_colour) {
        out.flags |= voxel::VoxelAttr::kHasColour;
        out.colour = {own.rgb[0], own.rgb[1], own.rgb[2]};
    }
    return out;
}

/// Adds a column of a box, run by run: neighbours of one kind together.
void add_column(voxel::BoxBuilder& builder, std::span<const Voxel> voxels, int x, int z) {
    const auto kind = [&](int y) {
        const Voxel& at = voxels[to_number(x, y, z)];
        return at.material == 0 ? 0 : voxel::see_through(to_material(at)) ? 1 : 2;
    };
    for (int y = 0; y < voxel::kBoxSizeY;) {
        const int what = kind(y);
        int end = y + 1;
        while (end < voxel::kBoxSizeY && kind(end) == what)
            ++end;
        if (what != 0)
            builder.add(x, z, y, end, what == 2);
        y = end;
    }
}

std::shared_ptr<const voxel::Box> to_box(const voxel::BoxKey& key, std::span<const Voxel> voxels) {
    voxel::BoxBuilder builder;
    for (int z = 0; z < voxel::kBoxSizeZ; ++z)
        for (int x = 0; x < voxel::kBoxSizeX; ++x)
            add_column(builder, voxels, x, z);
    return builder.build(key,
                         [&](int x, int y, int z) { return to_attr(voxels[to_number(x, y, z)]); });
}

}  // namespace

SourceWorld::SourceWorld(std::shared_ptr<VoxelSource> source, std::size_t limit_bytes)
    : PyramidWorld(limit_bytes), m_source(std::move(source)), m_info(make_info(m_source->info())) {}

voxel::FineColumn SourceWorld::make_column(std::int32_t bx, std::int32_t bz) {
    voxel::FineColumn out;
    const voxel::BoxRange range = voxel::boxes_over(m_info.bounds, 0);
    if (bx < range.min.bx || bx >= range.max.bx || bz < range.min.bz || bz >= range.max.bz)
        return out;
    out.by_begin = range.min.by;
    std::vector<Voxel> voxels(to_number(0, voxel::kBoxSizeY, 0));
    for (std::int32_t by = range.min.by; by < range.max.by; ++by) {
        std::fill(voxels.begin(), voxels.end(), Voxel{});
        const std::array<std::int32_t, 3> corner{bx * voxel::kBoxSizeX, by * voxel::kBoxSizeY,
                                                 bz * voxel::kBoxSizeZ};
        const bool any = m_source->fill(corner, voxels);
        out.boxes.push_back(any ? to_box({0, bx, by, bz}, voxels) : nullptr);
    }
    return out;
}

}  // namespace terravox
