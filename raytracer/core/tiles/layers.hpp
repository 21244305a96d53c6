#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "common/voxel/colour.hpp"
#include "common/voxel/material.hpp"

namespace terravox::tiles {

/// Which things cover a pixel, and how much of it; by descending share once sorted.
struct Matte {
    static constexpr std::size_t kMax = 6;
    std::array<std::uint32_t, kMax> object{};
    std::array<float, kMax> share{};  ///< of the pixel, [0, 1]; 0: no more entries

    /// Adds to the share of a thing. When there is no room for another thing, it is left out.
    void add(std::uint32_t what, float more) noexcept {
        for (std::size_t i = 0; i < kMax; ++i) {
            if (share[i] > 0 && object[i] != what)
                continue;
            object[i] = what;
            share[i] += more;
            return;
        }
    }
    void scale(float by) noexcept {
        for (float& s : share)
            s *= by;
    }
};

/// What a pixel's rays hit first. Means over the samples that hit anything, except for the light,
/// which is averaged over all samples.
struct LayerSample {
    /// Light that reached the first hit directly from sun and sky; `direct` + `indirect` is the
    /// pixel's colour.
    voxel::Colour direct;
    voxel::Colour indirect;  ///< by way of other surfaces
    voxel::Colour albedo;    ///< share of light that the surface reflects; 0 where nothing is hit
    std::array<float, 3> normal{};    ///< x east, y up, z south
    std::array<float, 3> position{};  ///< metres from PictureFrame's origin, the same axes
    float sun = 0;                    ///< share of the first hits' sunlight that is not in shadow
    float water = 0;                  ///< share of samples that hit water first
    voxel::Material material = voxel::Material::kAir;  ///< of the first sample
    Matte materials;                                   ///< voxel::Material
    Matte squares;                                     ///< index in the SquareGrid

    /// Combines the means with those of more samples.
    /// @param own, others number of samples that each stands for
    /// @param own_hits, other_hits number of those that hit anything
    void merge(const LayerSample& more, float own, float others, float own_hits,
               float other_hits) noexcept;
};

}  // namespace terravox::tiles
