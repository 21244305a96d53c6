// Roofs: t runs up the slope.
#include "raytracer/core/material/texture_list.hpp"

namespace terravox::material {
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
