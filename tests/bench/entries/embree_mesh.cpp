#include "tests/bench/entries/embree_mesh.hpp"

#include "common/thread/parallel.hpp"

namespace terravox::bench {
namespace {

constexpr int kSlab = 16;  // voxels along x
static_assert(NeutralScene::kSide % kSlab == 0);

/// A rectangle on the plane `axis = at`, from (a0, b0) to (a1, b1) on the two other axes in order.
void add(QuadMesh& mesh, int axis, int at, int a0, int b0, int a1, int b1) {
    const int corners[4][2] = {{a0, b0}, {a1, b0}, {a1, b1}, {a0, b1}};
    const int a = axis == 0 ? 1 : 0;
    const int b = axis == 2 ? 1 : 2;
    for (const auto& corner : corners) {
        float v[3] = {};
        v[axis] = static_cast<float>(at);
        v[a] = static_cast<float>(corner[0]);
        v[b] = static_cast<float>(corner[1]);
        mesh.corners.insert(mesh.corners.end(), v, v + 3);
    }
}

/// Faces of one direction in the row (x, y, *): along z they join to runs, across z each stands
/// alone.
void add_row(QuadMesh& mesh, const NeutralScene& scene, int x, int y, core::Face face) {
    const int axis = core::to_axis(face);
    const int step = core::to_sign(face);
    const int far = step > 0 ? 1 : 0;
    const int dx = axis == 0 ? step : 0;
    const int dy = axis == 1 ? step : 0;
    const int dz = axis == 2 ? step : 0;
    const auto exposed = [&](int z) {
        return scene.at(x, y, z) != 0 && scene.at(x + dx, y + dy, z + dz) == 0;
    };
    for (int z = 0; z < NeutralScene::kSide; ++z) {
        if (!exposed(z))
            continue;
        const int first = z;
        if (axis == 2) {
            add(mesh, 2, z + far, x, y, x + 1, y + 1);
            continue;
        }
        while (z + 1 < NeutralScene::kSide && exposed(z + 1))
            ++z;
        if (axis == 0)
            add(mesh, 0, x + far, y, first, y + 1, z + 1);
        else
            add(mesh, 1, y + far, x, first, x + 1, z + 1);
    }
}

}  // namespace

std::vector<QuadMesh> mesh_slabs(const NeutralScene& scene, int threads) {
    std::vector<QuadMesh> slabs(NeutralScene::kSide / kSlab);
    thread::parallel_for(slabs.size(), threads, [&](std::size_t slab) {
        const int x0 = static_cast<int>(slab) * kSlab;
        for (int x = x0; x < x0 + kSlab; ++x)
            for (int y = 0; y < NeutralScene::kHeight; ++y)
                for (const core::Face face :
                     {core::Face::kWest, core::Face::kEast, core::Face::kBottom, core::Face::kTop,
                      core::Face::kNorth, core::Face::kSouth})
                    add_row(slabs[slab], scene, x, y, face);
    });
    return slabs;
}

}  // namespace terravox::bench
