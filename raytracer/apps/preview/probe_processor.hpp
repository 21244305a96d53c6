#pragma once

#include <deque>

#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/core/walk/walk.hpp"
#include "raytracer/farm/processors/processor.hpp"

namespace terravox::preview {

/// Makes tiles that show how the middle ray of each pixel is walked, as colours for a screen:
/// levels, steps, boxes in memory. It does not wait for boxes: where one is missing, the pixel
/// shows that, and the box is requested. It works in wait() and take(), on the caller's thread.
/// Used by one thread.
class ProbeProcessor final : public processors::TileProcessor {
public:
    /// @param view, blocks outlive the processor
    /// @param layer a probe layer (is_probe)
    ProbeProcessor(const shade::View& view, blocks::BlockManager& blocks, Layer layer);

    [[nodiscard]] int capacity() const noexcept override { return 1'000'000; }
    void submit(tiles::RenderTile tile) override { m_waiting.push_back(tile); }
    [[nodiscard]] bool wait(std::chrono::milliseconds timeout) override {
        return m_result || m_closed || trace_until(std::chrono::steady_clock::now() + timeout);
    }
    std::optional<tiles::TileResult> take() override;
    void close() noexcept override { m_closed = true; }
    void cancel() noexcept override {
        m_closed = true;
        m_waiting.clear();
    }

    /// Number of boxes that were missing so far, so that the tiles are incomplete.
    [[nodiscard]] std::size_t missing() const noexcept { return m_missing.size(); }

private:
    [[nodiscard]] voxel::Colour probe(double px, double py, tiles::PixelSample& sample);
    [[nodiscard]] bool trace_until(std::chrono::steady_clock::time_point until);

    const shade::View& m_view;
    blocks::BlockManager& m_blocks;
    const Layer m_layer;
    walk::BlockReader m_reader;
    walk::RayWalk m_walk;
    std::deque<tiles::RenderTile> m_waiting;
    std::optional<tiles::TileResult> m_result;  ///< the finished tile
    tiles::TileResult m_under_way;
    /// Pixels of m_under_way; those from m_next on are to be done.
    std::vector<std::pair<int, int>> m_pixels;
    std::size_t m_next = 0;
    std::set<voxel::BoxKey> m_missing;
    bool m_closed = false;
    bool m_begun = false;
};

}  // namespace terravox::preview
