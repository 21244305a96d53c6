// Building materials, except roofs.
// Roofs: t runs up the slope.
#include <algorithm>

#include "raytracer/core/material/texture_list.hpp"

namespace terravox::material {

void draw_asphalt(Canvas& canvas, int variant) {
    const std::uint64_t seed = 30'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const float speck = chance(s, t, seed + 1);
        dot.ratio = tint(1 + 0.06f * grain(s, t, seed) + 0.03f * cloud(s, t, 4, seed + 2) +
                             (speck < 0.07f   ? 0.17f
                              : speck > 0.94f ? -0.16f
                                              : 0.0f),
                         0.03f * grain(s, t, seed + 3));
    });
    if (variant != 0)
        return;
    int t = 8;  // one variant has a crack, from edge to edge
    for (int s = 0; s < kTexels; ++s) {
        if (s > 2 && s < 13)
            t = std::clamp(t + static_cast<int>(chance(s, 9, seed) * 3) - 1, 4, 12);
        if (chance(s, 11, seed) < 0.8f)
            canvas.at(s, t).ratio = tint(0.70f, 0);
    }
}

// Four slabs with their joints; the light comes over the upper left.
void draw_slabs(Canvas& canvas, int variant) {
    const std::uint64_t seed = 31'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const int i = s % 8;
        const int j = t % 8;
        const float own = chance(s / 8, t / 8, seed) - 0.5f;
        float b =
            1 + 0.09f * own + 0.025f * grain(s, t, seed + 1) + 0.025f * cloud(s, t, 4, seed + 2);
        if (i == 0 || j == 0)
            b = 0.80f + 0.04f * grain(s, t, seed);
        else if (i == 1 || j == 7)
            b += 0.06f;
        else if (i == 7 || j == 1)
            b -= 0.04f;
        dot.ratio = tint(b, 0.03f * own);
    });
}

void draw_ballast(Canvas& canvas, int variant) {
    const std::uint64_t seed = 32'000 + static_cast<std::uint64_t>(variant);
    const Stones stones(5, seed);
    canvas.each([&](Dot& dot, int s, int t) {
        const Stones::At stone = stones.at(s, t);
        const float own = chance(stone.id, 1, seed) - 0.5f;
        const float rust = chance(stone.id, 2, seed) < 0.3f ? 0.20f : -0.03f;
        const float body = stone.edge < 0.5f ? 0.58f : 1.06f + 0.36f * own + 0.075f * stone.up;
        dot.ratio = tint(body + 0.05f * grain(s, t, seed), rust);
    });
}

// Ashlar: courses of two heights, each shifted against the one below. Blocks that cross the edge
// look the same in all variants.
void draw_masonry(Canvas& canvas, int variant) {
    const std::uint64_t seed = 33'000 + static_cast<std::uint64_t>(variant);
    constexpr std::array<int, kTexels> kCourse = {0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3};
    constexpr std::array kShift = {0, 4, 2, 5};
    constexpr std::array kWidth = {8, 8, 5, 8};
    canvas.each([&](Dot& dot, int s, int t) {
        const int course = kCourse[static_cast<std::size_t>(t)];
        const int shift = kShift[static_cast<std::size_t>(course)];
        const int width = kWidth[static_cast<std::size_t>(course)];
        const int along = (s + kTexels - shift) & 15;
        const int last = course == 2 ? 2 : 1;
        const int block = std::min(along / width, last);
        const int i = along - block * width;
        const bool foot = t == 0 || kCourse[static_cast<std::size_t>(t - 1)] != course;
        const bool head = t == 15 || kCourse[static_cast<std::size_t>(t + 1)] != course;
        const bool crosses = block == last && shift != 0;
        const float own = chance(course, block, crosses ? 33 : seed) - 0.5f;
        float b =
            1 + 0.22f * own + 0.05f * grain(s, t, seed + 1) + 0.04f * cloud(s, t, 4, seed + 2);
        if (foot || i == 0)
            b = 0.70f + 0.05f * grain(s, t, seed + 3);
        else if (head)
            b *= 1.09f;
        dot.ratio = tint(b, 0.09f * (chance(block, course, crosses ? 34 : seed + 5) - 0.5f));
    });
}

