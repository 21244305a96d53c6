#include "voxelserver/serve/map/finest_tile.hpp"

#include <algorithm>
#include <array>

namespace terravox::map {
namespace {

constexpr int kSide = kTileBoxes * voxel::kBoxSizeX;  ///< pixels
constexpr int kRingSide = kTileBoxes + 2;
const ColumnTop kNothing;

/// The tile's box columns and the ring around them; indices from -1 to kTileBoxes.
class Patchwork {
public:
    Patchwork(TopSource& source, const voxel::InputExtent& world, std::int32_t x, std::int32_t z,
              bool make, FinestTile& out)
        : m_source(source),
          m_world(world),
          m_bx(std::int64_t{x} * kTileBoxes),
          m_bz(std::int64_t{z} * kTileBoxes),
          m_make(make),
          m_out(out) {}

    void fetch(int dx, int dz) {
        const std::int64_t bx = m_bx + dx;
        const std::int64_t bz = m_bz + dz;
        if (bx < m_world.min_bx || bx >= m_world.max_bx || bz < m_world.min_bz ||
            bz >= m_world.max_bz)
            return;
        const Top top =
            m_source.top(static_cast<std::int32_t>(bx), static_cast<std::int32_t>(bz), m_make);
        m_out.complete = m_out.complete && top.known;
        if (!top.known)
            return;
        const auto x = static_cast<std::int32_t>(bx);
        const auto z = static_cast<std::int32_t>(bz);
        m_out.reach.add({x, z, x + 1, z + 1});
        m_out.reach.add(top.reach);
        m_tops[index(dx, dz)] = top.top;
    }
    [[nodiscard]] const BoxTop* top(int dx, int dz) const { return m_tops[index(dx, dz)].get(); }
    /// Column of the tile, x and z in [-1, kSide].
    [[nodiscard]] const ColumnTop& at(int x, int z) const {
        const BoxTop* box = top((x + 64) / 64 - 1, (z + 64) / 64 - 1);
        return box ? box->at(x & 63, z & 63) : kNothing;
    }

private:
    static std::size_t index(int dx, int dz) {
        return static_cast<std::size_t>((dz + 1) * kRingSide + dx + 1);
    }
    TopSource& m_source;
    const voxel::InputExtent& m_world;
    const std::int64_t m_bx;
    const std::int64_t m_bz;
    const bool m_make;
    FinestTile& m_out;
    std::array<std::shared_ptr<const BoxTop>, kRingSide * kRingSide> m_tops;
};

bool has_neighbour_inside(const Patchwork& tops, int dx, int dz) {
    for (int z = std::max(dz - 1, 0); z <= std::min(dz + 1, kTileBoxes - 1); ++z)
        for (int x = std::max(dx - 1, 0); x <= std::min(dx + 1, kTileBoxes - 1); ++x)
            if (tops.top(x, z))
                return true;
    return false;
}

void fetch_all(Patchwork& tops) {
    for (int dz = 0; dz < kTileBoxes; ++dz)
        for (int dx = 0; dx < kTileBoxes; ++dx)
            tops.fetch(dx, dz);
    for (int dz = -1; dz <= kTileBoxes; ++dz)
        for (int dx = -1; dx <= kTileBoxes; ++dx) {
            const bool inside = dx >= 0 && dx < kTileBoxes && dz >= 0 && dz < kTileBoxes;
            if (!inside && has_neighbour_inside(tops, dx, dz))
                tops.fetch(dx, dz);
        }
}

void shade_box(const Patchwork& tops, int box_x, int box_z, std::vector<Rgba8>& pixels) {
    for (int z = box_z * 64; z < box_z * 64 + 64; ++z)
        for (int x = box_x * 64; x < box_x * 64 + 64; ++x) {
            TopWindow window{};
            for (int i = 0; i < 9; ++i)
                window[static_cast<std::size_t>(i)] = &tops.at(x + i % 3 - 1, z + i / 3 - 1);
            pixels[static_cast<std::size_t>(z * kSide + x)] = shaded_pixel(window);
        }
}

}  // namespace

FinestTile make_finest_tile(TopSource& source, const voxel::InputExtent& world, std::int32_t x,
                            std::int32_t z, bool make) {
    FinestTile out;
    Patchwork tops(source, world, x, z, make, out);
    fetch_all(tops);
    for (int dz = 0; dz < kTileBoxes; ++dz)
        for (int dx = 0; dx < kTileBoxes; ++dx)
            if (tops.top(dx, dz)) {
                if (out.pixels.empty())
                    out.pixels.resize(std::size_t{kSide} * kSide);
                shade_box(tops, dx, dz, out.pixels);
            }
    return out;
}

}  // namespace terravox::map
