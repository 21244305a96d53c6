// Grass, soil, gravel, rock, sand, snow.
// Leaves with holes between them, and wood.
#include <algorithm>

#include "raytracer/core/material/texture_list.hpp"

namespace terravox::material {
namespace {

std::uint64_t make_seed(int drawing, int variant) noexcept {
    return static_cast<std::uint64_t>(drawing) * 1000 + static_cast<std::uint64_t>(variant);
}

voxel::Colour blades(int s, int t, std::uint64_t seed) noexcept {
    const float b = 1 + 0.13f * cloud(s, t, 4, seed) + 0.10f * cloud(s, t, 8, seed + 1) +
                    0.09f * grain(s, t, seed + 2);
    return tint(b, 0.10f * cloud(s, t, 2, seed + 3) + 0.10f * grain(s, t, seed + 4));
}

// Layers, and stones of two or three texels that are lit from above.
voxel::Colour earth(int s, int t, int variant, const Stones& stones) noexcept {
    const int layout = variant % kLayouts;
    const std::uint64_t seed = make_seed(2, variant);
    // No bend at the edges, where the next voxel continues.
    const int bend = s < 2 || s > 13 ? 0 : static_cast<int>(chance(s / 3, 0, seed) * 2);
    const float layer = chance((t + bend) / 3, layout, 77) - 0.5f;
    voxel::Colour c =
        tint(1 + 0.16f * layer + 0.10f * grain(s, t, seed) + 0.06f * cloud(s, t, 8, seed + 1),
             0.10f * layer + 0.05f * grain(s, t, seed + 2));
    const Stones::At stone = stones.at(s, t);
    if (chance(stone.id, 5, seed) < 0.35f && stone.edge > 0.7f)
        c = tint(1.25f + 0.11f * stone.up + 0.05f * grain(s, t, seed), -0.12f);
    else if (chance(stone.id, 5, seed) < 0.35f && stone.up < 0 && stone.edge > 0)
        c = c * 0.72f;
    return c;
}

}  // namespace

void draw_grass_top(Canvas& canvas, int variant) {
    const std::uint64_t seed = make_seed(1, variant);
    canvas.each([&](Dot& dot, int s, int t) { dot.ratio = blades(s, t, seed); });
    for (int i = 0; i < 22; ++i) {  // single blades with their shadow
        const int s = static_cast<int>(chance(i, 0, seed) * 16);
        const int t = static_cast<int>(chance(i, 1, seed) * 16);
        const int blade = 1 + static_cast<int>(chance(i, 2, seed) * 3);
        for (int k = 0; k < blade; ++k)
            canvas.at(s, t + k).ratio = tint(1.16f + 0.10f * static_cast<float>(k), 0.16f);
        canvas.at(s, t - 1).ratio = tint(0.74f, -0.08f);
        canvas.at(s + 1, t).ratio = tint(0.82f, -0.05f);
    }
}

void draw_grass_side(Canvas& canvas, int variant) {
    const std::uint64_t seed = make_seed(1, variant) + 500;
    const Stones stones(4, seed);
    std::array<int, kTexels> fringe{};
    for (int s = 0; s < kTexels; ++s)
        fringe[static_cast<std::size_t>(s)] =
            8 - static_cast<int>(1.6f + 1.4f * cloud(s, 3, 8, seed)) -
            (chance(s, 7, seed) < 0.35f ? 2 : 0) + (chance(s, 8, seed) < 0.3f ? 1 : 0);
    canvas.each([&](Dot& dot, int s, int t) {
        const int depth = t - fringe[static_cast<std::size_t>(s)];
        if (depth >= 0) {
            dot.ratio = blades(s, t, seed) *
                        (depth == 0 ? 0.80f : 1 + 0.015f * static_cast<float>(t - 8)) *
                        (1 + 0.10f * grain(s, 0, seed + 9));
            return;
        }
        dot.share = 1;
        dot.own = earth(s, t, variant, stones) * (depth == -1 ? 0.66f : depth == -2 ? 0.85f : 1.0f);
    });
}

void draw_soil(Canvas& canvas, int variant) {
    const Stones stones(4, make_seed(2, variant));
    canvas.each([&](Dot& dot, int s, int t) { dot.ratio = earth(s, t, variant, stones); });
}

void draw_gravel(Canvas& canvas, int variant) {
    const std::uint64_t seed = make_seed(3, variant);
    const Stones stones(5, seed);
    canvas.each([&](Dot& dot, int s, int t) {
        const Stones::At stone = stones.at(s, t);
        const float own = chance(stone.id, 1, seed) - 0.5f;
        const float body = stone.edge < 0.55f ? 0.80f : 1 + 0.22f * own + 0.035f * stone.up;
        dot.ratio =
            tint(body + 0.06f * grain(s, t, seed), 0.12f * (chance(stone.id, 2, seed) - 0.5f)) *
            (1 + 0.05f * cloud(s, t, 2, seed + 3));
    });
}

void draw_rock_top(Canvas& canvas, int variant) {
    const std::uint64_t seed = make_seed(4, variant);
    const Stones plates(3, seed);
    canvas.each([&](Dot& dot, int s, int t) {
        const Stones::At plate = plates.at(s, t);
        const float crack = plate.edge < 0.5f                   ? 0.70f
                            : plate.edge < 1.1f && plate.up < 0 ? 1.10f
                                                                : 1.0f;
        dot.ratio = tint(crack * (1 + 0.12f * (chance(plate.id, 1, seed) - 0.5f) +
                                  0.08f * cloud(s, t, 8, seed + 1) + 0.05f * grain(s, t, seed)),
                         0.04f * cloud(s, t, 4, seed + 2));
        // Lichen, in clusters of specks.
        const float lichen = cloud(s, t, 4, seed + 4) + 0.55f * grain(s, t, seed + 5);
        if (lichen > 0.80f)
            dot.ratio = chance(variant, 1, 9) < 0.6f ? voxel::Colour{1.22f, 1.24f, 0.80f}
                                                     : voxel::Colour{1.30f, 1.32f, 1.22f};
    });
}

void draw_rock_side(Canvas& canvas, int variant) {
    const int layout = variant % kLayouts;
    const std::uint64_t seed = make_seed(5, variant);
    const std::uint64_t layers = make_seed(5, layout) + 300;
    // Where the strata of this height begin: the same for all voxels next to each other.
    std::array<int, kTexels> stratum{};
    for (int t = 0, left = 0, number = 0; t < kTexels; ++t, --left) {
        if (left == 0) {
            left = 2 + static_cast<int>(chance(number, 0, layers) * 4);
            ++number;
        }
        stratum[static_cast<std::size_t>(t)] = number;
    }
    canvas.each([&](Dot& dot, int s, int t) {
        const bool edge = s < 2 || s > 13;
        const int bend = edge ? 0 : static_cast<int>(1.45f * (cloud(s, layout, 4, seed) + 0.3f));
        const auto at = [&](int row) {
            return stratum[static_cast<std::size_t>(std::clamp(row + bend, 0, kTexels - 1))];
        };
        const int here = at(t);
        const float own = chance(here, 1, layers) - 0.5f;
        float b =
            1 + 0.24f * own + 0.07f * grain(s, t, seed + 1) + 0.07f * cloud(s, t, 4, seed + 2);
        if (t > 0 && at(t - 1) != here && chance(s / 2, here, seed) < 0.8f)
            b *= 0.70f;  // the joint below
        else if (t < kTexels - 1 && at(t + 1) != here)
            b *= 1.10f;  // the ledge's lit edge
        if (!edge && s == 3 + static_cast<int>(chance(here, 2, seed) * 10) &&
            chance(here, 3, seed) < 0.6f)
            b *= 0.68f;  // a crack through the stratum
        dot.ratio = tint(b, 0.14f * own + 0.03f * grain(s, t, seed + 3));
    });
}

void draw_sand(Canvas& canvas, int variant) {
    const std::uint64_t seed = make_seed(6, variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const float bend = 0.10f * cloud(s, t, 4, 61);
        const float ripple = wave(static_cast<float>(2 * t + s) / 16.0f + bend);
        dot.ratio = tint(1 + 0.035f * ripple + 0.045f * grain(s, t, seed) +
                             (chance(s, t, seed + 1) < 0.03f ? -0.14f : 0.0f),
                         0.04f * grain(s, t, seed + 2));
    });
}

