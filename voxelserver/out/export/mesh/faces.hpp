#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"

namespace terravox::exports {

/// What faces must have in common to be merged: material and colour of a voxel in one number,
/// material << 24 | r << 16 | g << 8 | b; 0 = air.
using FaceAttributes = std::uint32_t;
[[nodiscard]] constexpr voxel::Material to_material(FaceAttributes attributes) noexcept {
    return static_cast<voxel::Material>(attributes >> 24);
}
[[nodiscard]] constexpr voxel::Rgb8 to_colour(FaceAttributes attributes) noexcept {
    return {static_cast<std::uint8_t>(attributes >> 16), static_cast<std::uint8_t>(attributes >> 8),
            static_cast<std::uint8_t>(attributes)};
}
[[nodiscard]] constexpr FaceAttributes to_attributes(voxel::Material material,
                                                     voxel::Rgb8 c) noexcept {
    return static_cast<FaceAttributes>(material) << 24 | static_cast<FaceAttributes>(c.r) << 16 |
           static_cast<FaceAttributes>(c.g) << 8 | c.b;
}

/// A box and its six neighbours; nullptr = air.
struct Neighbourhood {
    using BoxPtr = std::shared_ptr<const voxel::Box>;
    BoxPtr self;
    BoxPtr west;
    BoxPtr east;
    BoxPtr below;
    BoxPtr above;
    BoxPtr north;
    BoxPtr south;
};

/// 64 x 64 x 64 voxels, a quarter of a box, with a margin of one voxel on each side: the input of
/// FaceFinder. Not thread-safe.
class Chunk {
public:
    static constexpr int kEdge = 64;
    using ToAttributes = std::function<FaceAttributes(const voxel::VoxelAttr&)>;

    /// @param storey 0 to 3, bottom first
    /// @param bounds of the part, in voxels relative to the lowest corner of the box; everything
    /// outside is air
    /// @return false when it is air throughout (and nothing was filled)
    bool fill(const Neighbourhood& boxes, int storey, const voxel::VoxelBounds& bounds,
              const ToAttributes& to_attributes);

    /// x, y, z in [-1, 65), of which at most one is outside [0, 64).
    [[nodiscard]] FaceAttributes attributes(int x, int y, int z) const noexcept {
        return m_attributes[index(x, y, z)];
    }
    /// Bit x = the voxel (x, y, z) is opaque; y, z in [-1, 65), at most one outside [0, 64).
    [[nodiscard]] std::uint64_t opaque(int y, int z) const noexcept {
        return m_rows[row(y, z)].opaque;
    }
    /// The same for voxels that are not air, but not opaque either.
    [[nodiscard]] std::uint64_t clear(int y, int z) const noexcept {
        return m_rows[row(y, z)].clear;
    }
    /// Number of voxels with attributes.
    [[nodiscard]] std::uint64_t seen() const noexcept { return m_seen; }

private:
    static constexpr int kSide = kEdge + 2;
    struct Row {
        std::uint64_t opaque = 0;
        std::uint64_t clear = 0;
    };
    static std::size_t row(int y, int z) noexcept {
        return static_cast<std::size_t>((y + 1) * kSide + z + 1);
    }
    static std::size_t index(int x, int y, int z) noexcept {
        return row(y, z) * kSide + static_cast<std::size_t>(x + 1);
    }
    void set(int x, int y, int z, FaceAttributes attributes) noexcept;
    void fill_margin(const Neighbourhood& boxes, int storey, const voxel::VoxelBounds& bounds,
                     const ToAttributes& to_attributes);

    std::vector<FaceAttributes> m_attributes =
        std::vector<FaceAttributes>(static_cast<std::size_t>(kSide) * kSide * kSide);
    std::vector<Row> m_rows = std::vector<Row>(static_cast<std::size_t>(kSide) * kSide);
    std::uint64_t m_seen = 0;
};

/// The direction that a face is oriented to.
enum class Facing : std::uint8_t { kWest, kEast, kDown, kUp, kNorth, kSouth };
inline constexpr int kFacings = 6;

/// A rectangle of faces with equal attributes, in voxels of its chunk. `slice` is the coordinate of
/// the faces' voxels along the axis of `facing`; u runs along z for west and east, along x for the
/// others; v runs along z for down and up, along y for the others.
struct Quad {
    Facing facing = Facing::kUp;
    std::uint8_t slice = 0;
    std::uint8_t u = 0;
    std::uint8_t v = 0;
    std::uint8_t width = 1;
    std::uint8_t height = 1;
    FaceAttributes attributes = 0;
    friend bool operator==(const Quad&, const Quad&) = default;
};
/// Its corners in voxels of its chunk, counter-clockwise as seen from outside.
[[nodiscard]] std::array<std::array<int, 3>, 4> list_corners(const Quad& quad) noexcept;

/// Whether a voxel shows the face that it shares with a neighbour: next to air always, and next to
/// a see-through voxel of another material. Between two voxels of which neither is opaque, both
/// faces are shown.
[[nodiscard]] constexpr bool shows_face(FaceAttributes of, FaceAttributes neighbour) noexcept {
    return of != 0 && (neighbour == 0 || (voxel::see_through(to_material(neighbour)) &&
                                          to_material(of) != to_material(neighbour)));
}

/// Finds all faces of the voxels of a chunk (not those of its margin), each in exactly one quad.
/// Not thread-safe: it holds working memory.
class FaceFinder {
public:
    /// @param merge combine adjacent faces with equal attributes; else one quad for each face
    void find(const Chunk& chunk, bool merge, std::vector<Quad>& out);

private:
    void mark(const Chunk& chunk, Facing facing);
    void collect(const Chunk& chunk, Facing facing, bool merge, std::vector<Quad>& out);
    using Rows = std::array<std::uint64_t, Chunk::kEdge>;
    /// [slice][v], bit u: the faces that are left to be collected.
    std::vector<Rows> m_slices = std::vector<Rows>(Chunk::kEdge);
};

}  // namespace terravox::exports
