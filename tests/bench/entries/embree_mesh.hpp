#pragma once

#include <cstddef>
#include <vector>

#include "tests/bench/entries/neutral_scene.hpp"

namespace terravox::bench {

/// Rectangles; each has four corners of its own.
struct QuadMesh {
    std::vector<float> corners;  ///< x, y, z of the corners in order around each quad
    [[nodiscard]] std::size_t quads() const noexcept { return corners.size() / 12; }
};

/// Every face of the scene between solid and air, as slabs along x from one end to the other. Faces
/// that do not look along z are joined to runs along it. @param threads that work on slabs
[[nodiscard]] std::vector<QuadMesh> mesh_slabs(const NeutralScene& scene, int threads);

}  // namespace terravox::bench
