#include "voxelserver/out/export/anvil/section.hpp"

#include <algorithm>
#include <bit>
#include <optional>

#include "common/util/error.hpp"

namespace terravox::exports::anvil {
namespace {

constexpr std::int64_t kLowest = -2032, kEnd = 2032;  // limits of a dimension
constexpr std::int64_t kUsualLowest = -64;
constexpr std::int64_t kUsualEnd = 320;
// Above the highest voxel of a high world, to build and fly in.
constexpr std::int64_t kHeadroom = 64;
// The border of a world lies just beyond, with the centre at 0.
constexpr std::int64_t kFarthest = 29'999'000;

std::int64_t floor_to(std::int64_t value, std::int64_t step) noexcept {
    return (value >= 0 ? value / step : -((step - 1 - value) / step)) * step;
}
std::int64_t ceil_to(std::int64_t value, std::int64_t step) noexcept {
    return -floor_to(-value, step);
}

/// @return the least level at which a part of `size` voxels of `level` fits into `max_size`
int fitting_level(int level, std::int64_t size, std::int64_t max_size) noexcept {
    while (size > max_size) {
        size = (size + 1) / 2;
        ++level;
    }
    return level;
}

[[noreturn]] void refuse(const char* dimension, std::int64_t size, std::int64_t max_size,
                         int level) {
    throw util::UsageError("write a world for Minecraft: " + std::to_string(size) + " voxels " +
                           dimension + "; allowed: up to " + std::to_string(max_size) +
                           " blocks, that is --level " + std::to_string(level) +
                           " or coarser, or a part of it");
}

void place_heights(const Part& part, Place& place) {
    const std::int64_t low = floor_to(part.bounds.min[1], kSectionSize);
    const std::int64_t end = ceil_to(part.bounds.max[1], kSectionSize);
    const std::int64_t max_size = kEnd - kLowest;
    // Two sections fewer at a coarser level, where the lowest and highest voxel need not be aligned
    // to sections.
    if (end - low > max_size)
        refuse("high", std::int64_t{part.bounds.max[1]} - part.bounds.min[1], max_size,
               fitting_level(part.level, end - low, max_size - 2 * kSectionSize));
    if (low >= kUsualLowest && end <= kUsualEnd)
        return;
    if (end - low <= kUsualEnd - kUsualLowest) {
        place.offset[1] = static_cast<std::int32_t>(low - kUsualLowest);
        return;
    }
    const std::int64_t offset = low < kLowest || end > kEnd ? low - kLowest : 0;
    place.offset[1] = static_cast<std::int32_t>(offset);
    place.min_y = static_cast<std::int32_t>(low - offset);
    place.height =
        static_cast<std::int32_t>(std::min(end - offset + kHeadroom, kEnd) - place.min_y);
}

}  // namespace

Place find_place(const Part& part) {
    Place place;
    for (const std::size_t axis : {std::size_t{0}, std::size_t{2}}) {
        const std::int64_t low = part.bounds.min[axis];
        const std::int64_t end = part.bounds.max[axis];
        constexpr std::int64_t kWidest = 2 * (kFarthest - kRegionSize);
        if (end - low > kWidest)
            refuse("wide", end - low, kWidest, fitting_level(part.level, end - low, kWidest));
        place.offset[axis] =
            static_cast<std::int32_t>(floor_to((low + end) / 2 + kRegionSize / 2, kRegionSize));
    }
    place_heights(part, place);
    return place;
}

using voxel::Material;
using voxel::TreeCell;

BlockId SectionReader::to_block(const voxel::VoxelAttr& attr) {
    if (!m_true || !attr.has_colour())
        return m_blocks.plain(attr.material);
    if (attr.material != m_last_material || attr.colour != m_last_colour) {
        m_last_material = attr.material;
        m_last_colour = attr.colour;
        m_last = m_blocks.painted(attr.material, attr.colour);
    }
    return m_last;
}

void SectionReader::read(const voxel::Box* box, int cx, int cy, int cz, Section& out) {
    out.fill(0);
    if (box == nullptr)
        return;
    // A cell of the second level of a box's trees is 16 voxels wide: a section.
    const TreeCell& root = box->cells()[static_cast<std::size_t>(cy >> 2)];
    const int place = voxel::child_bit(cx, cy, cz);
    if ((root.mask >> place & 1) == 0)
        return;
    const BlockId rock = m_blocks.plain(Material::kRock);
    if ((root.detail >> place & 1) == 0) {
        out.fill(rock);
        cut(box->key(), cx, cy, cz, out);
        return;
    }
    const TreeCell& cell = box->cells()[root.compute_index(place)];
    out.uniform = false;
    out.blocks.fill(0);
    for (std::uint64_t bricks = cell.mask; bricks != 0; bricks &= bricks - 1) {
        const int bit = std::countr_zero(bricks);
        const int x = (bit & 3) * 4;
        const int z = (bit >> 2 & 3) * 4;
        const int y = (bit >> 4) * 4;
        const TreeCell* brick =
            (cell.detail >> bit & 1) != 0 ? &box->cells()[cell.compute_index(bit)] : nullptr;
        for (std::uint64_t left = brick != nullptr ? brick->mask : ~std::uint64_t{0}; left != 0;
             left &= left - 1) {
            const int v = std::countr_zero(left);
            const bool seen = brick != nullptr && (brick->detail >> v & 1) != 0;
            out.blocks[Section::index(x + (v & 3), y + (v >> 4), z + (v >> 2 & 3))] =
                seen ? to_block(box->attrs()[brick->compute_index(v)]) : rock;
        }
    }
    cut(box->key(), cx, cy, cz, out);
}

void SectionReader::cut(const voxel::BoxKey& key, int cx, int cy, int cz, Section& out) const {
    const std::int32_t x0 = key.bx * voxel::kBoxSizeX + cx * kSectionSize;
    const std::int32_t y0 = key.by * voxel::kBoxSizeY + cy * kSectionSize;
    const std::int32_t z0 = key.bz * voxel::kBoxSizeZ + cz * kSectionSize;
    constexpr int kLast = kSectionSize - 1;
    if (m_part.holds(x0, y0, z0) && m_part.holds(x0 + kLast, y0 + kLast, z0 + kLast))
        return;
    if (out.uniform) {
        out.blocks.fill(out.blocks[0]);
        out.uniform = false;
    }
    for (int y = 0; y < kSectionSize; ++y)
        for (int z = 0; z < kSectionSize; ++z)
            for (int x = 0; x < kSectionSize; ++x)
                if (!m_part.holds(x0 + x, y0 + y, z0 + z))
                    out.blocks[Section::index(x, y, z)] = 0;
}

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

std::array<std::int32_t, 3> find_spawn(Job& job, const Place& place) {
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
