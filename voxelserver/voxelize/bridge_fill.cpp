#include "voxelserver/voxelize/bridge_fill.hpp"

#include <algorithm>
#include <array>

namespace terravox::voxelize {
namespace {

constexpr int kDecksAround = 5;  // of eight

// Pulses that pass a railing or an edge hit what is below: a deck's columns may hold as many of those again.
bool is_deck(const Column& c) noexcept { return c.deck.seen() && 2 * c.deck_points > c.ground_points + c.water_points; }

Surface deck_of(const Window& window, int x, int z) {
    const Column& own = window.column(x, z);
    if (is_deck(own)) return own.deck;
    std::array<const Surface*, 8> around{};
    std::size_t count = 0;
    for (int dz = -1; dz <= 1; ++dz)
        for (int dx = -1; dx <= 1; ++dx)
            if (const Column& c = window.column(x + dx, z + dz); (dx != 0 || dz != 0) && is_deck(c)) around[count++] = &c.deck;
    if (count < kDecksAround) return {};
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Surface* a, const Surface* b) { return a->height < b->height; });
    return **middle;
}

}  // namespace

Margined<Surface> fill_decks(const Window& window) {
    Margined<Surface> out;
    if (!window.any(&PatchColumns::any_deck)) return out;
    Margined<Surface>::each([&](int x, int z) { out.at(x, z) = deck_of(window, x, z); });
    return out;
}

Margined<Surface> seen_decks(const Window& window) {
    Margined<Surface> out;
    Margined<Surface>::each([&](int x, int z) { out.at(x, z) = window.column(x, z).deck; });
    return out;
}

}  // namespace terravox::voxelize
