// Leaves with holes between them, and wood.
#include <algorithm>

#include "raytracer/core/material/texture_list.hpp"

namespace terravox::material {
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
void each_of(const Stamp& stamp, int s, int t, const Visit& visit) {
    for (std::size_t row = 0; row < stamp.rows.size(); ++row)
        for (std::size_t i = 0; i < stamp.rows[row].size(); ++i)
            if (stamp.rows[row][i] != ' ')
                visit(stamp.rows[row][i], s + static_cast<int>(i), t - static_cast<int>(row));
}

void put(Canvas& canvas, const Stamp& stamp, int s, int t, float brightness, float warm) {
    each_of(stamp, s, t, [&](char c, int x, int y) {
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
        each_of(gap, s, t, [&](char, int x, int y) {
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
