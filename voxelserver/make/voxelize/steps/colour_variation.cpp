#include "voxelserver/make/voxelize/steps/colour_variation.hpp"

#include "voxelserver/make/voxelize/steps/tree_places.hpp"

namespace terravox::voxelize {
namespace {

constexpr std::uint64_t kBuildingSeed = 1;
constexpr std::uint64_t kTreeSeed = 2;

std::uint64_t number(std::int32_t x, std::int32_t z, std::uint64_t seed) noexcept {
    const std::uint64_t out = number_of_place(x, z, seed);
    return out == PlaceNumbers::kNone ? seed : out;
}

}  // namespace

PlaceNumbers number_places(const Window& window, const ClassTable& classes,
                           const Buildings& buildings, const Margined<Roof>& roofs,
                           const Margined<Crown>& crowns, const Tints& tints, double voxel_m) {
    PlaceNumbers out;
    out.tints = &tints;
    if (window.any(&PatchColumns::any_roof)) {
        Margined<char>::each([&](int x, int z) {
            const Roof& roof = roofs.at(x, z);
            if (!roof.seen())
                return;
            const Building* building = buildings.at(x + roof.appearance_dx, z + roof.appearance_dz);
            if (building != nullptr)
                out.building.at(x, z) = number(building->x, building->z, kBuildingSeed);
        });
    }
    if (window.any(&PatchColumns::any_objects)) {
        TreePlaces trees(window, classes, voxel_m);
        Margined<char>::each([&](int x, int z) {
            if (!crowns.at(x, z).seen() && window.objects(x, z).empty())
                return;
            const auto [tree_x, tree_z] = trees.at(x, z);
            out.tree.at(x, z) = number(tree_x, tree_z, kTreeSeed);
        });
    }
    return out;
}

}  // namespace terravox::voxelize
