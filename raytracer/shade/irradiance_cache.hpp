#pragma once

#include <cstddef>

#include "common/voxel/colour.hpp"
#include "raytracer/shade/cache_table.hpp"
#include "raytracer/shade/face_cell.hpp"

namespace terravox::shade {

/// Light that arrives at a cell, as the radiance that a white matt face reflects.
struct FaceLight {
    voxel::Colour direct;    ///< from the sky without a detour; for bounced light all of it
    voxel::Colour indirect;  ///< by way of other faces
};

/// Another cell's light that a gather ray ends on, and the share of it that arrives.
struct GatherLink {
    FaceCell key;  ///< FaceCell::light()
    voxel::Colour weight;
};

/// Irradiance of faces, for all pixels, samples and frames that share a world and its light. Each
/// value is a pure function of world, light and key, so that eviction, threads and the order of
/// requests change nothing but time. Thread-safe.
/// Ref: Ward, Rubinstein & Clear, "A Ray Tracing Solution for Diffuse Interreflection", SIGGRAPH
/// 1988.
class IrradianceCache {
public:
    /// @param limit_bytes of memory, which is taken as it is filled
    explicit IrradianceCache(std::size_t limit_bytes) : m_lights(limit_bytes) {}

    /// @param key FaceCell::light()
    [[nodiscard]] bool find(const FaceCell& key, FaceLight& out) { return m_lights.find(key, out); }
    void insert(const FaceCell& key, const FaceLight& light) { m_lights.insert(key, light); }

private:
    CacheTable<FaceLight> m_lights;
};

}  // namespace terravox::shade