void draw_snow(Canvas& canvas, int variant) {
    const std::uint64_t seed = make_seed(7, variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const float soft = cloud(s, t, 4, seed);
        dot.ratio = tint(1 + 0.025f * soft + 0.012f * grain(s, t, seed + 1) +
                             (chance(s, t, seed + 2) < 0.03f ? 0.06f : 0.0f),
                         0.025f * soft);
    });
}

namespace {

// A leaf, or a clump of them: texels from the lower left, '#' lit by its position, '+' its lighter
// tip, '-' its shaded edge.
struct Stamp {
    std::array<std::string_view, 4> rows;  // the upper first
};
constexpr std::array kSmall = {Stamp{{"+", "#-", "", ""}}, Stamp{{"+#", "#-", "", ""}},
                               Stamp{{"#+", "-#", "", ""}}};
constexpr std::array kLarge = {Stamp{{" ++", "+##", "##-", " -"}},
                               Stamp{{"++", "##+", "-##", "--"}}, Stamp{{"+#", "##", "-", ""}},
                               Stamp{{" +", "+##", "#--", ""}}};

constexpr std::array kGaps = {Stamp{{"##", "##", "", ""}},   Stamp{{" #", "##", "#", ""}},
                              Stamp{{"###", " ##", "", ""}}, Stamp{{" ##", "###", "##", ""}},
                              Stamp{{"#", "#", "", ""}},     Stamp{{"##", "", "", ""}}};

template <class Visit>
void visit_each(const Stamp& stamp, int s, int t, const Visit& visit) {
    for (std::size_t row = 0; row < stamp.rows.size(); ++row)
        for (std::size_t i = 0; i < stamp.rows[row].size(); ++i)
            if (stamp.rows[row][i] != ' ')
                visit(stamp.rows[row][i], s + static_cast<int>(i), t - static_cast<int>(row));
}

void put(Canvas& canvas, const Stamp& stamp, int s, int t, float brightness, float warm) {
    visit_each(stamp, s, t, [&](char c, int x, int y) {
        canvas.at(x, y).ratio = tint(brightness * (c == '+'   ? 1.20f
                                                   : c == '-' ? 0.72f
                                                              : 1.0f),
                                     warm);
    });
}

int holes(const Canvas& canvas) noexcept {
    int count = 0;
    for (int t = 0; t < kTexels; ++t)
        for (int s = 0; s < kTexels; ++s)
            count += canvas.at(s, t).opacity == 0;
    return count;
}

// Leaves from the back, dark, to the front, light; then gaps between them, their number given by
// `open`.
template <std::size_t N>
void leaves(Canvas& canvas, const std::array<Stamp, N>& stamps, float open, float contrast,
            std::uint64_t seed) {
    constexpr int kStamps = 150;
    canvas.each(
        [&](Dot& dot, int s, int t) { dot.ratio = tint(0.7f + 0.15f * grain(s, t, seed), 0); });
    for (int i = 0; i < kStamps; ++i) {
        const float front = static_cast<float>(i) / kStamps;
        const auto& stamp =
            stamps[static_cast<std::size_t>(chance(i, 2, seed) * static_cast<float>(N))];
        put(canvas, stamp, static_cast<int>(chance(i, 0, seed) * 16),
            static_cast<int>(chance(i, 1, seed) * 16),
            1 + contrast * (front - 0.55f) + 0.24f * (chance(i, 3, seed) - 0.5f),
            0.22f * (chance(i, 4, seed) - 0.45f) + 0.08f * front);
    }
    const int max_holes = static_cast<int>(open * kTexels * kTexels);
    for (int i = 0; i < 500 && holes(canvas) < max_holes; ++i) {
        const auto& gap =
            kGaps[static_cast<std::size_t>(chance(i, 5, seed) * static_cast<float>(kGaps.size()))];
        const int s = static_cast<int>(chance(i, 6, seed) * 16);
        const int t = static_cast<int>(chance(i, 7, seed) * 16);
        visit_each(gap, s, t, [&](char, int x, int y) {
            if (holes(canvas) < max_holes)
                canvas.at(x, y).opacity = 0;
        });
    }
    canvas.each([&](Dot& dot, int s, int t) {
        if (dot.opacity == 0)
            return;
        if (canvas.at(s, t + 1).opacity == 0)
            dot.ratio = dot.ratio * 1.14f;  // its upper edge is lit
        else if (canvas.at(s, t - 1).opacity == 0 || canvas.at(s + 1, t).opacity == 0)
            dot.ratio = dot.ratio * 0.72f;
    });
}

}  // namespace

