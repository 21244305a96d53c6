#include "voxelserver/out/export/mesh/faces.hpp"

#include <algorithm>
#include <bit>

#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {

using voxel::VoxelBounds;

void Chunk::set(int x, int y, int z, FaceAttributes attributes) noexcept {
    m_attributes[index(x, y, z)] = attributes;
    if (x < 0 || x >= kEdge)
        return;  // a row has no bits for its margin: use attributes() there
    Row& r = m_rows[row(y, z)];
    (voxel::see_through(to_material(attributes)) ? r.clear : r.opaque) |= std::uint64_t{1} << x;
}

bool Chunk::fill(const Neighbourhood& boxes, int storey, const VoxelBounds& bounds,
                 const ToAttributes& to_attributes) {
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
    const FaceAttributes rock = to_attributes(voxel::VoxelAttr{});
    visit_each_voxel(
        *boxes.self, root, 0, 0, 0, 16,
        [&](int x, int y, int z, const voxel::VoxelAttr& attr) {
            if (!inside(x, y, z))
                return;
            set(x, y, z, to_attributes(attr));
            ++m_seen;
        },
        [&](int x0, int y0, int z0, int edge) {
            for (int y = std::max(y0, lo[1]); y < std::min(y0 + edge, hi[1]); ++y)
                for (int z = std::max(z0, lo[2]); z < std::min(z0 + edge, hi[2]); ++z)
                    for (int x = std::max(x0, lo[0]); x < std::min(x0 + edge, hi[0]); ++x)
                        set(x, y, z, rock);
        });
    fill_margin(boxes, storey, bounds, to_attributes);
    return true;
}

