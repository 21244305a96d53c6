#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox::test {

/// One material a voxel in 64 x 256 x 64, air all around: scenes of which levels are made.
class MaterialGrid {
public:
    void set(int x, int y, int z, voxel::Material m) { m_cells[index(x, y, z)] = m; }
    /// [x0, x1) and so on.
    void fill(std::array<int, 2> x, std::array<int, 2> y, std::array<int, 2> z, voxel::Material m) {
        for (int i = x[0]; i < x[1]; ++i)
            for (int j = y[0]; j < y[1]; ++j)
                for (int k = z[0]; k < z[1]; ++k)
                    set(i, j, k, m);
    }
    [[nodiscard]] voxel::Material at(int x, int y, int z) const { return m_cells[index(x, y, z)]; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> build() const {
        voxel::BoxBuilder builder;
        for (int x = 0; x < 64; ++x)
            for (int z = 0; z < 64; ++z)
                for (int y = 0; y < 256; ++y)
                    if (at(x, y, z) != voxel::Material::kAir)
                        builder.add(x, z, y, y + 1, !see_through(at(x, y, z)));
        return builder.build({0, 0, 0, 0}, [&](int x, int y, int z) {
            return voxel::VoxelAttr{at(x, y, z), 1, 0, 0, {}, 0};
        });
    }

private:
    static std::size_t index(int x, int y, int z) {
        return static_cast<std::size_t>((x * 64 + z) * 256 + y);
    }
    std::vector<voxel::Material> m_cells =
        std::vector<voxel::Material>(64 * 64 * 256, voxel::Material::kAir);
};

using FineBoxes = std::array<std::shared_ptr<const voxel::Box>, 8>;

inline FineBoxes alone(std::shared_ptr<const voxel::Box> box, std::size_t slot = 0) {
    FineBoxes children;
    children[slot] = std::move(box);
    return children;
}

/// Level n of a box that has only air around it: the 64 >> n by 256 >> n by 64 >> n voxels at the
/// origin.
inline std::shared_ptr<const voxel::Box> make_level(std::shared_ptr<const voxel::Box> box,
                                                    int level) {
    for (int n = 1; n <= level && box; ++n)
        box = voxel::downsample({n, 0, 0, 0}, alone(box));
    return box;
}

inline voxel::Material material_at(const voxel::Box& box, int x, int y, int z) {
    const auto v = box.voxel(x, y, z);
    return v ? v->material : voxel::Material::kAir;
}
inline bool opaque_at(const voxel::Box& box, int x, int y, int z) {
    return !see_through(material_at(box, x, y, z));
}

/// One past the highest voxel of the column that `counts(material)`; 0 without one.
template <class Counts>
int find_top(const voxel::Box& box, int x, int z, const Counts& counts) {
    int y = voxel::kBoxSizeY;
    while (y > 0 && !counts(material_at(box, x, y - 1, z)))
        --y;
    return y;
}

/// Of the (64 >> level)^2 columns: those that a straight look down passes without meeting anything
/// opaque.
inline int open_columns(const voxel::Box& box, int level) {
    int open = 0;
    for (int x = 0; x < 64 >> level; ++x)
        for (int z = 0; z < 64 >> level; ++z)
            open += find_top(box, x, z, [](voxel::Material m) { return !see_through(m); }) == 0;
    return open;
}

/// Whether light gets from the top layer of the box to voxel `inside` by faces of voxels that are
/// not opaque, within `side` x `side` columns.
inline bool light_reaches(const voxel::Box& box, int side, int height, std::array<int, 3> inside) {
    std::vector<char> lit(static_cast<std::size_t>(side * side * height));
    const auto at = [&](int x, int y, int z) -> char& {
        return lit[static_cast<std::size_t>((y * side + z) * side + x)];
    };
    std::vector<std::array<int, 3>> open;
    const auto visit = [&](int x, int y, int z) {
        if (x < 0 || y < 0 || z < 0 || x >= side || y >= height || z >= side || at(x, y, z) != 0 ||
            opaque_at(box, x, y, z))
            return;
        at(x, y, z) = 1;
        open.push_back({x, y, z});
    };
    for (int x = 0; x < side; ++x)
        for (int z = 0; z < side; ++z)
            visit(x, height - 1, z);
    while (!open.empty()) {
        const auto [x, y, z] = open.back();
        open.pop_back();
        for (const int d : {-1, 1}) {
            visit(x + d, y, z);
            visit(x, y + d, z);
            visit(x, y, z + d);
        }
    }
    return at(inside[0], inside[1], inside[2]) != 0;
}

}  // namespace terravox::test
