#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "common/util/cache.hpp"
#include "voxelserver/out/export/core/job.hpp"
#include "voxelserver/out/export/mesh/faces.hpp"
#include "voxelserver/out/export/mesh/mesh.hpp"

namespace terravox::exports {

struct MeshVertex {
    std::array<std::int32_t, 3> at{};  ///< voxels from origin_of(part); x east, y up, z south
    FaceAttributes attributes = 0;
};

/// Four-sided faces, counter-clockwise as seen from outside; faces with equal attributes
/// share vertices.
struct IndexedQuads {
    std::vector<MeshVertex> vertices;
    std::vector<std::array<std::uint32_t, 4>> quads;
};

/// The faces of one column of boxes, by material.
struct ColumnMesh {
    std::map<voxel::Material, IndexedQuads> parts;
    std::uint64_t seen_voxels = 0;
};

/// Makes the faces of columns of boxes. Thread-safe.
class ColumnMesher {
public:
    /// The job must outlive it.
    ColumnMesher(Job& job, const MeshOptions& options);
    /// A box that the job counts as a hole is air here.
    [[nodiscard]] ColumnMesh make(std::int32_t bx, std::int32_t bz);

private:
    using BoxPtr = std::shared_ptr<const voxel::Box>;
    [[nodiscard]] BoxPtr box(std::int32_t bx, std::int32_t by, std::int32_t bz);
    [[nodiscard]] Neighbourhood around(std::int32_t bx, std::int32_t by, std::int32_t bz);
    [[nodiscard]] FaceAttributes attributes_of_voxel(const voxel::VoxelAttr& attr) const noexcept;

    Job& m_job;
    const bool m_merge;
    const voxel::BoxRange m_range;
    const std::array<std::int32_t, 3> m_origin;
    std::array<std::uint8_t, 256> m_step_of{};  ///< the quantized value of a channel
    /// Each box is read for itself and for six neighbours.
    util::Cache<voxel::BoxKey, voxel::Box, voxel::BoxKeyHash> m_boxes;
};

}  // namespace terravox::exports
