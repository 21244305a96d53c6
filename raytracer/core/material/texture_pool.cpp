#include "raytracer/core/material/texture_pool.hpp"

namespace terravox::material {
namespace {

// Weight of a texel's colours in a mean: the visible share of them.
float ratio_weight(const Dot& dot) noexcept {
    return dot.opacity * (1 - dot.share);
}
float own_weight(const Dot& dot) noexcept {
    return dot.opacity * dot.share;
}
float hole_weight(const Dot& dot) noexcept {
    return 1 - dot.opacity;
}

using Dots = std::vector<Dot>;

template <class Weight, class Field>
voxel::Colour mean(const Dots& dots, const Weight& weight, const Field& field) {
    double r = 0;
    double g = 0;
    double b = 0;
    double sum = 0;
    for (const Dot& dot : dots) {
        const double w = static_cast<double>(weight(dot));
        const voxel::Colour c = field(dot);
        r += w * static_cast<double>(c.r);
        g += w * static_cast<double>(c.g);
        b += w * static_cast<double>(c.b);
        sum += w;
    }
    if (!(sum > 0))
        return {1, 1, 1};
    return {static_cast<float>(r / sum), static_cast<float>(g / sum), static_cast<float>(b / sum)};
}

// Scales to means of 1: of the visible part, and of what would be visible in the holes if they were
// closed.
void normalise(Dots& dots) {
    const voxel::Colour seen = mean(dots, ratio_weight, [](const Dot& d) { return d.ratio; });
    const voxel::Colour own = mean(dots, own_weight, [](const Dot& d) { return d.own; });
    const voxel::Colour closed = mean(dots, hole_weight, [](const Dot& d) { return d.ratio; });
    for (Dot& dot : dots) {
        const voxel::Colour by = dot.opacity > 0 ? seen : closed;
        dot.ratio = dot.ratio * voxel::Colour{1 / by.r, 1 / by.g, 1 / by.b};
        dot.own = dot.own * voxel::Colour{1 / own.r, 1 / own.g, 1 / own.b};
    }
}

Dots halved(const Dots& fine, int size) {
    Dots out;
    for (int t = 0; t < size; t += 2)
        for (int s = 0; s < size; s += 2) {
            const auto at = [&](int i, int j) {
                return fine[static_cast<std::size_t>((t + j) * size + s + i)];
            };
            const Dots four = {at(0, 0), at(1, 0), at(0, 1), at(1, 1)};
            Dot dot{{}, {}, 0, 0};
            float shown = 0;
            for (const Dot& d : four) {
                dot.opacity += d.opacity / 4;
                shown += d.opacity * d.share / 4;
            }
            dot.share = dot.opacity > 0 ? shown / dot.opacity : 0;
            const auto ratio = [](const Dot& d) { return d.ratio; };
            dot.ratio = ratio_weight(dot) > 0 ? mean(four, ratio_weight, ratio)
                                              : mean(four, hole_weight, ratio);
            dot.own = mean(four, own_weight, [](const Dot& d) { return d.own; });
            out.push_back(dot);
        }
    return out;
}

}  // namespace

PaintedFace TexturePool::add(const Drawing& drawing) {
    PaintedFace face;
    if (drawing.draw == nullptr)
        return face;
    for (const Known& known : m_known)
        if (known.draw == drawing.draw &&
            known.face.variants >= static_cast<std::uint32_t>(drawing.variants))
            face = known.face;
    const bool known = face.variants != 0;
    face.turn = drawing.turn;
    face.metric = drawing.metric;
    face.layered = drawing.layered;
    face.variants = static_cast<std::uint32_t>(drawing.variants);
    if (known)
        return face;
    face.first = static_cast<std::uint32_t>(m_ratio.size());
    face.own_first = static_cast<std::uint32_t>(m_own.size());
    std::vector<Canvas> canvases(static_cast<std::size_t>(drawing.variants));
    for (int v = 0; v < drawing.variants; ++v) {
        Canvas& canvas = canvases[static_cast<std::size_t>(v)];
        drawing.draw(canvas, v);
        canvas.each([&](const Dot& dot, int, int) {
            face.has_own = face.has_own || dot.share > 0;
            face.has_holes = face.has_holes || dot.opacity < 1;
        });
    }
    for (const Canvas& canvas : canvases)
        add_variant(canvas, face);
    m_known.push_back({drawing.draw, face});
    return face;
}

void TexturePool::add_variant(const Canvas& canvas, PaintedFace& face) {
    Dots dots;
    for (int t = 0; t < kTexels; ++t)
        for (int s = 0; s < kTexels; ++s)
            dots.push_back(canvas.at(s, t));
    normalise(dots);
    for (int size = kTexels; size >= 1; size /= 2) {
        for (const Dot& d : dots) {
            m_ratio.push_back({d.ratio.r, d.ratio.g, d.ratio.b, d.opacity});
            if (face.has_own)
                m_own.push_back({d.own.r, d.own.g, d.own.b, d.share});
        }
        if (size > 1)
            dots = halved(dots, size);
    }
}

Dot TexturePool::dot(const PaintedFace& face, std::uint32_t variant, int mip, int s,
                     int t) const noexcept {
    Texel found;
    const float size = static_cast<float>(kTexels >> mip);
    look_up(face,
            {variant,
             0,
             (static_cast<float>(s) + 0.5f) / size,
             (static_cast<float>(t) + 0.5f) / size,
             {mip, 0}},
            found);
    return {found.ratio, found.own, found.own_share, found.opacity};
}

void TexturePool::look_up(const PaintedFace& face, const PaintPoint& at,
                          Texel& out) const noexcept {
    // Turns without branches: a voxel's hash cannot be predicted.
    const std::uint32_t mirror_s = 0u - (at.turn & 1);
    const std::uint32_t mirror_t = 0u - (at.turn >> 1 & 1);
    const std::uint32_t swap = 0u - (at.turn >> 2 & 1);
    const std::uint32_t variant = at.variant * kMipAt[kMips];
    const auto place = [&](int mip) {
        const auto size = static_cast<float>(kTexels >> mip);
        const std::uint32_t last = (kTexels >> mip) - 1u;
        const auto to_texel = [&](float v) {
            return std::min(static_cast<std::uint32_t>(static_cast<std::int32_t>(v * size)), last);
        };
        std::uint32_t s = to_texel(at.s);
        std::uint32_t t = to_texel(at.t);
        const std::uint32_t changed = (s ^ t) & swap;
        s ^= changed ^ (mirror_s & last);
        t ^= changed ^ (mirror_t & last);
        return variant + kMipAt[static_cast<std::size_t>(mip)] + (t << (4 - mip)) + s;
    };
    const float share = at.mips.coarse_share;
    const std::uint32_t fine = place(at.mips.fine);
    const std::uint32_t coarse = share > 0 ? place(at.mips.fine + 1) : fine;
    const auto mixed = [&](const Packed& a, const Packed& b) {
        Packed sum;
        for (std::size_t i = 0; i < 4; ++i)
            sum[i] = a[i] * (1 - share) + b[i] * share;
        return sum;
    };
    const Packed ratio = mixed(m_ratio[face.first + fine], m_ratio[face.first + coarse]);
    out.ratio = {ratio[0], ratio[1], ratio[2]};
    out.opacity = ratio[3];
    if (!face.has_own)
        return;
    const Packed own = mixed(m_own[face.own_first + fine], m_own[face.own_first + coarse]);
    out.own = {own[0], own[1], own[2]};
    out.own_share = own[3];
}

}  // namespace terravox::material
