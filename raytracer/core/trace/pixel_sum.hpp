#pragma once

#include "raytracer/core/shade/shading.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/trace/batch_means.hpp"

namespace terravox::trace {

/// The sum of a pixel's samples.
class PixelSum {
public:
    void add(const shade::SampleSum& sample) noexcept;
    [[nodiscard]] int count() const noexcept { return m_count; }
    /// Mean of at least one sample.
    /// @param voxel_m edge of a level-0 voxel
    [[nodiscard]] tiles::PixelSample mean(double voxel_m) const noexcept;

private:
    double m_colour[3] = {}, m_t = 0;
    BatchMeans m_brightness;
    int m_count = 0;
    int m_hits = 0;
};

/// The sum of the first hits of a pixel's samples.
class LayerSum {
public:
    void add(const shade::SampleSum& sample, const shade::View& view) noexcept;
    [[nodiscard]] tiles::LayerSample mean() const noexcept;

private:
    double m_direct[3] = {}, m_indirect[3] = {}, m_albedo[3] = {}, m_normal[3] = {},
           m_position[3] = {};
    double m_sun = 0;
    int m_count = 0;
    int m_hits = 0;
    int m_water = 0;
    voxel::Material m_material = voxel::Material::kAir;
    tiles::Matte m_materials;
    tiles::Matte m_squares;
};

}  // namespace terravox::trace
