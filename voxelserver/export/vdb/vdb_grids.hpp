#pragma once

// OpenVDB's headers are large: only the sources of this folder include this one.
#include <openvdb/openvdb.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "voxelserver/export/core/columns.hpp"
#include "voxelserver/export/vdb/vdb.hpp"

namespace terravox::exports {

/// The three trees of one column of boxes, or of many.
struct VdbTrees {
    openvdb::FloatTree::Ptr density = std::make_shared<openvdb::FloatTree>(0.f);
    openvdb::Int32Tree::Ptr material = std::make_shared<openvdb::Int32Tree>(0);
    openvdb::Vec3STree::Ptr colour = std::make_shared<openvdb::Vec3STree>(openvdb::Vec3s(0.f));
    std::uint64_t voxels = 0;
    std::uint64_t checksum = 0;  ///< of the boxes, in order

    [[nodiscard]] bool empty() const noexcept { return voxels == 0; }
    [[nodiscard]] std::uint64_t memory_bytes() const {
        return density->memUsage() + material->memUsage() + colour->memUsage();
    }
    /// Moves everything out of another column; leaves it empty.
    void take(VdbTrees& other);
};

/// Maps voxels of the world to voxels of a grid. Grids begin at a voxel whose coordinates are
/// multiples of 128, so that leaves of 8 voxels and nodes of 128 are aligned with boxes.
class VdbFrame {
public:
    VdbFrame(const Job& job, UpAxis up);
    /// The grid's coordinates of a voxel of the world.
    [[nodiscard]] openvdb::Coord coord(std::int32_t x, std::int32_t y,
                                       std::int32_t z) const noexcept {
        const std::int32_t i = x - m_base[0];
        const std::int32_t j = y - m_base[1];
        const std::int32_t k = z - m_base[2];
        return m_up == UpAxis::kY ? openvdb::Coord(i, j, k) : openvdb::Coord(i, -1 - k, j);
    }
    /// Transform to metres from the origin of the part, a voxel's value at its middle.
    [[nodiscard]] openvdb::math::Transform::Ptr transform() const;
    [[nodiscard]] const char* axes() const noexcept {
        return m_up == UpAxis::kY ? "x east, y up, z south; metres"
                                  : "x east, y north, z up; metres";
    }

private:
    UpAxis m_up;
    std::array<std::int32_t, 3> m_base{};
    std::array<std::int32_t, 3> m_origin{};
    double m_voxel_m;
};

/// Makes the trees of one column of boxes. Thread-safe.
[[nodiscard]] VdbTrees make_vdb_column(Job& job, const VdbFrame& frame, std::int32_t bx,
                                       std::int32_t bz);

/// Writes the trees as one file, whole or not at all.
/// @throws Error
void write_vdb_file(Job& job, const VdbFrame& frame, const VdbTrees& trees,
                    const std::filesystem::path& file);

}  // namespace terravox::exports