// Planks: four boards above each other, each with one joint. Boards that cross the edge look the
// same in all variants.
void draw_planks(Canvas& canvas, int variant) {
    const std::uint64_t seed = 38'000 + static_cast<std::uint64_t>(variant);
    constexpr std::array kJoint = {4, 11, 7, 14};
    canvas.each([&](Dot& dot, int s, int t) {
        const int board = t / 4;
        const int joint = kJoint[static_cast<std::size_t>(board)];
        const float own = chance(board, s < joint ? 0 : 1, 38) - 0.5f;
        float b = 1 + 0.13f * own + 0.05f * chance(s / 3, t, seed) + 0.03f * grain(s, t, seed + 1);
        if (t % 4 == 0)
            b *= 0.74f;
        else if (s == joint)
            b *= 0.82f;
        dot.ratio = tint(b, 0.05f * own);
    });
}

// A deck: setts in rows.
void draw_paving(Canvas& canvas, int variant) {
    const std::uint64_t seed = 34'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const int row = t / 4;
        const int along = (s + (row % 2) * 2) & 15;
        const int stone = along / 4;
        const int i = along % 4;
        const int j = t % 4;
        const bool crosses = row % 2 == 1 && stone == 0;
        const float own = chance(stone, row, crosses ? 35 : seed) - 0.5f;
        float b = 1.03f + 0.20f * own + 0.04f * grain(s, t, seed + 1);
        if (i == 0 || j == 0)
            b = 0.80f + 0.05f * grain(s, t, seed + 2);
        else if (j == 3)
            b += 0.05f;
        dot.ratio = tint(b, 0.05f * own);
    });
}

void draw_plaster(Canvas& canvas, int variant) {
    const std::uint64_t seed = 35'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        dot.ratio = tint(1 + 0.018f * grain(s, t, seed) + 0.02f * cloud(s, t, 4, seed + 1) +
                             0.012f * grain(s, 0, seed + 2),
                         0.012f * cloud(s, t, 4, seed + 3));
    });
}

// Angle iron: a frame and a cross, dark between them.
void draw_lattice(Canvas& canvas, int variant) {
    const std::uint64_t seed = 36'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const bool frame = s < 2 || s > 13 || t < 1 || t > 14;
        const bool up = s == t || s == t + 1;
        const bool down = s + t == 15 || s + t == 16;
        float b = 0.42f + 0.05f * grain(s, t, seed);
        if (frame)
            b = s == 0 || s == 14 ? 1.55f : 1.30f;
        else if (up)
            b = s == t ? 1.50f : 1.15f;
        else if (down)
            b = s + t == 16 ? 1.40f : 1.10f;
        if (frame && (s == 1 || s == 14) && (t == 1 || t == 14))
            b = 1.8f;  // rivets
        dot.ratio = tint(b * (1 + 0.04f * grain(s, t, seed + 1)), 0.03f * cloud(s, t, 4, seed + 2));
    });
}

// Two cables that hang one above the other.
void draw_wire_side(Canvas& canvas, int variant) {
    canvas.each([&](Dot& dot, int s, int t) {
        const int in = t >= 3 && t < 6 ? t - 3 : t >= 10 && t < 13 ? t - 10 : -1;
        dot.opacity = in >= 0 ? 1.0f : 0.0f;
        dot.ratio = in < 0 ? voxel::Colour{1, 1, 1}
                           : tint((in == 2   ? 1.5f
                                   : in == 1 ? 1.0f
                                             : 0.6f) *
                                      ((s + t) % 4 == variant ? 0.85f : 1.0f),
                                  0);
    });
}

void draw_wire_top(Canvas& canvas, int) {
    canvas.each([&](Dot& dot, int s, int t) {
        const bool on = (s >= 6 && s < 9) || (t >= 6 && t < 9);
        dot.opacity = on ? 1.0f : 0.0f;
        dot.ratio = tint(s == 7 || t == 7 ? 1.3f : 0.85f, 0);
    });
}

// Painted metal or wood of unknown kind: soft blotches and a few scratches.
void draw_panel(Canvas& canvas, int variant) {
    const std::uint64_t seed = 37'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        dot.ratio = tint(1 + 0.06f * cloud(s, t, 4, seed) + 0.03f * grain(s, t, seed + 1),
                         0.04f * cloud(s, t, 2, seed + 2));
    });
    for (int i = 0; i < 4; ++i) {
        const int s = static_cast<int>(chance(i, 0, seed) * 16);
        const int t = static_cast<int>(chance(i, 1, seed) * 16);
        for (int k = 0; k < 3; ++k)
            canvas.at(s + k, t).ratio = tint(i % 2 == 0 ? 1.14f : 0.84f, 0);
    }
}

