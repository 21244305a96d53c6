#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "raytracer/output/film.hpp"
#include "raytracer/scene/scene.hpp"
#include "raytracer/shade/view.hpp"
#include "raytracer/world/block_manager.hpp"

namespace terravox {

/// A picture that refines itself in the background, pass by pass, and starts again when the scene changes.
///
/// One coordinator thread runs the passes through a ThreadProcessor. start() stops the one before (its tiles end at the next
/// pixel), then begins anew. Finished tiles are developed straight into an 8-bit picture under `m_mutex`; the window copies that.
class Progressive {
public:
    Progressive(BlockManager& blocks, int threads) : m_blocks(blocks), m_threads(threads) {}
    ~Progressive();

    /// @throws UsageError for a scene that cannot be (camera inside rock, ...); what ran before has ended then
    void start(const Scene& scene);
    void stop() noexcept;

    struct Status {
        std::uint64_t tiles_done = 0, tiles_total = 0, rays = 0;
        double seconds = 0;
        bool finished = false;
    };
    [[nodiscard]] Status status() const;
    /// Copies the picture (RGB, 8-bit sRGB, rows from the top) when it changed since `seen`, which is updated.
    /// @return false when there is nothing new
    bool copy_if_new(std::vector<std::uint8_t>& rgb, int& width_px, int& height_px, std::uint64_t& seen) const;
    /// Rethrows what ended the last picture early, if anything did.
    void check();

private:
    void run(const View& view);
    void develop_tile(const View& view, const Film& film, const RenderTile& tile);
    BlockManager& m_blocks;
    int m_threads;
    std::thread m_thread;
    std::atomic<bool> m_stop{false};
    mutable std::mutex m_mutex;
    std::vector<std::uint8_t> m_rgb;
    int m_width = 0, m_height = 0;
    std::uint64_t m_version = 0;
    Status m_status;
    std::exception_ptr m_failure;
};

}  // namespace terravox
