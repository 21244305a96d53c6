#pragma once

#include <cstddef>
#include <memory>

#include "tests/bench/entries/tile_tracer.hpp"

namespace terravox::bench {

/// The peer on the neutral scene: Embree 4 or 3 on a mesh of every face between solid and air, runs
/// of faces along z as one quad. Primary rays go in packets of 16 (4 x 4 pixels), shadow rays one
/// by one.
class EmbreeScene : public TileTracer {
public:
    /// What it took to make, and what it keeps.
    struct Building {
        double mesh_s = 0;
        double bvh_s = 0;
        std::size_t quads = 0;
        std::size_t mesh_bytes = 0;
        std::size_t bvh_bytes = 0;
        [[nodiscard]] double seconds() const noexcept { return mesh_s + bvh_s; }
        [[nodiscard]] std::size_t bytes() const noexcept { return mesh_bytes + bvh_bytes; }
    };
    [[nodiscard]] virtual const Building& building() const noexcept = 0;
};

/// @param threads that build; @return nullptr in a build without Embree (Debian package
/// libembree-dev) @throws Error
[[nodiscard]] std::unique_ptr<EmbreeScene> make_embree_scene(const NeutralScene& scene,
                                                             int threads);

}  // namespace terravox::bench
