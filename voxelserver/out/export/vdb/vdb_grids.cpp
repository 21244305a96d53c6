#include "voxelserver/out/export/vdb/vdb_grids.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include <cstdio>
#include <fstream>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/voxel/colour.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {

struct VdbTrees::Trees {
    openvdb::FloatTree::Ptr density = std::make_shared<openvdb::FloatTree>(0.f);
    openvdb::Int32Tree::Ptr material = std::make_shared<openvdb::Int32Tree>(0);
    openvdb::Vec3STree::Ptr colour = std::make_shared<openvdb::Vec3STree>(openvdb::Vec3s(0.f));
};

namespace {

constexpr std::int32_t kNodeEdge = 128;  // of the nodes above leaves
constexpr int kLeafEdge = 8;

/// Fills trees with the boxes of one column.
class Filler {
public:
    Filler(Job& job, const VdbFrame& frame, VdbTrees& to)
        : m_job(job),
          m_frame(frame),
          m_to(to),
          m_density(*to.trees->density),
          m_material(*to.trees->material),
          m_colour(*to.trees->colour) {}

    void add(const voxel::Box& box) {
        const auto& key = box.key();
        const std::int32_t x0 = key.bx * voxel::kBoxSizeX;
        const std::int32_t y0 = key.by * voxel::kBoxSizeY;
        const std::int32_t z0 = key.bz * voxel::kBoxSizeZ;
        each_voxel(
            box,
            [&](int x, int y, int z, const voxel::VoxelAttr& attr) {
                seen(x0 + x, y0 + y, z0 + z, attr);
            },
            [&](int x, int y, int z, int edge) { hidden(x0 + x, y0 + y, z0 + z, edge); });
        m_to.checksum = (m_to.checksum ^ box.checksum()) * 0x9E37'79B9'7F4A'7C15ULL;
    }

private:
    [[nodiscard]] openvdb::Coord coord(std::int32_t x, std::int32_t y,
                                       std::int32_t z) const noexcept {
        const auto [i, j, k] = m_frame.coord(x, y, z);
        return {i, j, k};
    }

    void seen(std::int32_t x, std::int32_t y, std::int32_t z, const voxel::VoxelAttr& attr) {
        if (!m_job.part.holds(x, y, z))
            return;
        const auto at = coord(x, y, z);
        const voxel::Rgb8 c = m_job.to_colour(attr);
        m_density.setValueOn(at, 1.f);
        m_material.setValueOn(at, static_cast<std::int32_t>(attr.material));
        m_colour.setValueOn(at, {voxel::srgb_to_linear(c.r), voxel::srgb_to_linear(c.g),
                                 voxel::srgb_to_linear(c.b)});
        ++m_to.voxels;
    }

    void hidden(std::int32_t x0, std::int32_t y0, std::int32_t z0, int edge) {
        const auto& part = m_job.part;
        if (edge >= kLeafEdge && part.holds(x0, y0, z0) &&
            part.holds(x0 + edge - 1, y0 + edge - 1, z0 + edge - 1)) {
            for (int y = 0; y < edge; y += kLeafEdge)
                for (int z = 0; z < edge; z += kLeafEdge)
                    for (int x = 0; x < edge; x += kLeafEdge) {
                        // Level 1: a tile as large as a leaf. Any voxel in it identifies it.
                        const auto at = coord(x0 + x, y0 + y, z0 + z);
                        m_density.addTile(1, at, 1.f, true);
                        m_material.addTile(1, at, kRock, true);
                    }
            m_to.voxels += static_cast<std::uint64_t>(edge) * static_cast<std::uint64_t>(edge) *
                           static_cast<std::uint64_t>(edge);
            return;
        }
        for (std::int32_t y = y0; y < y0 + edge; ++y)
            for (std::int32_t z = z0; z < z0 + edge; ++z)
                for (std::int32_t x = x0; x < x0 + edge; ++x) {
                    if (!part.holds(x, y, z))
                        continue;
                    const auto at = coord(x, y, z);
                    m_density.setValueOn(at, 1.f);
                    m_material.setValueOn(at, kRock);
                    ++m_to.voxels;
                }
    }

