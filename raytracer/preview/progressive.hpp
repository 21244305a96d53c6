#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "raytracer/output/film.hpp"
#include "raytracer/render/render.hpp"
#include "raytracer/shade/view_maker.hpp"

namespace terravox::preview {

/// A picture that refines itself, in slices of somebody's time: passes coarse to fine with one
/// sample of each pixel, then more samples. A new one begins at once; what was under way for the
/// old one is given up. Used by one thread.
class Progressive {
public:
    using Clock = std::chrono::steady_clock;
    /// Who renders a picture of this view. The next is asked for when nobody owns the last any
    /// more.
    using Begin = std::function<std::shared_ptr<processors::TileProcessor>(const shade::View&)>;

    Progressive(blocks::BlockManager& blocks, Begin begin)
        : m_blocks(blocks), m_begin(std::move(begin)) {}
    ~Progressive() { stop(); }

    /// What is seen stays until tiles of the new picture take its place. @param first_step edge of
    /// the first pass's pixels, a power of two
    /// @throws UsageError for a scene that cannot be; then there is no picture under way
    void start(const scene::Scene& scene, int first_step);
    void stop() noexcept;

    /// Goes on until then, a millisecond at the least, or until the picture is finished: traces,
    /// where green takes part, and waits for others.
    /// @throws what a tile threw; the picture is stopped then
    void work(Clock::time_point until);

    [[nodiscard]] bool busy() const noexcept { return m_processor != nullptr; }
    [[nodiscard]] bool whole() const noexcept {
        return m_progress.whole;
    }  ///< each pixel is of this picture, if coarse
    /// Nothing before the first start().
    [[nodiscard]] const output::Film* film() const noexcept { return m_film.get(); }
    [[nodiscard]] const std::shared_ptr<const shade::View>& view() const noexcept { return m_view; }

    /// Tiles that have come into the film since the last call. Their coarse pixels may reach beyond
    /// them.
    [[nodiscard]] std::vector<tiles::RenderTile> take_changes() {
        return std::exchange(m_changes, {});
    }

    struct Status {
        int step = 0;                               ///< of the pass under way
        std::uint32_t samples = 0, of_samples = 0;  ///< of each pixel, once all passes are done
        double share = 0;                           ///< done of the pass, or of the samples
        double first_s = 0;  ///< until each pixel was of this picture; 0: not yet
        double seconds = 0;  ///< since it began; of a finished one: all
        std::uint64_t rays = 0;
        std::size_t holes = 0;
    };
    [[nodiscard]] Status status() const;
    [[nodiscard]] const std::set<voxel::BoxKey>& holes() const noexcept {
        return m_progress.holes;
    }  ///< that its rays met
    /// Time that ending the picture before took: cancelling what was under way, and more.
    [[nodiscard]] double last_stop_s() const noexcept { return m_stop_s; }

private:
    /// Tiles of the pass in progress, or those that get more samples.
    struct Pass {
        std::vector<tiles::RenderTile> tiles;
        std::size_t submitted = 0;
        std::set<std::uint32_t> done;  ///< by index
    };
    /// What is known of the picture, from its start.
    struct Progress {
        Clock::time_point start;
        bool whole = false;
        std::uint32_t samples = 0;  ///< of each pixel, of passes that are done
        std::uint64_t rays = 0;
        std::set<voxel::BoxKey> holes;
        double first_s = 0, all_s = 0;
    };
    void plan();
    void next_pass();
    void add(const tiles::TileResult& result);
    [[nodiscard]] double seconds() const noexcept {
        return std::chrono::duration<double>(Clock::now() - m_progress.start).count();
    }

    blocks::BlockManager& m_blocks;
    const Begin m_begin;
    shade::ViewMaker m_views;
    std::shared_ptr<const shade::View> m_view;
    std::unique_ptr<output::Film> m_film;
    std::shared_ptr<processors::TileProcessor>
        m_processor;  ///< of a picture under way; goes before the view
    std::vector<std::vector<tiles::RenderTile>> m_passes;
    std::size_t m_next_pass = 0;  ///< index in m_passes
    Pass m_pass;
    std::vector<tiles::RenderTile> m_changes;
    int m_first_step = 1;
    Progress m_progress;
    double m_stop_s = 0;
};

}  // namespace terravox::preview
