#include "raytracer/farm/render/passes/passes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_set>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/core/output/progress.hpp"
#include "raytracer/core/tiles/tile_plan.hpp"
#include "raytracer/farm/processors/processor_pool.hpp"

namespace terravox::render {
namespace {

constexpr std::size_t kMaxForeseen = 65'536;
constexpr std::chrono::milliseconds kStopPeriod{50};

/// Passes tiles through the processor to their destination.
class PassRunner {
public:
    PassRunner(const RenderJob& job, output::TileSink& sink, output::Progress& progress)
        : m_job(job), m_sink(sink), m_progress(progress) {}

    /// @return false: no processor is left to render, and the waiting time is over
    bool run(const std::vector<tiles::RenderTile>& tiles) {
        std::size_t submitted = 0;
        std::unordered_set<std::uint32_t> done;
        while (done.size() < tiles.size()) {
            while (submitted < tiles.size() &&
                   submitted - done.size() < static_cast<std::size_t>(m_job.processor.capacity()))
                m_job.processor.submit(tiles[submitted++]);
            // A world may take minutes for a box: a request to stop must be noticed all the same.
            while (!m_job.processor.wait(kStopPeriod) && !m_job.stop.stop_requested())
                m_progress.look(m_job.details);
            if (m_job.stop.stop_requested()) {
                m_job.processor.cancel();
                throw util::Error("render: interrupted; no picture was written" + kept());
            }
            try {
                forget_invalidated(tiles);
                const auto result = m_job.processor.take();
                if (!result)
                    throw util::Error(
                        "render: the processor ended before the picture was finished");
                // The world knows of a hole before a tile that has it can be finished.
                check_world();
                add(*result, done.insert(result->tile.index).second);
            } catch (const processors::NoProcessorsLeft& e) {
                check_world();
                util::log_error("{}", e.what());
                // Those are not correct, either.
                m_counts.missing += tiles.size() - done.size() + m_invalidated.size();
                return false;
            }
        }
        return true;
    }
    /// Adds the tiles of the checkpoint to the picture.
    /// @return the tiles that are left to render
    std::vector<tiles::RenderTile> resume(std::vector<tiles::RenderTile> tiles) {
        if (m_job.part) {
            const int edge_px =
                m_job.view.scene.quality.tile.in_picture(m_job.view.scene.output.size_px[0]);
            std::erase_if(tiles, [&](const tiles::RenderTile& t) {
                return !m_job.part->has(static_cast<std::uint32_t>(t.x0 / edge_px),
                                        static_cast<std::uint32_t>(t.y0 / edge_px));
            });
        }
        if (m_job.checkpoint == nullptr)
            return tiles;
        m_job.checkpoint->each([&](tiles::TileResult&& result) {
            m_sink.add(result);
            ++m_counts.resumed;
            m_counts.holes.insert(result.holes.begin(), result.holes.end());
        });
        std::erase_if(tiles, [&](const tiles::RenderTile& t) { return m_job.checkpoint->has(t); });
        return tiles;
    }
    [[nodiscard]] RenderCounts& counts() noexcept {
        for (auto& [tile, holes] : std::exchange(m_holes, {}))
            m_counts.holes.merge(holes);
        return m_counts;
    }

private:
    void check_world() const {
        try {
            if (m_job.check_world)
                m_job.check_world();
        } catch (...) {
            m_job.processor.cancel();
            throw;
        }
    }
    // At once: a process that is killed now must not resume with them.
    void forget_invalidated(const std::vector<tiles::RenderTile>& tiles) {
        for (const std::uint32_t index : m_job.processor.take_invalidated())
            for (const tiles::RenderTile& t : tiles)
                if (t.index == index && m_invalidated.insert(index).second &&
                    m_job.checkpoint != nullptr)
                    m_job.checkpoint->forget(t);
    }
    [[nodiscard]] std::string kept() const {
        return m_job.checkpoint == nullptr
                   ? ""
                   : "; " + std::to_string(m_job.checkpoint->count()) + " tiles are kept in " +
                         m_job.checkpoint->path().string() + ", --resume goes on with them";
    }
    void add(const tiles::TileResult& result, bool first) {
        if (!first && !m_sink.replaces())
            throw processors::PictureInvalidated(
                "render: a tile that is in the picture already was not right");
        if (m_job.checkpoint != nullptr) {
            if (m_job.damage)
                m_job.checkpoint->note_damage(m_job.damage());
            m_job.checkpoint->add(result);
        }
        m_sink.add(result);
        const std::pair key{result.tile.pass, result.tile.index};
        if (result.holes.empty())
            m_holes.erase(key);
        else
            m_holes[key] = result.holes;
        m_invalidated.erase(result.tile.index);
        if (!first)
            return;  // its rays are counted
        ++m_counts.tiles;
        m_counts.trace.add(result.counts);
        m_progress.tile_done(result.samples.size(), result.counts.all_rays());
        if (m_job.on_progress)
            m_job.on_progress(m_counts.tiles, m_progress.total_tiles());
        m_progress.look(m_job.details);
    }

