#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "common/voxel/colour.hpp"
#include "common/voxel/material.hpp"

namespace terravox::tiles {

/// Which things cover a pixel, and how much of it: the most covering first once sorted.
struct Matte {
    static constexpr std::size_t kMax = 6;
    std::array<std::uint32_t, kMax> object{};
    std::array<float, kMax> share{};  ///< of the pixel, [0, 1]; 0: none from here on

    /// More of one thing. Of more things than there is room for, the one that comes too late is
    /// left out.
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

/// What the first things are that a pixel's rays meet. Means over the samples that meet any, but
/// for the light, which is over all.
struct LayerSample {
    voxel::Colour direct;    ///< light that came to the first hit from sun and sky alone; with
                             ///< `indirect` it makes the pixel's colour
    voxel::Colour indirect;  ///< by way of other things
    voxel::Colour albedo;    ///< share of light that the surface sends back; 0 where none is hit
    std::array<float, 3> normal{};    ///< x east, y up, z south
    std::array<float, 3> position{};  ///< metres from PictureFrame's origin, the same axes
    float sun = 0;                    ///< share of the first hits' sun that is not in shadow
    float water = 0;                  ///< share of samples that meet water first
    voxel::Material material = voxel::Material::kAir;  ///< of the sample that came first
    Matte materials;                                   ///< voxel::Material
    Matte squares;                                     ///< index in the SquareGrid

    /// The means with more samples. @param own, others samples that each stands for @param
    /// own_hits, other_hits those of them that met anything
    void merge(const LayerSample& more, float own, float others, float own_hits,
               float other_hits) noexcept;
};

}  // namespace terravox::tiles
