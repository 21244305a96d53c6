#include "voxelserver/out/export/mesh/mesh_formats.hpp"

#include "voxelserver/out/export/mesh/mesh.hpp"

namespace terravox::exports {
namespace {

template <MeshFormat format>
void write(Job& job, const WriteOptions& options) {
    MeshOptions mesh;
    mesh.merge = options.merge_faces;
    mesh.colour_steps = options.colour_steps;
    write_mesh(job, format, mesh);
}

}  // namespace

const Format kGlbFormat{
    .name = "glb",
    .extension = ".glb",
    .check_target = check_file_target,
    .steps = column_steps,
    .write = write<MeshFormat::kGlb>,
};

const Format kPlyFormat{
    .name = "ply",
    .extension = ".ply",
    .check_target = check_file_target,
    .steps = column_steps,
    .write = write<MeshFormat::kPly>,
};

}  // namespace terravox::exports