    static constexpr auto kRock = static_cast<std::int32_t>(voxel::Material::kRock);
    Job& m_job;
    const VdbFrame& m_frame;
    VdbTrees& m_to;
    openvdb::tree::ValueAccessor<openvdb::FloatTree> m_density;
    openvdb::tree::ValueAccessor<openvdb::Int32Tree> m_material;
    openvdb::tree::ValueAccessor<openvdb::Vec3STree> m_colour;
};

// OpenVDB gives each file a random name of 36 characters. Equal grids must give equal files, so the
// name is replaced by one derived from the content.
// Ref: OpenVDB, Archive::writeHeader: magic (8 bytes), version of the format (4), of the library
// (4 + 4), offsets follow (1), name.
void name_by_content(const std::filesystem::path& file, std::uint64_t a, std::uint64_t b) {
    constexpr std::size_t kAt = 21;
    constexpr std::size_t kDigits = 36;
    std::fstream io(file, std::ios::in | std::ios::out | std::ios::binary);
    char name[kDigits + 1] = {};
    io.seekg(kAt).read(name, kDigits);
    for (const std::size_t dash : {8u, 13u, 18u, 23u})
        if (!io || name[dash] != '-')
            throw util::Error("write " + file.string() +
                              ": the header of the file is not what this program knows");
    std::snprintf(name, sizeof name, "%08x-%04x-%04x-%04x-%012llx", static_cast<unsigned>(a >> 32),
                  static_cast<unsigned>(a >> 16 & 0xFFFF),
                  static_cast<unsigned>(0x8000 | (a & 0xFFF)),
                  static_cast<unsigned>(0x8000 | (b >> 48 & 0x3FFF)),
                  static_cast<unsigned long long>(b & 0xFFFF'FFFF'FFFFULL));
    io.seekp(kAt).write(name, kDigits);
    io.close();
    if (!io)
        throw util::Error("write " + file.string() + ": disk full, or cannot be written");
}

/// Writes what openvdb::io::File writes, to a stream of ours: openvdb does not check its own stream
/// for a full disk.
class Archive : public openvdb::io::Archive {
public:
    void write(std::ostream& out, const openvdb::GridCPtrVec& grids,
               const openvdb::MetaMap& about) const {
        openvdb::io::Archive::write(out, grids, true, about);
    }
};

template <class Tree>
std::uint64_t measure_leaf_bytes(const Tree& tree) {
    using Leaf = typename Tree::LeafNodeType;
    return tree.leafCount() * (sizeof(Leaf) + Leaf::SIZE * sizeof(typename Tree::ValueType));
}

/// Metres from the origin of the part, a voxel's value at its middle.
openvdb::math::Transform::Ptr make_transform(const VdbFrame& frame) {
    auto out = openvdb::math::Transform::createLinearTransform(frame.voxel_m());
    const auto [x, y, z] = frame.shift_m();
    out->postTranslate(openvdb::Vec3d(x, y, z));
    return out;
}

}  // namespace

void start_vdb() {
    openvdb::initialize();
}

VdbTrees::VdbTrees() : trees(std::make_unique<Trees>()) {}
VdbTrees::~VdbTrees() = default;
VdbTrees::VdbTrees(VdbTrees&&) noexcept = default;
VdbTrees& VdbTrees::operator=(VdbTrees&&) noexcept = default;

std::uint64_t VdbTrees::leaf_bytes() const {
    return measure_leaf_bytes(*trees->density) + measure_leaf_bytes(*trees->material) +
           measure_leaf_bytes(*trees->colour);
}

void VdbTrees::take(VdbTrees& other) {
    trees->density->merge(*other.trees->density);
    trees->material->merge(*other.trees->material);
    trees->colour->merge(*other.trees->colour);
    voxels += other.voxels;
    checksum = (checksum ^ other.checksum) * 0x9E37'79B9'7F4A'7C15ULL;
}

VdbFrame::VdbFrame(const Job& job, UpAxis up)
    : m_up(up), m_origin(make_origin(job.part)), m_voxel_m(job.voxel_m()) {
    for (std::size_t a = 0; a < 3; ++a)
        m_base[a] = voxel::floor_div(m_origin[a], kNodeEdge) * kNodeEdge;
}

std::array<double, 3> VdbFrame::shift_m() const noexcept {
    // The middle of the world's voxel (x, y, z) lies at (x + 0.5 - origin) * voxel_m.
    const auto shift = [&](std::size_t a) { return (m_base[a] - m_origin[a] + 0.5) * m_voxel_m; };
    // North: -(z + 0.5 - origin), where the grid's coordinate is -1 - (z - base).
    const double north = (m_origin[2] - m_base[2] + 0.5) * m_voxel_m;
    if (m_up == UpAxis::kY)
        return {shift(0), shift(1), shift(2)};
    return {shift(0), north, shift(1)};
}

VdbTrees make_vdb_column(Job& job, const VdbFrame& frame, std::int32_t bx, std::int32_t bz) {
    VdbTrees out;
    {
        Filler filler(job, frame, out);
        const voxel::ColumnExtent extent = job.column(bx, bz);
        for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by)
            if (const auto box = job.box(bx, by, bz))
                filler.add(*box);
    }
    // Leaves of one value become tiles.
    openvdb::tools::prune(*out.trees->density, 0.f, false);
    openvdb::tools::prune(*out.trees->material, 0, false);
    return out;
}

void write_vdb_file(Job& job, const VdbFrame& frame, const VdbTrees& made,
                    const std::filesystem::path& file) {
    const auto facts = collect_facts(job, frame.axes());
    openvdb::MetaMap about_file;
    about_file.insertMeta("creator", openvdb::StringMetadata("terravox"));
    for (const auto& [name, value] : facts)
        about_file.insertMeta(name, openvdb::StringMetadata(value));
    openvdb::GridCPtrVec grids;
    const auto add = [&](const auto& tree, const char* name) {
        using Grid = openvdb::Grid<std::decay_t<decltype(*tree)>>;
        auto grid = Grid::create(tree);
        grid->setName(name);
        grid->setTransform(make_transform(frame));
        for (const auto& [key, value] : facts)
            grid->insertMeta(key, openvdb::StringMetadata(value));
        grids.push_back(grid);
        return grid;
    };
    add(made.trees->density, "density")->setGridClass(openvdb::GRID_FOG_VOLUME);
    add(made.trees->material, "material");
    add(made.trees->colour, "Cd");

    util::AtomicFile target(file);
    try {
        std::ofstream out(target.temporary_path(), std::ios::binary);
        Archive().write(out, grids, about_file);
        out.close();
        if (!out)
            throw util::Error("write " + file.string() + ": disk full, or cannot be written");
    } catch (const openvdb::Exception& e) {
        throw util::Error("write " + file.string() + ": " + e.what());
    }
    name_by_content(target.temporary_path(), made.checksum, made.voxels * 0x9E37'79B9'7F4A'7C15ULL);
    finish_file(job, target);
}

}  // namespace terravox::exports
