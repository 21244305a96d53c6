#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/trace/tile_pixels.hpp"
#include "raytracer/core/walk/packet_walk.hpp"
#include "raytracer/core/walk/shaft.hpp"
#include "raytracer/core/walk/walk.hpp"
#include "tests/bench/entries/tile_tracer.hpp"

namespace terravox::bench {

/// Our own tracer on the neutral scene. Its rays are traced in trace_primary and trace_shadow and
/// nowhere else.
class NeutralTracer final : public TileTracer {
public:
    /// @param world outlives the tracer; all its boxes fit into memory
    /// @param threads maximum number of threads that call at the same time
    NeutralTracer(NeutralWorld& world, int threads);

    void begin(const NeutralView& view) override;
    void trace_primary(int x0, int y0, int thread) override;
    void trace_shadow(int x0, int y0, int thread) override;
    [[nodiscard]] std::size_t hits() const override;
    [[nodiscard]] std::size_t shadowed() const override;

private:
    /// What a pixel's rays found.
    struct Seen {
        double t = 0;  ///< along the primary ray
        core::VoxelCoord voxel;
        core::Face face = core::Face::kNone;
        bool hit = false;
        bool shadowed = false;
    };
    struct Worker {
        Worker(blocks::BlockManager& blocks, const walk::LevelCut& cut)
            : reader(blocks),
              walk(reader, cut),
              packets(walk::packet_walk(reader, cut)),
              beams(reader, cut),
              shafts(reader, cut) {}
        walk::BlockReader reader;
        walk::RayWalk walk;
        std::optional<walk::PacketWalk> packets;
        walk::BeamMarch beams;
        walk::ShaftMarch shafts;
        walk::Occluder occluder;
        std::vector<trace::PixelBlock> tile_blocks;
    };
    void trace_block(int x0, int y0, const trace::PixelBlock& block, Worker& worker);
    void trace_single(int x, int y, core::RayState& ray, Worker& worker);
    walk::LevelCut m_cut;
    blocks::BlockManager m_blocks;
    std::vector<std::unique_ptr<Worker>> m_workers;
    std::optional<scene::Camera> m_camera;
    std::vector<Seen> m_seen;  ///< row by row
};

}  // namespace terravox::bench
