#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/farm/render/passes/passes.hpp"

namespace terravox::preview {

/// A picture that is rendered progressively, in time slices of the caller: passes from coarse to
/// fine with one sample of each pixel, then more samples. A new picture begins at once and cancels
/// the old one. Used by one thread.
class Progressive {
public:
    using Clock = std::chrono::steady_clock;
    /// Makes the processor that renders a picture of this view. It is called again only after the
    /// last processor has been destroyed.
    using Begin = std::function<std::shared_ptr<processors::TileProcessor>(const shade::View&)>;

    Progressive(blocks::BlockManager& blocks, Begin begin)
        : m_blocks(blocks), m_begin(std::move(begin)) {}
    ~Progressive() { stop(); }

    /// Starts a picture. The film keeps the old pixels until tiles of the new picture replace them.
    /// @param first_step edge of the first pass's pixels, a power of two
    /// @throws UsageError for an invalid scene; then no picture is in progress
    void start(const scene::Scene& scene, int first_step);
    void stop() noexcept;

    /// Works for at least a millisecond, until then or until the picture is finished: traces, if a
    /// green processor takes part, and waits for the other processors.
    /// @throws what a tile threw; the picture is stopped then
    void work(Clock::time_point until);

    [[nodiscard]] bool busy() const noexcept { return m_processor != nullptr; }
    /// Whether each pixel is of this picture, if only coarse.
    [[nodiscard]] bool whole() const noexcept { return m_progress.whole; }
    /// The film; nullptr before the first start().
    [[nodiscard]] const output::Film* film() const noexcept { return m_film.get(); }
    [[nodiscard]] const std::shared_ptr<const shade::View>& view() const noexcept { return m_view; }

    /// Tiles that were added to the film since the last call. Their coarse pixels may extend beyond
    /// them.
    [[nodiscard]] std::vector<tiles::RenderTile> take_changes() {
        return std::exchange(m_changes, {});
    }

    struct Status {
        int step = 0;                  ///< edge of the pixels of the pass in progress
        std::uint32_t samples = 0;     ///< finished samples of each pixel
        std::uint32_t of_samples = 0;  ///< samples of each pixel when all passes are done
        double share = 0;              ///< finished fraction of the pass, or of the samples
        double first_s = 0;            ///< time until each pixel was of this picture; 0: not yet
        double seconds = 0;  ///< time since the start; of a finished picture its total time
        std::uint64_t rays = 0;
        std::size_t holes = 0;
    };
    [[nodiscard]] Status status() const;
    /// Holes that the picture's rays met.
    [[nodiscard]] const std::set<voxel::BoxKey>& holes() const noexcept { return m_progress.holes; }
    /// Time that ending the previous picture took, cancellation included.
    [[nodiscard]] double last_stop_s() const noexcept { return m_stop_s; }

private:
    /// Tiles of the pass in progress, or those that get more samples.
    struct Pass {
        std::vector<tiles::RenderTile> tiles;
        std::size_t submitted = 0;
        std::set<std::uint32_t> done;  ///< indices of finished tiles
    };
    /// The state of the picture since its start.
    struct Progress {
        Clock::time_point start;
        bool whole = false;
        std::uint32_t samples = 0;  ///< samples of each pixel of the finished passes
        std::uint64_t rays = 0;
        std::set<voxel::BoxKey> holes;
        double first_s = 0;  ///< as in Status
        double all_s = 0;    ///< total time of a finished picture
    };
    void plan();
    void next_pass();
    void add(const tiles::TileResult& result);
    [[nodiscard]] double seconds() const noexcept {
        return std::chrono::duration<double>(Clock::now() - m_progress.start).count();
    }

    blocks::BlockManager& m_blocks;
    const Begin m_begin;
    shade::ViewMaker m_views{analyse::measure};
    std::shared_ptr<const shade::View> m_view;
    std::unique_ptr<output::Film> m_film;
    /// Set while a picture is in progress; destroyed before the view.
    std::shared_ptr<processors::TileProcessor> m_processor;
    std::vector<std::vector<tiles::RenderTile>> m_passes;
    std::size_t m_next_pass = 0;  ///< index in m_passes
    Pass m_pass;
    std::vector<tiles::RenderTile> m_changes;
    int m_first_step = 1;
    Progress m_progress;
    double m_stop_s = 0;
};

}  // namespace terravox::preview
