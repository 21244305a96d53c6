#include "raytracer/core/tiles/tile.hpp"

#include <cmath>

namespace terravox::tiles {
namespace {

// With equal weights for what has none.
float measure_share(float own, float others) noexcept {
    return own + others > 0 ? others / (own + others) : 0.5f;
}

void mix_into(voxel::Colour& own, voxel::Colour more, float share) noexcept {
    own = voxel::mix(own, more, share);
}
void mix_into(float& own, float more, float share) noexcept {
    own += (more - own) * share;
}
void mix_into(std::array<float, 3>& own, const std::array<float, 3>& more, float share) noexcept {
    for (std::size_t i = 0; i < 3; ++i)
        mix_into(own[i], more[i], share);
}
void mix_into(Matte& own, const Matte& more, float share) noexcept {
    own.scale(1 - share);
    for (std::size_t i = 0; i < Matte::kMax; ++i)
        if (more.share[i] > 0)
            own.add(more.object[i], more.share[i] * share);
}

}  // namespace

bool PixelSample::is_known(double share) const noexcept {
    constexpr double kDark = 0.02;  // below this a small relative error is invisible
    return samples > 1 &&
           static_cast<double>(error) <=
               share * std::max(static_cast<double>(voxel::luminance(colour)), kDark);
}

void PixelSample::merge(const PixelSample& more) noexcept {
    const auto own = static_cast<float>(samples);
    const auto others = static_cast<float>(more.samples);
    const auto own_hits = own * alpha;
    const auto other_hits = others * more.alpha;
    const float share = measure_share(own, others);
    mix_into(colour, more.colour, share);
    mix_into(alpha, more.alpha, share);
    if (own_hits > 0 && other_hits > 0)
        mix_into(depth_m, more.depth_m, measure_share(own_hits, other_hits));
    else if (other_hits > 0)
        depth_m = more.depth_m;
    error = std::sqrt(own * own * error * error + others * others * more.error * more.error) /
            (own + others);
    samples += more.samples;
}

void LayerSample::merge(const LayerSample& more, float own, float others, float own_hits,
                        float other_hits) noexcept {
    const float share = measure_share(own, others);
    const float hit_share = own_hits + other_hits > 0 ? measure_share(own_hits, other_hits) : 0;
    mix_into(direct, more.direct, share);
    mix_into(indirect, more.indirect, share);
    mix_into(albedo, more.albedo, hit_share);
    mix_into(normal, more.normal, hit_share);
    mix_into(position, more.position, hit_share);
    mix_into(sun, more.sun, hit_share);
    mix_into(water, more.water, hit_share);
    if (material == voxel::Material::kAir)
        material = more.material;
    mix_into(materials, more.materials, share);
    mix_into(squares, more.squares, share);
}

}  // namespace terravox::tiles
