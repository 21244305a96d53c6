#include "voxelserver/tools/survey/colours.hpp"

#include <array>

#include "voxelserver/tools/survey/noise.hpp"

namespace terravox::survey {
namespace {

Colour base_of(Cover cover) noexcept {
    switch (cover) {
        case Cover::kMeadow: return {112, 138, 66};
        case Cover::kMownMeadow: return {146, 164, 86};
        case Cover::kWheat: return {200, 180, 114};
        case Cover::kBarley: return {190, 180, 122};
        case Cover::kMaize: return {78, 118, 48};
        case Cover::kRape: return {184, 180, 74};
        case Cover::kPloughed: return {136, 106, 78};
        case Cover::kGarden: return {122, 148, 76};
        case Cover::kForest: return {74, 84, 46};
        case Cover::kScrub: return {108, 124, 62};
        case Cover::kRock: return {158, 152, 142};
        case Cover::kBeach: return {196, 184, 152};
        case Cover::kRoad: return {116, 116, 120};
        case Cover::kGravelRoad: return {196, 184, 158};
        case Cover::kCourtyard: return {188, 178, 158};
        case Cover::kBuilding: return {150, 148, 144};
    }
    return {255, 0, 255};
}

bool is_crop(Cover cover) noexcept {
    return cover >= Cover::kMeadow && cover <= Cover::kPloughed;
}

// -1 and 1 alternating, `width_m` wide.
double stripe(double across_m, double width_m) noexcept {
    const double half = across_m / (2.0 * width_m);
    return half - std::floor(half) < 0.5 ? 1.0 : -1.0;
}

double tint_of(std::uint32_t tint) noexcept {
    return static_cast<double>(tint & 0xFFFFU) / 32768.0 - 1.0;
}

}  // namespace

Colour ground_colour(std::uint64_t seed, Cover cover, Vec2 p) noexcept {
    const double coarse = noise_2d(seed + 51, p.x / 23.0, p.y / 23.0);
    const double fine = noise_2d(seed + 52, p.x / 2.1, p.y / 2.1);
    Colour colour = base_of(cover);
    double shade = 1.0 + 0.05 * coarse + 0.05 * fine;
    if (is_crop(cover)) {
        const Parcel parcel = parcel_at(seed, p);
        shade += 0.09 * parcel.shade;
        // Rows of maize and furrows, swathes of the mower, tramlines of the tractor.
        if (cover == Cover::kMaize || cover == Cover::kPloughed)
            shade += 0.07 * stripe(parcel.row, 1.0);
        if (cover == Cover::kMownMeadow)
            shade += 0.035 * stripe(parcel.row, 2.5);
        const double tram = parcel.row / 9.0 - std::floor(parcel.row / 9.0);
        if ((cover == Cover::kWheat || cover == Cover::kBarley) && tram < 0.08)
            shade -= 0.10;
        colour = colour.mixed({170, 156, 96}, 0.10 * (1.0 + coarse));
    }
    if (cover == Cover::kRock)
        shade += 0.10 * noise_2d(seed + 55, p.x / 16.0, p.y / 3.0) +
                 0.16 * noise_2d(seed + 53, p.x / 5.0, p.y / 5.0) + 0.08 * fine;
    if (cover == Cover::kGarden)
        colour =
            colour.mixed({158, 160, 100}, 0.25 * (1.0 + noise_2d(seed + 54, p.x / 9.0, p.y / 9.0)));
    if (cover == Cover::kRoad)
        shade = 1.0 + 0.03 * fine;
    return colour * shade;
}

Colour water_colour(std::uint64_t seed, Vec2 p, double depth_m, bool lake) noexcept {
    const Colour deep = lake ? Colour{30, 84, 104} : Colour{54, 96, 96};
    const Colour shallow = lake ? Colour{86, 150, 142} : Colour{112, 138, 118};
    const double clear = 1.0 / (1.0 + (lake ? 0.55 : 1.1) * depth_m);
    return deep.mixed(shallow, clear) * (1.0 + 0.025 * noise_2d(seed + 61, p.x / 14.0, p.y / 5.0));
}

Colour roof_colour(const Building& building, int side) noexcept {
    constexpr std::array<Colour, 4> kRoofs = {
        {{178, 84, 56}, {118, 120, 126}, {186, 182, 174}, {112, 150, 132}}};
    const double facing =
        (side == 0 ? 1.0 : -1.0) * (building.direction.x - building.direction.y) * 0.05;
    const double flat = building.roof == RoofType::kFlat ? 0.0 : facing;
    return kRoofs[static_cast<std::size_t>(building.colour)] *
           (1.0 + 0.10 * tint_of(building.tint) + flat);
}

Colour crown_colour(const Tree& tree) noexcept {
    const double tint = tint_of(tree.tint);
    if (tree.kind == TreeKind::kConifer)
        return Colour{46, 78, 44} * (1.0 + 0.16 * tint);
    const Colour leaves = tree.kind == TreeKind::kBush ? Colour{96, 122, 58} : Colour{80, 116, 46};
    const bool yellowish = ((tree.tint >> 16) & 7U) == 0;
    return leaves.mixed({138, 146, 60}, yellowish ? 0.45 : 0.0) * (1.0 + 0.15 * tint);
}

}  // namespace terravox::survey
