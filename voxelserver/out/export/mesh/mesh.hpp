#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "common/util/cache.hpp"
#include "voxelserver/out/export/core/format.hpp"
#include "voxelserver/out/export/core/job.hpp"
#include "voxelserver/out/export/mesh/faces.hpp"
#include "voxelserver/out/export/shape/byte_file.hpp"

namespace terravox::exports {

enum class MeshFormat : std::uint8_t {
    /// glTF 2.0 in one binary file: y up, metres; a primitive for each material, colours as vertex
    /// colours.
    kGlb,
    /// Stanford triangles, binary: z up, metres, four-sided faces; colour and material at the
    /// vertices.
    kPly,
};

struct MeshOptions {
    /// Combine adjacent faces of one material and one colour. Their edges then end within edges of
    /// others (T-junctions): closed to the eye, but programs that need two faces at each edge need
    /// it off.
    bool merge = true;
    /// Steps of each colour channel, 2 to 255, or 0 for colours as they are: fewer steps, larger
    /// faces.
    int colour_steps = 0;
    /// Maximum size of a glTF file; never more than these 4 GiB, as its lengths have 32 bits.
    std::uint64_t max_glb_bytes = 0xFFFF'FFFFu;
};

/// Writes the visible faces of a part: towards air, and towards see-through voxels of another
/// material. Everything outside the part counts as air, so a solid part is closed. Coordinates are
/// metres from make_origin(part). Streams: memory does not grow with the part. The bytes do not
/// depend on the number of threads.
/// @throws UsageError for options out of range; Error when nothing is solid, the file would become
/// too large, or cannot be written
void write_mesh(Job& job, MeshFormat format, const MeshOptions& options = {});

struct MeshVertex {
    std::array<std::int32_t, 3> at{};  ///< voxels from make_origin(part); x east, y up, z south
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

/// Receives the meshes of columns one after the other, in the order of the file, and writes the
/// file at the end: its header contains the total size. Not thread-safe.
class MeshWriter {
public:
    virtual ~MeshWriter() = default;
    /// @throws Error when the file would become too large
    virtual void add(const ColumnMesh& mesh) = 0;
    [[nodiscard]] virtual bool empty() const noexcept = 0;
    /// To be called once, and not when empty().
    virtual void finish(ByteFile& to) = 0;
};
[[nodiscard]] std::unique_ptr<MeshWriter> make_glb_writer(const Job& job,
                                                          const MeshOptions& options);
[[nodiscard]] std::unique_ptr<MeshWriter> make_ply_writer(const Job& job);

extern const Format kGlbFormat;
extern const Format kPlyFormat;

}  // namespace terravox::exports
