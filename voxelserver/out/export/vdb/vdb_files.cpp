#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <optional>

#include "common/thread/in_order.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/voxel/colour.hpp"
#include "voxelserver/out/export/core/columns.hpp"
#include "voxelserver/out/export/shape/placing.hpp"
#include "voxelserver/out/export/vdb/vdb.hpp"

namespace terravox::exports {
namespace {

constexpr std::int32_t kNodeEdge = 128;  // of the nodes above leaves
constexpr int kLeafEdge = 8;

template <class Tree>
std::uint64_t measure_leaf_bytes(const Tree& tree) {
    using Leaf = typename Tree::LeafNodeType;
    return tree.leafCount() * (sizeof(Leaf) + Leaf::SIZE * sizeof(typename Tree::ValueType));
}

/// The trees of one column of boxes, or of many.
struct VdbTrees {
    openvdb::FloatTree::Ptr density = std::make_shared<openvdb::FloatTree>(0.f);
    openvdb::Int32Tree::Ptr material = std::make_shared<openvdb::Int32Tree>(0);
    openvdb::Vec3STree::Ptr colour = std::make_shared<openvdb::Vec3STree>(openvdb::Vec3s(0.f));
    std::uint64_t voxels = 0;
    std::uint64_t checksum = 0;  ///< of the boxes, in order

    /// Memory of the leaves, bytes. Nodes above them are few, and shared by many columns.
    [[nodiscard]] std::uint64_t leaf_bytes() const {
        return measure_leaf_bytes(*density) + measure_leaf_bytes(*material) +
               measure_leaf_bytes(*colour);
    }
    /// Moves everything out of another column; leaves it empty.
    void take(VdbTrees& other) {
        density->merge(*other.density);
        material->merge(*other.material);
        colour->merge(*other.colour);
        voxels += other.voxels;
        checksum = (checksum ^ other.checksum) * 0x9E37'79B9'7F4A'7C15ULL;
    }
};

/// Maps voxels of the world to voxels of a grid. Grids begin at a voxel whose coordinates are
/// multiples of 128, so that leaves of 8 voxels and nodes of 128 are aligned with boxes.
class VdbFrame {
public:
    VdbFrame(const Job& job, UpAxis up)
        : m_up(up), m_origin(make_origin(job.part)), m_voxel_m(job.voxel_m()) {
        for (std::size_t a = 0; a < 3; ++a)
            m_base[a] = voxel::floor_div(m_origin[a], kNodeEdge) * kNodeEdge;
    }
    /// The grid's coordinates of a voxel of the world.
    [[nodiscard]] openvdb::Coord coord(std::int32_t x, std::int32_t y,
                                       std::int32_t z) const noexcept {
        const std::int32_t i = x - m_base[0];
        const std::int32_t j = y - m_base[1];
        const std::int32_t k = z - m_base[2];
        if (m_up == UpAxis::kY)
            return {i, j, k};
        return {i, -1 - k, j};
    }
    /// Metres from the origin of the part, a voxel's value at its middle.
    [[nodiscard]] openvdb::math::Transform::Ptr transform() const {
        // The middle of the world's voxel (x, y, z) lies at (x + 0.5 - origin) * voxel_m.
        const auto shift = [&](std::size_t a) {
            return (m_base[a] - m_origin[a] + 0.5) * m_voxel_m;
        };
        // North: -(z + 0.5 - origin), where the grid's coordinate is -1 - (z - base).
        const double north = (m_origin[2] - m_base[2] + 0.5) * m_voxel_m;
        auto out = openvdb::math::Transform::createLinearTransform(m_voxel_m);
        out->postTranslate(m_up == UpAxis::kY ? openvdb::Vec3d(shift(0), shift(1), shift(2))
                                              : openvdb::Vec3d(shift(0), north, shift(1)));
        return out;
    }
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

/// Fills trees with the boxes of one column.
class Filler {
public:
    Filler(Job& job, const VdbFrame& frame, VdbTrees& to)
        : m_job(job),
          m_frame(frame),
          m_to(to),
          m_density(*to.density),
          m_material(*to.material),
          m_colour(*to.colour) {}

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
    void seen(std::int32_t x, std::int32_t y, std::int32_t z, const voxel::VoxelAttr& attr) {
        if (!m_job.part.holds(x, y, z))
            return;
        const auto at = m_frame.coord(x, y, z);
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
                        const auto at = m_frame.coord(x0 + x, y0 + y, z0 + z);
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
                    const auto at = m_frame.coord(x, y, z);
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

/// Thread-safe.
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
    openvdb::tools::prune(*out.density, 0.f, false);
    openvdb::tools::prune(*out.material, 0, false);
    return out;
}

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

/// Writes the trees as one file, whole or not at all.
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
        grid->setTransform(frame.transform());
        for (const auto& [key, value] : facts)
            grid->insertMeta(key, openvdb::StringMetadata(value));
        grids.push_back(grid);
        return grid;
    };
    add(made.density, "density")->setGridClass(openvdb::GRID_FOG_VOLUME);
    add(made.material, "material");
    add(made.colour, "Cd");

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

// Memory of a column in grids, rounded up: 2 MiB in a wooded town. Where that is too little, blocks
// are halved.
constexpr std::uint64_t kColumnBytes = std::uint64_t{3} << 20;
// While a column is made, the upper nodes of its own trees count, too.
constexpr std::uint64_t kBytesOfThread = std::uint64_t{16} << 20;

/// Writes blocks of columns as files.
class Blocks {
public:
    Blocks(Job& job, const VdbOptions& options)
        : m_job(job), m_frame(job, options.up), m_range(job.part.boxes()) {
        m_whole = to_block(m_range);
        const auto most = static_cast<int>(
            std::clamp<std::uint64_t>(job.memory_bytes / 4 / kBytesOfThread, 1, 1024));
        m_threads = std::min(thread::thread_count(job.threads), most);
    }

