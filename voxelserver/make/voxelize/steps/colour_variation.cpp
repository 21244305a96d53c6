#include "voxelserver/make/voxelize/steps/colour_variation.hpp"

#include <cmath>

#include "common/util/mix.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxelize {

std::uint64_t number_of_place(std::int32_t x, std::int32_t z, std::uint64_t seed) noexcept {
    return util::mix(util::mix(static_cast<std::uint32_t>(x) |
                               static_cast<std::uint64_t>(static_cast<std::uint32_t>(z)) << 32) ^
                     seed);
}

namespace {

constexpr std::uint64_t kBuildingSeed = 1;
constexpr std::uint64_t kTreeSeed = 2;
constexpr std::uint64_t kDistrictSeed = 3;

std::uint64_t number(std::int32_t x, std::int32_t z, std::uint64_t seed) noexcept {
    const std::uint64_t out = number_of_place(x, z, seed);
    return out == PlaceNumbers::kNone ? seed : out;
}

HouseNumber number_house(const Building& building, double voxel_m) {
    const auto district = [&](std::int32_t at) {
        return static_cast<std::int32_t>(std::floor(at * voxel_m / Tints::kDistrict_m));
    };
    return {number(building.x, building.z, kBuildingSeed),
            number_of_place(district(building.x), district(building.z), kDistrictSeed)};
}

}  // namespace

const HouseNumber* PlaceNumbers::house(int x, int z) const noexcept {
    const int index = house_index.at(x, z);
    return index < 0 ? nullptr : &houses[static_cast<std::size_t>(index)];
}

PlaceNumbers number_places(const Window& window, const ClassTable& classes,
                           const Buildings& buildings, const Margined<Roof>& roofs,
                           const Margined<Crown>& crowns, const Tints& tints, double voxel_m) {
    PlaceNumbers out;
    out.tints = &tints;
    if (window.any(&PatchColumns::any_roof)) {
        for (const Building& building : buildings.all())
            out.houses.push_back(number_house(building, voxel_m));
        out.houses.push_back({0, 0, true});
        const auto wide = static_cast<std::int16_t>(tints.has_wide() ? out.houses.size() - 1 : -1);
        Margined<char>::each([&](int x, int z) {
            const Roof& roof = roofs.at(x, z);
            if (!roof.seen())
                return;
            const Building* building = buildings.at(x + roof.appearance_dx, z + roof.appearance_dz);
            out.house_index.at(x, z) =
                building == nullptr ? wide
                                    : static_cast<std::int16_t>(building - buildings.all().data());
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