void Chunk::fill_margin(const Neighbourhood& boxes, int storey, const VoxelBounds& bounds,
                        const ToAttributes& to_attributes) {
    // y counts in the box here.
    const auto copy = [&](const Neighbourhood::BoxPtr& from, int x, int y, int z, int fx, int fy,
                          int fz) {
        if (x < bounds.min[0] || x >= bounds.max[0] || y < bounds.min[1] || y >= bounds.max[1] ||
            z < bounds.min[2] || z >= bounds.max[2])
            return;
        if (const auto attr = from->voxel(fx, fy, fz))
            set(x, y - storey * kEdge, z, to_attributes(*attr));
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

namespace {

constexpr int kEdge = Chunk::kEdge;

/// Axes: 0 x, 1 y, 2 z.
struct Direction {
    int axis;
    int u;
    int v;
    int sign;
};
constexpr Direction to_direction(Facing f) noexcept {
    constexpr std::array<Direction, kFacings> kAll = {
        {{0, 2, 1, -1}, {0, 2, 1, 1}, {1, 0, 2, -1}, {1, 0, 2, 1}, {2, 0, 1, -1}, {2, 0, 1, 1}}};
    return kAll[static_cast<std::size_t>(f)];
}

// The place of a face: the voxel at (slice, u, v).
std::array<int, 3> voxel_at(const Direction& d, int slice, int u, int v) noexcept {
    std::array<int, 3> out{};
    out[static_cast<std::size_t>(d.axis)] = slice;
    out[static_cast<std::size_t>(d.u)] = u;
    out[static_cast<std::size_t>(d.v)] = v;
    return out;
}

}  // namespace

std::array<std::array<int, 3>, 4> list_corners(const Quad& q) noexcept {
    const Direction d = to_direction(q.facing);
    const int slice = q.slice + (d.sign > 0 ? 1 : 0);
    const int u0 = q.u;
    const int u1 = q.u + q.width;
    const int v0 = q.v;
    const int v1 = q.v + q.height;
    // u x v looks west, down or south.
    if (q.facing == Facing::kWest || q.facing == Facing::kDown || q.facing == Facing::kSouth)
        return {voxel_at(d, slice, u0, v0), voxel_at(d, slice, u1, v0), voxel_at(d, slice, u1, v1),
                voxel_at(d, slice, u0, v1)};
    return {voxel_at(d, slice, u0, v0), voxel_at(d, slice, u0, v1), voxel_at(d, slice, u1, v1),
            voxel_at(d, slice, u1, v0)};
}

void FaceFinder::find(const Chunk& chunk, bool merge, std::vector<Quad>& out) {
    for (int f = 0; f < kFacings; ++f) {
        mark(chunk, static_cast<Facing>(f));
        collect(chunk, static_cast<Facing>(f), merge, out);
    }
}

// Handles opaque voxels row by row, 64 at once; see-through ones one by one, since their
// neighbours' materials matter.
void FaceFinder::mark(const Chunk& chunk, Facing facing) {
    for (Rows& rows : m_slices)
        rows.fill(0);
    const Direction d = to_direction(facing);
    const int dx = d.axis == 0 ? d.sign : 0;
    const int dy = d.axis == 1 ? d.sign : 0;
    const int dz = d.axis == 2 ? d.sign : 0;
    for (int y = 0; y < kEdge; ++y)
        for (int z = 0; z < kEdge; ++z) {
            const std::uint64_t opaque = chunk.opaque(y, z);
            const std::uint64_t clear = chunk.clear(y, z);
            if ((opaque | clear) == 0)
                continue;
            std::uint64_t covered = 0;  // bit x: the neighbour of (x, y, z) is opaque
            if (dx == 0) {
                covered = chunk.opaque(y + dy, z + dz);
            } else {
                const FaceAttributes end = chunk.attributes(dx < 0 ? -1 : kEdge, y, z);
                const auto end_opaque =
                    std::uint64_t{end != 0 && !voxel::see_through(to_material(end))};
                covered =
                    dx < 0 ? opaque << 1 | end_opaque : opaque >> 1 | end_opaque << (kEdge - 1);
            }
            std::uint64_t shown = opaque & ~covered;
            for (std::uint64_t left = clear & ~covered; left != 0; left &= left - 1) {
                const int x = std::countr_zero(left);
                if (shows_face(chunk.attributes(x, y, z), chunk.attributes(x + dx, y + dy, z + dz)))
                    shown |= left & (~left + 1);
            }
            if (d.axis == 0) {
                for (; shown != 0; shown &= shown - 1)
                    m_slices[static_cast<std::size_t>(std::countr_zero(shown))]
                            [static_cast<std::size_t>(y)] |= std::uint64_t{1} << z;
            } else {
                m_slices[static_cast<std::size_t>(d.axis == 1 ? y : z)]
                        [static_cast<std::size_t>(d.axis == 1 ? z : y)] = shown;
            }
        }
}

// Greedy: as wide as the attributes stay the same, then as many rows as match over the whole width.
// Ref: Lysenko, "Meshing in a Minecraft Game", 2012.
void FaceFinder::collect(const Chunk& chunk, Facing facing, bool merge, std::vector<Quad>& out) {
    const Direction d = to_direction(facing);
    for (int slice = 0; slice < kEdge; ++slice) {
        Rows& rows = m_slices[static_cast<std::size_t>(slice)];
        const auto attributes = [&](int u, int v) {
            const auto at = voxel_at(d, slice, u, v);
            return chunk.attributes(at[0], at[1], at[2]);
        };
        for (int v = 0; v < kEdge; ++v) {
            std::uint64_t& row = rows[static_cast<std::size_t>(v)];
            while (row != 0) {
                const int u = std::countr_zero(row);
                const FaceAttributes own = attributes(u, v);
                int width = 1;
                int height = 1;
                while (merge && u + width < kEdge && (row >> (u + width) & 1) != 0 &&
                       attributes(u + width, v) == own)
                    ++width;
                const std::uint64_t run =
                    (width == kEdge ? ~std::uint64_t{0} : (std::uint64_t{1} << width) - 1) << u;
                row &= ~run;
                const auto alike = [&](int w) {
                    if ((rows[static_cast<std::size_t>(w)] & run) != run)
                        return false;
                    for (int i = 0; i < width; ++i)
                        if (attributes(u + i, w) != own)
                            return false;
                    return true;
                };
                for (; merge && v + height < kEdge && alike(v + height); ++height)
                    rows[static_cast<std::size_t>(v + height)] &= ~run;
                out.push_back({facing, static_cast<std::uint8_t>(slice),
                               static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v),
                               static_cast<std::uint8_t>(width), static_cast<std::uint8_t>(height),
                               own});
            }
        }
    }
}

}  // namespace terravox::exports
