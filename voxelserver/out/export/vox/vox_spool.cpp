#include "voxelserver/out/export/vox/vox_spool.hpp"

#include <algorithm>

#include "common/thread/in_order.hpp"
#include "voxelserver/out/export/shape/each_voxel.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {
namespace {

// A model is at most 256 wide, and a box as high as that.
constexpr std::size_t kModelEdge = 256 / voxel::kBoxSizeX;

}  // namespace

VoxSpool::VoxSpool(Job& job, VoxPalette& palette, std::uint64_t max_voxels,
                   const std::function<void()>& fail_too_many)
    : m_file(ByteFile::spool_for(job.out)) {
    const Columns columns = job.columns(kModelEdge);
    std::size_t square = 0;
    thread::in_order(
        columns.count(), job.threads,
        [&](std::size_t i) { return make_column(job, columns.at(i)); },
        [&](std::size_t i, const std::vector<MadeBox>& made) {
            if (const std::size_t now = columns.at(i).square; now != square) {
                end_square();
                square = now;
            }
            for (const MadeBox& m : made) {
                SpooledBox box = m.box;
                box.first = m_voxels;
                box.count = m.voxels.size();
                m_voxels += box.count;
                if (m_voxels > max_voxels)
                    fail_too_many();
                m_file.put(std::as_bytes(std::span(m.voxels)));
                for (const SpooledVoxel& v : m.voxels)
                    palette.count(v.material, v.colour, v.own);
                m_square[m.by].boxes.push_back(box);
                job.count_voxels(box.count);
            }
            job.meter.add();
        });
    end_square();
}

std::vector<VoxSpool::MadeBox> VoxSpool::make_column(Job& job, const Columns::At& at) {
    std::vector<MadeBox> out;
    const auto origin = origin_of(job.part);
    const voxel::ColumnExtent extent = job.column(at.bx, at.bz);
    for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by) {
        const auto box = job.box(at.bx, by, at.bz);
        if (!box)
            continue;
        const std::int32_t x0 = at.bx * voxel::kBoxSizeX;
        const std::int32_t y0 = by * voxel::kBoxSizeY;
        const std::int32_t z0 = at.bz * voxel::kBoxSizeZ;
        MadeBox made;
        made.by = by;
        // North is up in the file: its y falls as z rises.
        made.box.low = {x0 - origin[0], origin[2] - z0 - voxel::kBoxSizeZ, y0 - origin[1]};
        made.box.min = {255, 255, 255};
        each_voxel(
            *box,
            [&](int x, int y, int z, const voxel::VoxelAttr& attr) {
                if (!job.part.holds(x0 + x, y0 + y, z0 + z))
                    return;
                const std::array<std::uint8_t, 3> p = {
                    static_cast<std::uint8_t>(x),
                    static_cast<std::uint8_t>(voxel::kBoxSizeZ - 1 - z),
                    static_cast<std::uint8_t>(y)};
                for (std::size_t a = 0; a < 3; ++a) {
                    made.box.min[a] = std::min(made.box.min[a], p[a]);
                    made.box.max[a] = std::max(made.box.max[a], p[a]);
                }
                made.voxels.push_back({p[0], p[1], p[2], attr.material, job.colour_of(attr),
                                       attr.has_colour() && job.colours == Colours::kTrue});
            },
            [](int, int, int, int) {});
        if (!made.voxels.empty())
            out.push_back(std::move(made));
    }
    return out;
}

void VoxSpool::end_square() {
    for (auto& [by, model] : m_square) {
        std::array<std::int32_t, 3> min{};
        std::array<std::int32_t, 3> max{};
        for (std::size_t i = 0; i < model.boxes.size(); ++i) {
            const SpooledBox& box = model.boxes[i];
            model.voxels += box.count;
            for (std::size_t a = 0; a < 3; ++a) {
                const std::int32_t lo = box.low[a] + box.min[a];
                const std::int32_t hi = box.low[a] + box.max[a];
                min[a] = i == 0 ? lo : std::min(min[a], lo);
                max[a] = i == 0 ? hi : std::max(max[a], hi);
            }
        }
        model.min = min;
        for (std::size_t a = 0; a < 3; ++a)
            model.size[a] = max[a] - min[a] + 1;
        m_models.push_back(std::move(model));
    }
    m_square.clear();
}

void VoxSpool::each(const SpooledBox& box, const std::function<void(const SpooledVoxel&)>& use) {
    std::vector<SpooledVoxel> piece(1 << 14);
    for (std::uint64_t done = 0; done < box.count; done += piece.size()) {
        const auto part = std::span(piece).first(
            static_cast<std::size_t>(std::min<std::uint64_t>(piece.size(), box.count - done)));
        m_file.read((box.first + done) * sizeof(SpooledVoxel), std::as_writable_bytes(part));
        for (const SpooledVoxel& v : part)
            use(v);
    }
}

}  // namespace terravox::exports
