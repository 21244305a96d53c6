#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/procedural/terrain.hpp"

namespace terravox::procedural {

/// Slowly changing values, computed at the nodes of a lattice whose position does not depend on the
/// caller, and interpolated bilinearly: some twenty times as fast.
class RegionLattice {
public:
    /// Covers the columns [x0, x0 + side) x [z0, z0 + side).
    /// @param step columns between nodes
    RegionLattice(const Terrain& terrain, std::int32_t x0, std::int32_t z0, std::int32_t side,
                  std::int32_t step)
        : m_step(step),
          m_first_x(voxel::floor_div(x0, step)),
          m_first_z(voxel::floor_div(z0, step)),
          m_nodes_across(side / step + 3) {
        m_nodes.reserve(static_cast<std::size_t>(m_nodes_across) *
                        static_cast<std::size_t>(m_nodes_across));
        for (std::int32_t z = 0; z < m_nodes_across; ++z)
            for (std::int32_t x = 0; x < m_nodes_across; ++x)
                m_nodes.push_back(
                    terrain.region((m_first_x + x) * static_cast<double>(step) + 0.5,
                                   (m_first_z + z) * static_cast<double>(step) + 0.5));
    }

    /// The values at a column.
    [[nodiscard]] Region at(std::int32_t x, std::int32_t z) const noexcept {
        const std::int32_t in_x = x - m_first_x * m_step;
        const std::int32_t in_z = z - m_first_z * m_step;
        const double fx = static_cast<double>(in_x % m_step) / m_step;
        const double fz = static_cast<double>(in_z % m_step) / m_step;
        const Region* a =
            &m_nodes[static_cast<std::size_t>(in_z / m_step * m_nodes_across + in_x / m_step)];
        const Region *b = a + 1, *c = a + m_nodes_across, *d = c + 1;
        const double wa = (1 - fx) * (1 - fz);
        const double wb = fx * (1 - fz);
        const double wc = (1 - fx) * fz;
        const double wd = fx * fz;
        Region out;
        for (const auto field :
             {&Region::land, &Region::inland, &Region::mountains, &Region::hills, &Region::river,
              &Region::temperature, &Region::moisture, &Region::warp_x, &Region::warp_z})
            out.*field = wa * a->*field + wb * b->*field + wc * c->*field + wd * d->*field;
        return out;
    }

private:
    std::int32_t m_step;
    std::int32_t m_first_x;
    std::int32_t m_first_z;
    std::int32_t m_nodes_across;
    std::vector<Region> m_nodes;
};

}  // namespace terravox::procedural