    void write_all() {
        // All columns, or squares as large as the memory suffices for.
        const std::uint64_t fit = m_job.memory_bytes / kColumnBytes;
        const auto width = static_cast<std::uint64_t>(m_whole.max_bx - m_whole.min_bx);
        const auto depth = static_cast<std::uint64_t>(m_whole.max_bz - m_whole.min_bz);
        const bool all_fit = width * depth <= fit;
        std::uint64_t edge = all_fit ? std::max(width, depth) : 1;
        while (!all_fit && (edge + 1) * (edge + 1) <= fit)
            ++edge;
        for (const ColumnBlock& block : m_job.columns(edge).squares())
            write(block);
        if (m_files == 0)
            fail_for_nothing(m_job);
    }

private:
    void write(const ColumnBlock& block) {
        const std::int32_t width = block.max_bx - block.min_bx;
        const std::int32_t depth = block.max_bz - block.min_bz;
        if (const auto trees = make(block, width > 1 || depth > 1)) {
            if (trees->voxels != 0) {
                write_vdb_file(m_job, m_frame, *trees, to_name(block));
                ++m_files;
            }
            m_job.count_voxels(trees->voxels);
            m_job.meter.add(static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(depth));
            return;
        }
        ColumnBlock one = block;
        ColumnBlock other = block;
        if (width >= depth)
            one.max_bx = other.min_bx = block.min_bx + width / 2;
        else
            one.max_bz = other.min_bz = block.min_bz + depth / 2;
        write(one);
        write(other);
    }

    /// @return nullopt when the memory does not suffice, and the block may be divided
    [[nodiscard]] std::optional<VdbTrees> make(const ColumnBlock& block, bool may_fail) {
        const Columns columns(block, 8,
                              [this](const ColumnBlock& part) { return m_job.may_hold(part); });
        VdbTrees all;
        std::uint64_t bytes = 0;
        std::atomic<bool> too_much{false};
        thread::in_order(
            columns.count(), m_threads,
            [&](std::size_t i) {
                const auto at = columns.at(i);
                return too_much ? VdbTrees{} : make_vdb_column(m_job, m_frame, at.bx, at.bz);
            },
            [&](std::size_t, VdbTrees made) {
                if (too_much)
                    return;
                bytes += made.leaf_bytes();
                if (may_fail && bytes > m_job.memory_bytes)
                    too_much = true;
                else
                    all.take(made);
            });
        if (too_much)
            return std::nullopt;
        return all;
    }

    [[nodiscard]] std::filesystem::path to_name(const ColumnBlock& block) const {
        if (block == m_whole)
            return m_job.out;
        const std::string number = "_" + std::to_string(block.min_bx - m_whole.min_bx) + "_" +
                                   std::to_string(block.min_bz - m_whole.min_bz);
        auto out = m_job.out;
        out.replace_filename(m_job.out.stem().string() + number + m_job.out.extension().string());
        return out;
    }

    Job& m_job;
    const VdbFrame m_frame;
    const voxel::BoxRange m_range;
    ColumnBlock m_whole;
    int m_threads = 1;
    std::size_t m_files = 0;
};

}  // namespace

void write_vdb_files(Job& job, const VdbOptions& options) {
    util::check_writable(job.out);
    openvdb::initialize();
    Blocks(job, options).write_all();
}

}  // namespace terravox::exports