// Stalks that stand close at the foot.
void draw_tufts(Canvas& canvas, int variant) {
    const std::uint64_t seed = 20'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        dot.opacity = 0;
        dot.ratio = tint(1 + 0.2f * grain(s, t, seed), 0);
    });
    constexpr int kMaxHoles = 80;
    for (int i = 0; i < 400 && holes(canvas) > kMaxHoles; ++i) {
        int s = static_cast<int>(chance(i, 0, seed) * 16);
        const int top = 8 + static_cast<int>(chance(i, 1, seed) * 9);
        const int lean = chance(i, 2, seed) < 0.5f ? -1 : 1;
        const float b = 0.86f + 0.3f * chance(i, 3, seed);
        const float warm = 0.30f * (chance(i, 4, seed) - 0.4f);
        for (int t = 0; t <= top; ++t) {
            if (t > top - 3 && t % 2 == 0)
                s += lean;
            Dot& dot = canvas.at(s, t);
            dot.opacity = 1;
            dot.ratio = tint(b * (0.72f + 0.5f * static_cast<float>(t) / 16), warm);
        }
    }
}

void draw_bush(Canvas& canvas, int variant) {
    leaves(canvas, kSmall, 0.30f, 0.55f, 21'000 + static_cast<std::uint64_t>(variant));
}
void draw_foliage(Canvas& canvas, int variant) {
    leaves(canvas, kLarge, 0.32f, 0.65f, 22'000 + static_cast<std::uint64_t>(variant));
}
void draw_hedge(Canvas& canvas, int variant) {
    leaves(canvas, kSmall, 0.25f, 0.40f, 23'000 + static_cast<std::uint64_t>(variant));
}

// Ridges between grooves, which are broken here and there. The grooves of all variants meet.
void draw_bark(Canvas& canvas, int variant) {
    const std::uint64_t seed = 24'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const int bend = t < 3 || t > 12 ? 0 : static_cast<int>(1.2f * cloud(s / 4, t, 4, seed));
        const int column = (s + bend) & 15;
        const bool groove = column % 4 == 0 || column == 6 || column == 13;
        const float b =
            groove && chance(column, t / 3, seed) < 0.8f
                ? 0.62f
                : 1 + 0.16f * (chance(column, 0, 24) - 0.5f) + (column % 4 == 1 ? 0.12f : 0.0f);
        dot.ratio = tint(b + 0.09f * grain(s, t, seed + 1), 0.05f * grain(s, t / 2, seed + 2));
    });
}

void draw_rings(Canvas& canvas, int variant) {
    const std::uint64_t seed = 25'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const int ds = s < 8 ? 7 - s : s - 8;
        const int dt = t < 8 ? 7 - t : t - 8;
        const int ring = std::max(std::max(ds, dt), (2 * (ds + dt) + 2) / 3);
        const float b = ring >= 7 ? 0.62f : ring % 2 == 0 ? 1.22f : 1.04f;
        dot.ratio = tint(b + 0.07f * grain(s, t, seed), ring >= 7 ? 0.0f : 0.12f);
    });
}

}  // namespace terravox::material
