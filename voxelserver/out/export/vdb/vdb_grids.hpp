#pragma once

// Without OpenVDB's headers: they take longer to compile than all else in this folder.
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "voxelserver/out/export/core/columns.hpp"
#include "voxelserver/out/export/vdb/vdb.hpp"

namespace terravox::exports {

/// To be called once, before anything else of this header. Thread-safe.
void start_vdb();

/// The three trees (density, material, colour) of one column of boxes, or of many.
class VdbTrees {
public:
    struct Trees;

    VdbTrees();
    ~VdbTrees();
    VdbTrees(VdbTrees&&) noexcept;
    VdbTrees& operator=(VdbTrees&&) noexcept;

    [[nodiscard]] bool empty() const noexcept { return voxels == 0; }
    /// Memory of the leaves, bytes. Nodes above them are few, and shared by many columns.
    [[nodiscard]] std::uint64_t leaf_bytes() const;
    /// Moves everything out of another column; leaves it empty.
    void take(VdbTrees& other);

    std::uint64_t voxels = 0;
    std::uint64_t checksum = 0;  ///< of the boxes, in order
    std::unique_ptr<Trees> trees;
};

/// Maps voxels of the world to voxels of a grid. Grids begin at a voxel whose coordinates are
/// multiples of 128, so that leaves of 8 voxels and nodes of 128 are aligned with boxes.
class VdbFrame {
public:
    VdbFrame(const Job& job, UpAxis up);
    /// The grid's coordinates of a voxel of the world.
    [[nodiscard]] std::array<std::int32_t, 3> coord(std::int32_t x, std::int32_t y,
                                                    std::int32_t z) const noexcept {
        const std::int32_t i = x - m_base[0];
        const std::int32_t j = y - m_base[1];
        const std::int32_t k = z - m_base[2];
        if (m_up == UpAxis::kY)
            return {i, j, k};
        return {i, -1 - k, j};
    }
    [[nodiscard]] double voxel_m() const noexcept { return m_voxel_m; }
    /// Where the middle of the grid's voxel (0, 0, 0) is, metres from the origin of the part.
    [[nodiscard]] std::array<double, 3> shift_m() const noexcept;
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
void write_vdb_file(Job& job, const VdbFrame& frame, const VdbTrees& made,
                    const std::filesystem::path& file);

/// Does what write_vdb() promises; with all of the above, a part of terravox-vdb.so.
void write_vdb_files(Job& job, const VdbOptions& options);

}  // namespace terravox::exports
