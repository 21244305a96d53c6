#include "voxelserver/make/voxelize/decks/bridge_fill.hpp"

#include <algorithm>
#include <array>

namespace terravox::voxelize {
namespace {

constexpr int kBridgedAround = 5;  // of eight

Surface deck_of(const Window& window, int x, int z) {
    const Column& own = window.column(x, z);
    if (own.bridged())
        return own.deck;
    std::array<const Surface*, 8> around{};
    std::size_t count = 0;
    for (int dz = -1; dz <= 1; ++dz)
        for (int dx = -1; dx <= 1; ++dx)
            if (const Column& c = window.column(x + dx, z + dz);
                (dx != 0 || dz != 0) && c.bridged())
                around[count++] = &c.deck;
    if (count < kBridgedAround)
        return {};
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Surface* a, const Surface* b) { return a->height < b->height; });
    return **middle;
}

}  // namespace

Margined<Surface> fill_decks(const Window& window, const FoundDecks* found) {
    Margined<Surface> out;
    if (window.any(&PatchColumns::any_deck))
        Margined<Surface>::each([&](int x, int z) { out.at(x, z) = deck_of(window, x, z); });
    if (found != nullptr)
        Margined<Surface>::each([&](int x, int z) {
            if (!out.at(x, z).seen())
                out.at(x, z) = found->at(x, z).deck;
        });
    return out;
}

void flow_beneath(const FoundDecks& found, double depth_m, WaterColumns& water) {
    FoundDecks::each([&](int x, int z) {
        const FoundDeck& f = found.at(x, z);
        if (!f.deck.seen() || !f.over_water || water.is_water(x, z))
            return;
        water.level.at(x, z) = f.below;
        if (x >= Margined<float>::kFirst && x < Margined<float>::kLast &&
            z >= Margined<float>::kFirst && z < Margined<float>::kLast)
            water.depth_m.at(x, z) = static_cast<float>(depth_m);
    });
}

void lower_ground(const FoundDecks& found, GroundHeights& ground) {
    FoundDecks::each([&](int x, int z) {
        const FoundDeck& f = found.at(x, z);
        if (f.below != f.below)
            return;  // NaN: nothing found here
        if (f.deck.seen())
            ground.at(x, z) = f.over_water ? kNoHeight : f.below;
        else if (ground.at(x, z) > f.below)
            ground.at(x, z) = f.below;
    });
}

void clear_crowns(const FoundDecks& found, double trunk_from_m, double voxel_m,
                  Margined<Crown>& crowns) {
    Margined<Crown>::each([&](int x, int z) {
        const FoundDeck& f = found.at(x, z);
        if (!f.deck.seen())
            return;
        Crown& crown = crowns.at(x, z);
        if (crown.seen() &&
            static_cast<double>(crown.height - f.deck.height) * voxel_m < trunk_from_m)
            crown = {};
    });
}

Margined<Surface> seen_decks(const Window& window) {
    Margined<Surface> out;
    Margined<Surface>::each([&](int x, int z) { out.at(x, z) = window.column(x, z).deck; });
    return out;
}

}  // namespace terravox::voxelize
