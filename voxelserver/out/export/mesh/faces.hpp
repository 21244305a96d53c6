#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxelserver/out/export/mesh/chunk.hpp"

namespace terravox::exports {

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
[[nodiscard]] std::array<std::array<int, 3>, 4> corners_of(const Quad& quad) noexcept;

/// Whether a voxel shows the face that it shares with a neighbour: next to air always, and next to
/// a see-through voxel of another material. Between two voxels of which neither is opaque, both
/// faces are shown.
[[nodiscard]] constexpr bool shows_face(FaceAttributes of, FaceAttributes neighbour) noexcept {
    return of != 0 && (neighbour == 0 || (voxel::see_through(material_of(neighbour)) &&
                                          material_of(of) != material_of(neighbour)));
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
