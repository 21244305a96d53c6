#include "voxelserver/out/export/anvil/box_column.hpp"

#include <algorithm>
#include <optional>

namespace terravox::exports::anvil {
namespace {

/// One past the highest voxel of a column of the part.
std::optional<std::int32_t> surface(Job& job, std::int32_t x, std::int32_t z) {
    const std::int32_t bx = voxel::floor_div(x, voxel::kBoxSizeX);
    const std::int32_t bz = voxel::floor_div(z, voxel::kBoxSizeZ);
    const voxel::ColumnExtent extent = job.column(bx, bz);
    for (std::int32_t by = extent.by_end; by-- > extent.by_begin;) {
        const auto box = job.box(bx, by, bz);
        if (box == nullptr)
            continue;
        const std::int32_t floor = by * voxel::kBoxSizeY;
        for (std::int32_t y = std::min(job.part.bounds.max[1], floor + box->top());
             y-- > std::max(job.part.bounds.min[1], floor);)
            if (box->solid(x - bx * voxel::kBoxSizeX, y - floor, z - bz * voxel::kBoxSizeZ))
                return y + 1;
    }
    return std::nullopt;
}

}  // namespace

BoxColumn::BoxColumn(Job& job, const Place& place, std::int32_t bx, std::int32_t bz)
    : m_place(place), m_bx(bx), m_bz(bz), m_sections(static_cast<std::size_t>(place.sections())) {
    const voxel::ColumnExtent extent = job.column(bx, bz);
    m_first_by = extent.by_begin;
    for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by)
        m_boxes.push_back(job.box(bx, by, bz));
}

bool BoxColumn::empty() const noexcept {
    return std::all_of(m_boxes.begin(), m_boxes.end(),
                       [](const auto& box) { return box == nullptr; });
}

std::vector<Section>& BoxColumn::sections(int cx, int cz, SectionReader& reader) {
    constexpr std::int32_t kSectionsInBox = voxel::kBoxSizeY / kSectionSize;
    for (std::int32_t i = 0; i < m_place.sections(); ++i) {
        // Which 16 layers of the world's voxels these are.
        const std::int32_t layer = m_place.first_section() + i + m_place.offset[1] / kSectionSize;
        const std::int32_t by = voxel::floor_div(layer, kSectionsInBox);
        const std::int32_t place = by - m_first_by;
        const bool here = place >= 0 && place < static_cast<std::int32_t>(m_boxes.size());
        const voxel::Box* const box =
            here ? m_boxes[static_cast<std::size_t>(place)].get() : nullptr;
        reader.read(box, cx, layer - by * kSectionsInBox, cz,
                    m_sections[static_cast<std::size_t>(i)]);
    }
    return m_sections;
}

std::array<std::int32_t, 3> spawn_of(Job& job, const Place& place) {
    const auto& bounds = job.part.bounds;
    const auto middle = [&](std::size_t axis) {
        return static_cast<std::int32_t>((std::int64_t{bounds.min[axis]} + bounds.max[axis]) / 2);
    };
    const std::int32_t x = middle(0);
    const std::int32_t z = middle(2);
    const auto block = [&](std::int32_t at_x, std::int32_t y, std::int32_t at_z) {
        return std::array<std::int32_t, 3>{at_x - place.offset[0], y - place.offset[1],
                                           at_z - place.offset[2]};
    };
    // Eight directions, each step half as long again as the one before: some 300 columns for the
    // widest world.
    for (std::int64_t step = 0; step < std::int64_t{1} << 31; step = step + step / 2 + 8)
        for (int way = 0; way < (step == 0 ? 1 : 8); ++way) {
            constexpr std::array<int, 8> kX = {1, 0, -1, 0, 1, -1, -1, 1};
            constexpr std::array<int, 8> kZ = {0, 1, 0, -1, 1, 1, -1, -1};
            const std::int64_t at_x = x + step * kX[static_cast<std::size_t>(way)];
            const std::int64_t at_z = z + step * kZ[static_cast<std::size_t>(way)];
            if (at_x < bounds.min[0] || at_x >= bounds.max[0] || at_z < bounds.min[2] ||
                at_z >= bounds.max[2])
                continue;
            const auto sx = static_cast<std::int32_t>(at_x);
            const auto sz = static_cast<std::int32_t>(at_z);
            if (const auto y = surface(job, sx, sz))
                return block(sx, *y, sz);
        }
    return block(x, bounds.max[1], z);
}

}  // namespace terravox::exports::anvil
