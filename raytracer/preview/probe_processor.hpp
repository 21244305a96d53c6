#pragma once

#include <deque>

#include "raytracer/preview/layers.hpp"
#include "raytracer/processors/processor.hpp"
#include "raytracer/walk/walk.hpp"

namespace terravox::preview {

/// Tiles of what walking the middle ray of each pixel takes, as colours for a screen: levels,
/// steps, what is in memory. It waits for no box: where one is missing, the pixel says so, and the
/// box is asked for. It works while somebody waits for it, on their thread, and is for one thread.
class ProbeProcessor final : public processors::TileProcessor {
public:
    /// @param layer of which is_probe() says so @param view, blocks outlive the processor
    ProbeProcessor(const shade::View& view, blocks::BlockManager& blocks, Layer layer);

    [[nodiscard]] int capacity() const noexcept override { return 1'000'000; }
    void submit(tiles::RenderTile tile) override { m_waiting.push_back(tile); }
    [[nodiscard]] bool wait(std::chrono::milliseconds most) override;
    std::optional<tiles::TileResult> take() override;
    void close() noexcept override { m_closed = true; }
    void cancel() noexcept override {
        m_closed = true;
        m_waiting.clear();
    }

    /// Boxes that were missing so far: what is shown is not all there is.
    [[nodiscard]] std::size_t missing() const noexcept { return m_missing.size(); }

private:
    [[nodiscard]] voxel::Colour probe(double px, double py, tiles::PixelSample& sample);
    [[nodiscard]] bool go_on(std::chrono::steady_clock::time_point until);

    const shade::View& m_view;
    blocks::BlockManager& m_blocks;
    const Layer m_layer;
    walk::BlockReader m_reader;
    walk::RayWalk m_walk;
    std::deque<tiles::RenderTile> m_waiting;
    std::optional<tiles::TileResult> m_result;  ///< finished
    tiles::TileResult m_under_way;
    std::vector<std::pair<int, int>> m_pixels;  ///< of it, still to do from m_next on
    std::size_t m_next = 0;
    std::set<voxel::BoxKey> m_missing;
    bool m_closed = false, m_begun = false;
};

}  // namespace terravox::preview
