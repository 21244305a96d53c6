#include "voxelserver/serve/map/column_top.hpp"

#include <algorithm>
#include <bit>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/linear_light.hpp"

namespace terravox::map {
namespace {

using voxel::Box;
using voxel::TreeCell;
using voxel::VoxelAttr;

voxel::Rgb8 mixed(voxel::Rgb8 plain, voxel::Rgb8 shown, int shown_percent) {
    const auto share = static_cast<std::uint32_t>(std::clamp(shown_percent, 0, 100));
    const auto channel = [&](std::uint8_t a, std::uint8_t b) {
        return util::to_srgb(
            (util::to_linear(a) * (100 - share) + util::to_linear(b) * share + 50) / 100);
    };
    return {channel(plain.r, shown.r), channel(plain.g, shown.g), channel(plain.b, shown.b)};
}

/// One layer of a cell's mask as 16 adjacent columns, bit = x + 4 z.
constexpr std::uint32_t to_layer(std::uint64_t mask, int layer) {
    return static_cast<std::uint32_t>(mask >> (16 * layer)) & 0xffffU;
}

/// Searches the boxes from the top down, only in columns where nothing was found so far.
class Looker {
public:
    Looker(const TopColours& colours, BoxTop& out) : m_colours(colours), m_out(out) {
        m_open.fill(0xffff);
    }

    void look_into(const Box& box) {
        for (int root = Box::kRootCount - 1; root >= 0 && m_left > 0; --root)
            look_into_root(box, box.cells()[static_cast<std::size_t>(root)],
                           box.key().by * voxel::kBoxSizeY + root * 64);
    }
    [[nodiscard]] bool all_met() const { return m_left == 0; }
    [[nodiscard]] bool none_met() const { return m_left == static_cast<int>(m_out.columns.size()); }

private:
    static constexpr std::size_t brick_index(int bx, int bz) {
        return static_cast<std::size_t>(bz * 16 + bx);
    }

    void look_into_root(const Box& box, const TreeCell& root, std::int32_t y) {
        for (int layer = 3; layer >= 0; --layer)
            for (std::uint32_t left = to_layer(root.mask, layer); left != 0; left &= left - 1) {
                const int place = std::countr_zero(left);
                const int bit = layer * 16 + place;
                const int bx = (place & 3) * 4, bz = (place >> 2) * 4;  // in bricks
                if ((root.detail >> bit & 1) != 0)
                    look_into_middle(box, box.cells()[root.compute_index(bit)], bx, bz,
                                     y + layer * 16);
                else
                    for (int i = 0; i < 16; ++i)
                        meet(bx + (i & 3), bz + (i >> 2), 0xffff, y + layer * 16 + 15);
            }
    }

    void look_into_middle(const Box& box, const TreeCell& middle, int bx0, int bz0,
                          std::int32_t y) {
        for (int layer = 3; layer >= 0; --layer)
            for (std::uint32_t left = to_layer(middle.mask, layer); left != 0; left &= left - 1) {
                const int place = std::countr_zero(left);
                const int bit = layer * 16 + place;
                const int bx = bx0 + (place & 3);
                const int bz = bz0 + (place >> 2);
                if (m_open[brick_index(bx, bz)] == 0)
                    continue;
                if ((middle.detail >> bit & 1) != 0)
                    look_into_brick(box, box.cells()[middle.compute_index(bit)], bx, bz,
                                    y + layer * 4);
                else
                    meet(bx, bz, 0xffff, y + layer * 4 + 3);
            }
    }

    void look_into_brick(const Box& box, const TreeCell& brick, int bx, int bz, std::int32_t y) {
        std::uint16_t& open = m_open[brick_index(bx, bz)];
        for (int layer = 3; layer >= 0 && open != 0; --layer) {
            const std::uint32_t met = to_layer(brick.mask, layer) & open;
            const std::uint32_t detailed = met & to_layer(brick.detail, layer);
            for (std::uint32_t left = detailed; left != 0; left &= left - 1) {
                const int place = std::countr_zero(left);
                set(bx * 4 + (place & 3), bz * 4 + (place >> 2), y + layer,
                    box.attrs()[brick.compute_index(layer * 16 + place)]);
            }
            open = static_cast<std::uint16_t>(open & ~detailed);
            meet(bx, bz, met & ~detailed, y + layer);
        }
    }

    /// Records hidden rock, whose attributes are unknown.
    void meet(int bx, int bz, std::uint32_t columns, std::int32_t y) {
        std::uint16_t& open = m_open[brick_index(bx, bz)];
        for (std::uint32_t left = columns & open; left != 0; left &= left - 1) {
            const int place = std::countr_zero(left);
            set(bx * 4 + (place & 3), bz * 4 + (place >> 2), y, VoxelAttr{});
        }
        open = static_cast<std::uint16_t>(open & ~columns);
    }

    void set(int x, int z, std::int32_t y, const VoxelAttr& attr) {
        voxel::Rgb8 colour = m_colours.palette.of(attr.material).colour;
        if (attr.has_colour())
            colour = mixed(colour, attr.colour,
                           attr.material == voxel::Material::kWater ? m_colours.true_percent_water
                                                                    : m_colours.true_percent);
        // A solid voxel whose material is air must still be visible.
        const auto material =
            attr.material == voxel::Material::kAir ? voxel::Material::kUnknown : attr.material;
        m_out.columns[static_cast<std::size_t>(z * voxel::kBoxSizeX + x)] = {y, colour, material};
        --m_left;
    }

    const TopColours& m_colours;
    BoxTop& m_out;
    /// For each of 16 x 16 bricks: columns in which nothing was found so far, bit = x + 4 z.
    std::array<std::uint16_t, 256> m_open{};
    int m_left = voxel::kBoxSizeX * voxel::kBoxSizeZ;
};

}  // namespace

std::shared_ptr<const BoxTop> make_top(std::span<const std::shared_ptr<const Box>> boxes,
                                       const TopColours& colours) {
    std::vector<const Box*> order;
    for (const auto& box : boxes)
        if (box)
            order.push_back(box.get());
    if (order.empty())
        return nullptr;
    std::ranges::sort(order, [](const Box* a, const Box* b) { return a->key().by > b->key().by; });
    for (const Box* box : order)
        if (box->key().level != 0 || box->key().bx != order[0]->key().bx ||
            box->key().bz != order[0]->key().bz)
            throw util::Error("look at a box column from above: box " + to_string(box->key()) +
                              "; allowed: level 0 and the column of " + to_string(order[0]->key()));

    auto out = std::make_shared<BoxTop>();
    Looker looker(colours, *out);
    for (const Box* box : order) {
        if (looker.all_met())
            break;
        looker.look_into(*box);
    }
    return looker.none_met() ? nullptr : out;
}

}  // namespace terravox::map
