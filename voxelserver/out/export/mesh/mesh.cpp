#include "voxelserver/out/export/mesh/mesh.hpp"

#include <algorithm>
#include <bit>

#include "common/thread/in_order.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "voxelserver/out/export/core/columns.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {
namespace {

/// Numbers the corners of quads of one box so that equal ones have one number. Open addressing:
/// numbers depend only on the order of calls.
class CornerNumbers {
public:
    explicit CornerNumbers(std::size_t most)
        : m_slots(std::bit_ceil(most * 2 + 2), Slot{kFree, 0}) {}
    /// @param key of at most 63 bits
    /// @param next the number it gets when it is new
    [[nodiscard]] std::uint32_t number(std::uint64_t key, std::uint32_t next) noexcept {
        const std::size_t mask = m_slots.size() - 1;
        // Ref: Knuth, "The Art of Computer Programming", volume 3, section 6.4: multiplicative
        // hashing.
        for (std::size_t i = (key * 0x9E37'79B9'7F4A'7C15ULL >> 20) & mask;; i = (i + 1) & mask) {
            if (m_slots[i].key == key)
                return m_slots[i].number;
            if (m_slots[i].key != kFree)
                continue;
            m_slots[i] = {key, next};
            return next;
        }
    }

private:
    static constexpr std::uint64_t kFree = ~std::uint64_t{0};
    struct Slot {
        std::uint64_t key;
        std::uint32_t number;
    };
    std::vector<Slot> m_slots;
};

// Adds quads of one chunk. `low`: the chunk's lowest corner, voxels from the origin.
void add_quads(const std::vector<Quad>& quads, const std::array<std::int32_t, 3>& low,
               std::map<voxel::Material, IndexedQuads>& parts) {
    CornerNumbers numbers(quads.size() * 4);
    IndexedQuads* part = nullptr;
    voxel::Material current = voxel::Material::kAir;
    for (const Quad& quad : quads) {
        if (!part || to_material(quad.attributes) != current) {
            current = to_material(quad.attributes);
            part = &parts[current];
        }
        std::array<std::uint32_t, 4> indices{};
        const auto corners = list_corners(quad);
        for (std::size_t i = 0; i < 4; ++i) {
            const auto& c = corners[i];
            const std::uint64_t place =
                static_cast<std::uint64_t>(c[0] | c[1] << 7 | c[2] << 14);  // each in [0, 64]
            const auto next = static_cast<std::uint32_t>(part->vertices.size());
            indices[i] = numbers.number(place << 32 | quad.attributes, next);
            if (indices[i] == next)
                part->vertices.push_back(
                    {{low[0] + c[0], low[1] + c[1], low[2] + c[2]}, quad.attributes});
        }
        part->quads.push_back(indices);
    }
}

}  // namespace

ColumnMesher::ColumnMesher(Job& job, const MeshOptions& options)
    : m_job(job),
      m_merge(options.merge),
      m_range(job.part.boxes()),
      m_origin(make_origin(job.part)),
      m_boxes(job.memory_bytes / 4) {
    for (int i = 0; i < 256; ++i) {
        const int top = options.colour_steps - 1;
        m_step_of[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(
            options.colour_steps == 0 ? i : ((i * top + 127) / 255 * 255 + top / 2) / top);
    }
}

ColumnMesher::BoxPtr ColumnMesher::box(std::int32_t bx, std::int32_t by, std::int32_t bz) {
    const voxel::BoxKey key{m_job.part.level, bx, by, bz};
    if (!m_range.contains(key))
        return nullptr;
    return m_boxes.get(
        key, [&] { return m_job.box(bx, by, bz); },
        [](const BoxPtr& b) { return b ? b->memory_bytes() : std::size_t{0}; });
}

Neighbourhood ColumnMesher::around(std::int32_t bx, std::int32_t by, std::int32_t bz) {
    Neighbourhood out;
    out.self = box(bx, by, bz);
    if (!out.self)
        return out;
    out.west = box(bx - 1, by, bz);
    out.east = box(bx + 1, by, bz);
    out.below = box(bx, by - 1, bz);
    out.above = box(bx, by + 1, bz);
    out.north = box(bx, by, bz - 1);
    out.south = box(bx, by, bz + 1);
    return out;
}

FaceAttributes ColumnMesher::attributes_of_voxel(const voxel::VoxelAttr& attr) const noexcept {
    const voxel::Rgb8 c = m_job.to_colour(attr);
    return to_attributes(attr.material, {m_step_of[c.r], m_step_of[c.g], m_step_of[c.b]});
}

ColumnMesh ColumnMesher::make(std::int32_t bx, std::int32_t bz) {
    ColumnMesh out;
    Chunk chunk;
    FaceFinder finder;
    std::vector<Quad> quads;
    const Chunk::ToAttributes attributes = [this](const voxel::VoxelAttr& attr) {
        return attributes_of_voxel(attr);
    };
    const voxel::ColumnExtent extent = m_job.column(bx, bz);
    for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by) {
        const Neighbourhood boxes = around(bx, by, bz);
        if (!boxes.self)
            continue;
        const std::array<std::int64_t, 3> low = {std::int64_t{bx} * voxel::kBoxSizeX,
                                                 std::int64_t{by} * voxel::kBoxSizeY,
                                                 std::int64_t{bz} * voxel::kBoxSizeZ};
        voxel::VoxelBounds bounds;
        std::array<std::int32_t, 3> from_origin{};
        for (std::size_t a = 0; a < 3; ++a) {
            constexpr std::int64_t kFar = std::int64_t{1} << 20;
            bounds.min[a] = static_cast<std::int32_t>(
                std::clamp(m_job.part.bounds.min[a] - low[a], -kFar, kFar));
            bounds.max[a] = static_cast<std::int32_t>(
                std::clamp(m_job.part.bounds.max[a] - low[a], -kFar, kFar));
            from_origin[a] = static_cast<std::int32_t>(low[a] - m_origin[a]);
        }
        for (int storey = 0; storey < voxel::Box::kRootCount; ++storey) {
            if (!chunk.fill(boxes, storey, bounds, attributes))
                continue;
            out.seen_voxels += chunk.seen();
            quads.clear();
            finder.find(chunk, m_merge, quads);
            add_quads(quads,
                      {from_origin[0], from_origin[1] + storey * Chunk::kEdge, from_origin[2]},
                      out.parts);
        }
    }
    return out;
}

namespace {

// Columns in squares: with a few boxes of each in memory, only those along the edges of a square
// are requested twice.
constexpr std::size_t kSquareEdge = 8;
// One thread holds two columns at once, of some 16 MiB each where it is steep and wooded; half of
// the memory is for that.
constexpr std::size_t kBytesOfThread = std::size_t{32} << 20;

}  // namespace

void write_mesh(Job& job, MeshFormat format, const MeshOptions& options) {
    if (options.colour_steps != 0 && (options.colour_steps < 2 || options.colour_steps > 255))
        throw util::UsageError("write " + job.out.string() +
                               ": colour steps = " + std::to_string(options.colour_steps) +
                               "; allowed: 2 to 255, or 0 for all");
    util::AtomicFile file(job.out);
    const auto writer =
        format == MeshFormat::kGlb ? make_glb_writer(job, options) : make_ply_writer(job);
    ColumnMesher mesher(job, options);
    const Columns columns = job.columns(kSquareEdge);
    const auto max_threads = static_cast<int>(std::max<std::size_t>(
        1, std::min<std::size_t>(1024, job.memory_bytes / 2 / kBytesOfThread)));
    thread::in_order(
        columns.count(), std::min(thread::thread_count(job.threads), max_threads),
        [&](std::size_t i) {
            const auto at = columns.at(i);
            return mesher.make(at.bx, at.bz);
        },
        [&](std::size_t, const ColumnMesh& mesh) {
            writer->add(mesh);
            job.count_voxels(mesh.seen_voxels);
            job.meter.add();
        });
    if (writer->empty())
        fail_for_nothing(job);
    ByteFile out(file.temporary_path(), job.out.string());
    writer->finish(out);
    out.close();
    finish_file(job, file);
}

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