namespace {

constexpr int kSloped = 4;  // variants; those after them are for faces without a known slope

// A row is four texels deep: the rim of its tiles, which is lit, two rows of their faces, and the
// shadow of the row above.
voxel::Colour tile(int s, int t, int variant) noexcept {
    const std::uint64_t seed = 40'000 + static_cast<std::uint64_t>(variant % kSloped);
    const int row = t / 4;
    const int j = t % 4;
    const int along = (s + (row % 2) * 2) & 15;
    const int column = along / 4;
    const int i = along % 4;
    // Into the next voxel, which has another variant.
    const bool crosses = row % 2 == 1 && column == 0;
    const float own = chance(column, row, crosses ? 41 : seed) - 0.5f;
    const float age = chance(column, row, crosses ? 42 : seed + 1);
    constexpr std::array kAcross = {0.84f, 1.04f, 1.07f, 0.97f};
    constexpr std::array kUp = {1.13f, 1.06f, 0.99f, 0.74f};
    float b = kAcross[static_cast<std::size_t>(i)] * kUp[static_cast<std::size_t>(j)] *
                  (1 + 0.24f * own) +
              0.04f * grain(s, t, seed + 2);
    if (j == 0 && i == 0)
        b *= 0.74f;  // between the round ends
    voxel::Colour c = tint(b, 0.16f * own);
    if (age > 0.90f)
        c = c * voxel::Colour{0.80f, 0.86f, 0.90f};  // weathered
    if (!crosses && chance(s, t, seed + 4) < 0.025f)
        c = voxel::Colour{0.95f, 1.22f, 0.95f} * 0.9f;  // moss
    return c;
}

voxel::Colour slate(int s, int t, int variant) noexcept {
    const std::uint64_t seed = 43'000 + static_cast<std::uint64_t>(variant % kSloped);
    const int row = t / 4;
    const int j = t % 4;
    const int along = (s + (row % 2) * 3) & 15;
    const int column = along / 5 > 2 ? 2 : along / 5;
    const int i = along - 5 * column;
    const bool crosses = row % 2 == 1 && column == 0;
    const float own = chance(column, row, crosses ? 44 : seed) - 0.5f;
    float b = 1.02f + 0.20f * own + 0.035f * grain(s, t, seed + 1);
    if (j == 0)
        b += 0.09f;
    if (j == 3)
        b *= 0.78f;
    else if (i == 0)
        b *= 0.82f;
    return tint(b, 0.10f * (chance(row, column, crosses ? 45 : seed + 3) - 0.55f));
}

template <class Paint>
void draw_rows(Canvas& canvas, int variant, const Paint& paint) {
    // For a face without a known slope, rows must not lie across the true ones: half of the
    // variants run each way.
    canvas.each([&](Dot& dot, int s, int t) {
        dot.ratio = variant < kSloped
                        ? paint(s, t, variant)
                        : voxel::mix(paint(s, t, variant), paint(t, s, variant), 0.5f);
    });
}

}  // namespace

void draw_tiles(Canvas& canvas, int variant) {
    draw_rows(canvas, variant, tile);
}
void draw_slate(Canvas& canvas, int variant) {
    draw_rows(canvas, variant, slate);
}

// Gravel on bitumen sheets, with the seam of two sheets.
void draw_flat_roof(Canvas& canvas, int variant) {
    const std::uint64_t seed = 46'000 + static_cast<std::uint64_t>(variant);
    canvas.each([&](Dot& dot, int s, int t) {
        const float speck = chance(s, t, seed + 1);
        float b = 1 + 0.05f * grain(s, t, seed) + 0.04f * cloud(s, t, 4, seed + 2) +
                  (speck < 0.06f   ? 0.12f
                   : speck > 0.95f ? -0.14f
                                   : 0.0f);
        if (t == 0)
            b *= 0.84f;
        if (t == 1)
            b *= 1.06f;
        dot.ratio = tint(b, 0.03f * grain(s, t, seed + 3));
    });
}

}  // namespace terravox::material
