#include "voxelserver/out/export/mesh/chunk.hpp"

#include <algorithm>

#include "voxelserver/out/export/shape/each_voxel.hpp"

namespace terravox::exports {

using voxel::VoxelBounds;

void Chunk::set(int x, int y, int z, FaceAttributes attributes) noexcept {
    m_attributes[index(x, y, z)] = attributes;
    if (x < 0 || x >= kEdge)
        return;  // a row has no bits for its margin: use attributes() there
    Row& r = m_rows[row(y, z)];
    (voxel::see_through(material_of(attributes)) ? r.clear : r.opaque) |= std::uint64_t{1} << x;
}

bool Chunk::fill(const Neighbourhood& boxes, int storey, const VoxelBounds& bounds,
                 const AttributesOf& attributes_of) {
    m_seen = 0;
    if (!boxes.self)
        return false;
    const voxel::TreeCell& root = boxes.self->cells()[static_cast<std::size_t>(storey)];
    if (root.mask == 0)
        return false;
    std::fill(m_attributes.begin(), m_attributes.end(), FaceAttributes{0});
    std::fill(m_rows.begin(), m_rows.end(), Row{});

    // The part, in voxels of this chunk.
    std::array<int, 3> lo{};
    std::array<int, 3> hi{};
    for (std::size_t a = 0; a < 3; ++a) {
        const int shift = a == 1 ? storey * kEdge : 0;
        lo[a] = std::clamp(bounds.min[a] - shift, 0, kEdge);
        hi[a] = std::clamp(bounds.max[a] - shift, 0, kEdge);
    }
    const auto inside = [&](int x, int y, int z) {
        return x >= lo[0] && x < hi[0] && y >= lo[1] && y < hi[1] && z >= lo[2] && z < hi[2];
    };
    const FaceAttributes rock = attributes_of(voxel::VoxelAttr{});
    each_voxel_of(
        *boxes.self, root, 0, 0, 0, 16,
        [&](int x, int y, int z, const voxel::VoxelAttr& attr) {
            if (!inside(x, y, z))
                return;
            set(x, y, z, attributes_of(attr));
            ++m_seen;
        },
        [&](int x0, int y0, int z0, int edge) {
            for (int y = std::max(y0, lo[1]); y < std::min(y0 + edge, hi[1]); ++y)
                for (int z = std::max(z0, lo[2]); z < std::min(z0 + edge, hi[2]); ++z)
                    for (int x = std::max(x0, lo[0]); x < std::min(x0 + edge, hi[0]); ++x)
                        set(x, y, z, rock);
        });
    fill_margin(boxes, storey, bounds, attributes_of);
    return true;
}

void Chunk::fill_margin(const Neighbourhood& boxes, int storey, const VoxelBounds& bounds,
                        const AttributesOf& attributes_of) {
    // y counts in the box here.
    const auto copy = [&](const Neighbourhood::BoxPtr& from, int x, int y, int z, int fx, int fy,
                          int fz) {
        if (x < bounds.min[0] || x >= bounds.max[0] || y < bounds.min[1] || y >= bounds.max[1] ||
            z < bounds.min[2] || z >= bounds.max[2])
            return;
        if (const auto attr = from->voxel(fx, fy, fz))
            set(x, y - storey * kEdge, z, attributes_of(*attr));
    };
    const int y0 = storey * kEdge;
    const int y1 = y0 + kEdge;
    const auto& below = storey > 0 ? boxes.self : boxes.below;
    const auto& above = storey + 1 < voxel::Box::kRootCount ? boxes.self : boxes.above;
    constexpr int kTop = voxel::kBoxSizeY - 1;
    for (int a = 0; a < kEdge; ++a)
        for (int b = 0; b < kEdge; ++b) {
            if (below)
                copy(below, a, y0 - 1, b, a, (y0 - 1) & kTop, b);
            if (above)
                copy(above, a, y1, b, a, y1 & kTop, b);
            if (boxes.west)
                copy(boxes.west, -1, y0 + a, b, kEdge - 1, y0 + a, b);
            if (boxes.east)
                copy(boxes.east, kEdge, y0 + a, b, 0, y0 + a, b);
            if (boxes.north)
                copy(boxes.north, b, y0 + a, -1, b, y0 + a, kEdge - 1);
            if (boxes.south)
                copy(boxes.south, b, y0 + a, kEdge, b, y0 + a, 0);
        }
}

}  // namespace terravox::exports
