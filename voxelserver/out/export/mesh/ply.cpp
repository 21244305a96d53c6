#include <limits>

#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "voxelserver/out/export/mesh/mesh.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {
namespace {

// As stored in the file: no gaps.
struct __attribute__((packed)) PlyVertex {
    float x;
    float y;
    float z;
    std::uint8_t r;
    std::uint8_t g;
    std::uint8_t b;
    std::uint8_t material;
};
struct __attribute__((packed)) PlyFace {
    std::uint8_t count;
    std::array<std::uint32_t, 4> vertices;
};
static_assert(sizeof(PlyVertex) == 16 && sizeof(PlyFace) == 17);

// Readers interpret an index as a signed number of 32 bits.
constexpr std::uint64_t kMaxVertices = std::numeric_limits<std::int32_t>::max();

/// Ref: Turk, "The PLY Polygon File Format", 1994.
class PlyWriter : public MeshWriter {
public:
    explicit PlyWriter(const Job& job)
        : m_job(job),
          m_vertices(ByteFile::spool_for(job.out)),
          m_faces(ByteFile::spool_for(job.out)) {}

    void add(const ColumnMesh& mesh) override {
        const double voxel_m = m_job.voxel_m();
        for (const auto& [material, part] : mesh.parts) {
            const auto first = static_cast<std::uint32_t>(m_vertex_count);
            m_vertex_count += part.vertices.size();
            m_face_count += part.quads.size();
            if (m_vertex_count > kMaxVertices)
                throw util::Error(
                    "write " + m_job.out.string() + ": more than " + std::to_string(kMaxVertices) +
                    " vertices, the most that readers of the format take; nothing was written");
            std::vector<PlyVertex> vertices;
            vertices.reserve(part.vertices.size());
            for (const MeshVertex& v : part.vertices) {
                const voxel::Rgb8 c = to_colour(v.attributes);
                // z up: x east, y north.
                vertices.push_back({static_cast<float>(v.at[0] * voxel_m),
                                    static_cast<float>(-v.at[2] * voxel_m),
                                    static_cast<float>(v.at[1] * voxel_m), c.r, c.g, c.b,
                                    static_cast<std::uint8_t>(material)});
            }
            std::vector<PlyFace> faces;
            faces.reserve(part.quads.size());
            for (const auto& q : part.quads)
                faces.push_back({4, {first + q[0], first + q[1], first + q[2], first + q[3]}});
            m_vertices.put(std::as_bytes(std::span(vertices)));
            m_faces.put(std::as_bytes(std::span(faces)));
        }
    }

    [[nodiscard]] bool empty() const noexcept override { return m_face_count == 0; }

    void finish(ByteFile& to) override {
        std::string head =
            std::string("ply\nformat binary_little_endian 1.0\ncomment made by terravox ") +
            kVersion + "\n";
        for (const auto& [name, value] : collect_facts(m_job, "x east, y north, z up; metres"))
            head += "comment " + name + ": " + value + "\n";
        head += "element vertex " + std::to_string(m_vertex_count) +
                "\nproperty float x\nproperty float y\nproperty float z\n" +
                "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar "
                "material\n" +
                "element face " + std::to_string(m_face_count) +
                "\nproperty list uchar int vertex_indices\nend_header\n";
        to.put(head);
        m_vertices.copy_to(to);
        m_faces.copy_to(to);
    }

private:
    const Job& m_job;
    ByteFile m_vertices;
    ByteFile m_faces;
    std::uint64_t m_vertex_count = 0;
    std::uint64_t m_face_count = 0;
};

}  // namespace

std::unique_ptr<MeshWriter> make_ply_writer(const Job& job) {
    return std::make_unique<PlyWriter>(job);
}

}  // namespace terravox::exports