    const RenderJob& m_job;
    output::TileSink& m_sink;
    output::Progress& m_progress;
    RenderCounts m_counts;
    std::set<std::uint32_t> m_invalidated;  ///< tiles in the picture that come again
    /// By pass and tile; of later samples as of the first.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::set<voxel::BoxKey>> m_holes;
};

std::uint64_t count_pixels(const std::vector<tiles::RenderTile>& tiles) {
    std::uint64_t out = 0;
    for (const tiles::RenderTile& t : tiles)
        out += processors::LeaseBook::count_pixels(t);
    return out;
}

/// Adds more samples to the whole picture, as many again as it has, as long as there is time; tiles
/// whose noise is low enough are skipped.
/// @return samples per pixel at the end
std::uint32_t add_samples(const RenderJob& job, const std::vector<tiles::RenderTile>& tiles,
                          const output::Film& film, std::uint32_t samples, PassRunner& runner) {
    const auto& q = job.view.scene.quality;
    const auto seconds = [start = job.start] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    double per_sample_s = seconds() / samples;
    while (samples < static_cast<std::uint32_t>(q.samples)) {
        const double before = seconds();
        const double left = q.time_s - before;
        const auto affordable =
            static_cast<std::uint32_t>(std::clamp(left / std::max(per_sample_s, 1e-6), 0.0, 1e6));
        const std::uint32_t more =
            std::min({affordable, samples, static_cast<std::uint32_t>(q.samples) - samples});
        if (more == 0)
            break;
        std::vector<tiles::RenderTile> noisy;
        for (tiles::RenderTile tile : tiles) {
            tile.first_sample = samples;
            tile.samples = more;
            // Two samples may agree by coincidence.
            if (q.noise == 0 || samples < static_cast<std::uint32_t>(q.min_samples) ||
                film.error_above(tile, q.noise))
                noisy.push_back(tile);
        }
        if (noisy.empty() || !runner.run(noisy))
            break;
        samples += more;
        per_sample_s = (seconds() - before) / more;
    }
    return samples;
}

}  // namespace

void RenderCounts::add(const RenderCounts& other) {
    trace.add(other.trace);
    tiles += other.tiles;
    samples = std::max(samples, other.samples);
    holes.insert(other.holes.begin(), other.holes.end());
    resumed += other.resumed;
    missing += other.missing;
}

void RenderCounts::add(const tiles::TileResult& tile) {
    ++tiles;
    trace.add(tile.counts);
    holes.insert(tile.holes.begin(), tile.holes.end());
}

RenderCounts render_stream(const RenderJob& job, output::TileSink& sink) {
    const auto& scene = job.view.scene;
    const auto [width, height] = scene.output.size_px;
    const auto passes = tiles::plan_tiles(width, height, 1, scene.quality.tile.in_picture(width),
                                          scene.quality.tile_order);
    output::Progress progress(passes.front().size(), count_pixels(passes.front()), job.quiet);
    PassRunner runner(job, sink, progress);
    const auto tiles = runner.resume(passes.front());
    progress.leave_out(passes.front().size() - tiles.size(),
                       count_pixels(passes.front()) - count_pixels(tiles));
    (void)runner.run(tiles);
    runner.counts().samples = static_cast<std::uint32_t>(scene.quality.samples);
    progress.finish();
    return std::move(runner.counts());
}

RenderCounts render_film(const RenderJob& job, output::Film& film) {
    const auto& q = job.view.scene.quality;
    auto passes = tiles::plan_tiles(film.width_px(), film.height_px(), q.coarse_step,
                                    q.tile.in_picture(film.width_px()), q.tile_order);
    std::uint64_t pixels = 0;
    for (const auto& tiles : passes)
        pixels += count_pixels(tiles);
    output::Progress progress(passes.size() * passes.front().size(), pixels, job.quiet, q.time_s);
    PassRunner runner(job, film, progress);
    const bool in_time = q.time_s > 0;
    constexpr int kFirstSamples = 2;
    const auto first =
        static_cast<std::uint32_t>(in_time ? std::min(kFirstSamples, q.samples) : q.samples);
    for (auto& tiles : passes) {
        for (tiles::RenderTile& tile : tiles)
            tile.samples = first;
        if (job.checkpoint != nullptr) {
            const std::size_t before = tiles.size();
            const std::uint64_t before_px = count_pixels(tiles);
            tiles = runner.resume(std::move(tiles));
            progress.leave_out(before - tiles.size(), before_px - count_pixels(tiles));
        }
        if (!runner.run(tiles))
            break;
    }
    if (in_time && runner.counts().missing == 0) {
        const auto whole = tiles::plan_tiles(film.width_px(), film.height_px(), 1,
                                             q.tile.in_picture(film.width_px()), q.tile_order);
        runner.counts().samples = add_samples(job, whole.front(), film, first, runner);
    } else {
        runner.counts().samples = first;
    }
    progress.finish();
    return std::move(runner.counts());
}

namespace {

/// A position in map coordinates: easting and northing in units of the CRS, height in metres;
/// without a CRS in voxels.
std::string find_place(core::Vec3 at, const voxel::WorldInfo& world) {
    const bool placed = !world.crs.empty();
    const core::Vec3 p = placed
                             ? core::Vec3{at.x * world.crs_units_per_voxel,
                                          -at.z * world.crs_units_per_voxel, at.y * world.voxel_m}
                             : at;
    const auto whole = [](double v) {
        return std::to_string(static_cast<std::int64_t>(std::floor(v + 0.5)));
    };
    return whole(p.x) + ", " + whole(p.y) + ", " + whole(p.z) +
           (placed && world.crs_units_per_voxel == world.voxel_m ? " m" : "");
}

/// Whether a place lies farther from the world, on the map, than the world is wide.
bool far_off(core::Vec3 at, const voxel::VoxelBounds& b) noexcept {
    const double x = std::max({b.min[0] - at.x, at.x - b.max[0], 0.0});
    const double z = std::max({b.min[2] - at.z, at.z - b.max[2], 0.0});
    return std::hypot(x, z) > std::hypot(static_cast<double>(b.max[0]) - b.min[0],
                                         static_cast<double>(b.max[2]) - b.min[2]);
}

}  // namespace

std::string out_of_sight(const shade::View& view, const voxel::WorldInfo& world) {
    const auto& camera = view.scene.camera;
    const auto [width, height] = view.scene.output.size_px;
    const bool seen = !boxes_in_sight(view.camera, width, height, view.cut, 1).empty();
    std::optional<core::Vec3> target;
    if (camera.target)
        target = scene::to_voxels(*camera.target, camera.space, world);
    if (seen && !(target && far_off(*target, world.bounds)))
        return {};
    const auto& b = world.bounds;
    // The world's lower left corner on the map is its south-west: z grows to the south.
    const core::Vec3 low{static_cast<double>(b.min[0]), static_cast<double>(b.min[1]),
                         static_cast<double>(b.max[2])};
    const core::Vec3 high{static_cast<double>(b.max[0]), static_cast<double>(b.max[1]),
                          static_cast<double>(b.min[2])};
    std::string out = camera.look.empty() ? "the camera" : "the view '" + camera.look + "'";
    out += seen ? " looks at what is far from the world" : " shows nothing of the world";
    out += ": it stands at " + find_place(view.camera.position(), world);
    if (target)
        out += " and looks at " + find_place(*target, world);
    return out + "; the world reaches from " + find_place(low, world) + " to " +
           find_place(high, world) + (world.crs.empty() ? ", voxels" : " in " + world.crs);
}

void prefetch_visible(const shade::View& view, blocks::BlockManager& blocks) {
    const auto [width, height] = view.scene.output.size_px;
    blocks.prefetch(boxes_in_sight(view.camera, width, height, view.cut, kMaxForeseen));
}

}  // namespace terravox::render
