#pragma once

#include <memory>

#include "voxelserver/out/export/mesh/column_mesh.hpp"
#include "voxelserver/out/export/shape/byte_file.hpp"

namespace terravox::exports {

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

}  // namespace terravox::exports
