#include "voxelserver/make/voxelize/steps/photo_surface.hpp"

#include <algorithm>
#include <utility>

namespace terravox::voxelize {
namespace {

using sunlight::Kind;

static_assert(PhotoSurface::kFilledTogether + sunlight::kGapReach <= grid::kPatchSize);

constexpr std::size_t kPatchBytes = 2 * grid::kPatchColumns * (sizeof(float) + sizeof(Kind));
/// Some 400 patches, since each is needed for the nine or more around it.
constexpr std::size_t kKeptBytes = 400 * kPatchBytes;

/// What is highest in a column.
struct Top {
    float height = kNoHeight;  ///< voxels
    Kind kind = Kind::kUnknown;
    void raise(const Surface& surface, Kind what) {
        if (surface.seen() && !(surface.height < height)) {
            height = surface.height;
            kind = what;
        }
    }
};

Top top_of(const PatchColumns& patch, std::size_t i, double voxel_m) {
    const Column& c = patch.columns[i];
    Top top;
    top.raise(c.ground, Kind::kGround);
    if (c.water.seen() && c.water_points > c.ground_points)
        top.raise(c.water, Kind::kWater);
    top.raise(c.deck, Kind::kGround);
    if (c.built_upon())
        top.raise(c.roof, Kind::kRoof);
    if (patch.objects_begin[i + 1] == patch.objects_begin[i])
        return top;
    constexpr double kHides_m = 1.5;  // grass, crops and cars do not
    const ObjectVoxel& object = patch.objects[patch.objects_begin[i + 1] - 1];
    const float height =
        static_cast<float>(object.y) + static_cast<float>(object.fraction) / 256.0F;
    if (top.kind == Kind::kUnknown || (height - top.height) * voxel_m > kHides_m)
        top = {height, Kind::kPlant};
    return top;
}

/// Copies a rectangle of cells.
/// @param x,z,width,height in `from`
/// @param to_x,to_z where it begins in `to`
void copy_cells(const sunlight::Surface& from, int x, int z, int width, int height,
                sunlight::Surface& to, int to_x, int to_z) {
    for (int row = 0; row < height; ++row) {
        const auto first = static_cast<std::ptrdiff_t>(from.index(x, z + row));
        const auto there = static_cast<std::ptrdiff_t>(to.index(to_x, to_z + row));
        std::copy_n(from.top_m.begin() + first, width, to.top_m.begin() + there);
        std::copy_n(from.kind.begin() + first, width, to.kind.begin() + there);
    }
}

}  // namespace

PhotoSurface::PhotoSurface(PointSet& points)
    : m_points(points),
      m_voxel_m(points.sources().frame.voxel_m()),
      m_nothing(std::make_shared<const PatchTops>(
          casting({grid::kPatchSize, grid::kPatchSize, 0, m_voxel_m}))),
      m_tops(kKeptBytes) {}

PhotoSurface::PatchTops PhotoSurface::casting(sunlight::Surface seen) {
    PatchTops out{seen, std::move(seen)};
    sunlight::fill_gaps(out.casts, sunlight::kSmallGap);
    return out;
}

std::shared_ptr<const PhotoSurface::PatchTops> PhotoSurface::tops_of(grid::PatchKey key) {
    const auto make = [&]() -> std::shared_ptr<const PatchTops> {
        const auto columns = m_points.columns(key);
        if (!columns->any)
            return m_nothing;
        sunlight::Surface seen(grid::kPatchSize, grid::kPatchSize, 0, m_voxel_m);
        for (std::size_t i = 0; i < grid::kPatchColumns; ++i) {
            const Top top = top_of(*columns, i, m_voxel_m);
            seen.top_m[i] = top.height * static_cast<float>(m_voxel_m);
            seen.kind[i] = top.kind;
        }
        return std::make_shared<const PatchTops>(casting(std::move(seen)));
    };
    const auto bytes_of = [&](const auto& tops) { return tops == m_nothing ? 0 : kPatchBytes; };
    return m_tops.get(key, make, bytes_of);
}

sunlight::Surface PhotoSurface::assembled(const grid::PatchRect& patches, int margin, Part part) {
    const int across = patches.max.px - patches.min.px + 2 * margin;
    const int down = patches.max.pz - patches.min.pz + 2 * margin;
    sunlight::Surface out(across * grid::kPatchSize, down * grid::kPatchSize,
                          margin * grid::kPatchSize, m_voxel_m);
    for (int pz = 0; pz < down; ++pz)
        for (int px = 0; px < across; ++px) {
            const auto tops = tops_of({patches.min.px - margin + px, patches.min.pz - margin + pz});
            copy_cells((*tops).*part, 0, 0, grid::kPatchSize, grid::kPatchSize, out,
                       px * grid::kPatchSize, pz * grid::kPatchSize);
        }
    return out;
}

sunlight::Surface PhotoSurface::around(const grid::PatchRect& patches, int margin) {
    sunlight::Surface out = assembled(patches, margin, &PatchTops::casts);
    sunlight::Surface near = sunlight::inner_cells(assembled(patches, 1, &PatchTops::seen),
                                                   kFilledTogether + sunlight::kGapReach);
    sunlight::fill_gaps(near);
    const int to = out.margin - kFilledTogether;
    copy_cells(near, sunlight::kGapReach, sunlight::kGapReach, near.width - 2 * sunlight::kGapReach,
               near.height - 2 * sunlight::kGapReach, out, to, to);
    return out;
}

}  // namespace terravox::voxelize
