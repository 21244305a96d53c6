#include "raytracer/farm/render/picture_renderer.hpp"

#include <algorithm>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/core/output/credit_line.hpp"
#include "raytracer/core/output/denoise.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "raytracer/core/output/tile_stream.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/checkpoint/picture_key.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"

namespace terravox::render {
namespace {

output::StreamShape make_shape(const scene::Scene& scene) {
    const auto [width, height] = scene.output.size_px;
    return {width, height, scene.quality.tile.in_picture(width),
            scene.output.layers != core::PictureLayers::kBeauty || scene.output.denoise};
}

bool streams(const scene::Scene& scene) {
    return output::must_stream(make_shape(scene),
                               (static_cast<std::uint64_t>(scene.processing.memory_mib) << 20) / 2);
}

/// Tiles on their way to a file may take the memory that would have been the film's, and no more.
/// No picture depends on their size.
scene::TileSize tiles_that_fit(const scene::Scene& scene) {
    constexpr int kSmallEnough_px = 64;
    constexpr int kTiffTiles = 16;
    const output::StreamShape shape = make_shape(scene);
    const auto in_flight = static_cast<std::uint64_t>(processors::ThreadProcessor::tiles_in_flight(
        thread::thread_count(scene.processing.threads.value_or(0))));
    const auto bytes = [&](int edge_px) {
        return output::Film::bytes(edge_px, edge_px, shape.with_layers) * in_flight;
    };
    int edge_px = shape.tile_px;
    while (edge_px > kSmallEnough_px &&
           bytes(edge_px) > (static_cast<std::uint64_t>(scene.processing.memory_mib) << 20) / 2)
        edge_px = std::max(edge_px / 2 / kTiffTiles * kTiffTiles, kSmallEnough_px);
    return edge_px == shape.tile_px ? scene.quality.tile : scene::TileSize{edge_px, 0};
}

/// The scene without fields that would take memory in vain. Layers are written to EXR files alone:
/// for others they would take seven times the memory, and be discarded.
scene::Scene drop_unneeded_layers(scene::Scene scene, const std::vector<std::string>& files,
                                  bool fit = true) {
    if (std::none_of(files.begin(), files.end(), output::is_exr))
        scene.output.layers = core::PictureLayers::kBeauty;
    if (fit && streams(scene))
        scene.quality.tile = tiles_that_fit(scene);
    return scene;
}

/// Tiles to several files.
class Streams final : public output::TileSink {
public:
    void add(const tiles::TileResult& result) override {
        for (const auto& stream : m_streams)
            stream->add(result);
    }
    void to(std::unique_ptr<output::TileStream> stream) { m_streams.push_back(std::move(stream)); }
    void finish(std::uint64_t holes) {
        for (const auto& stream : m_streams)
            stream->finish(holes);
    }

private:
    std::vector<std::unique_ptr<output::TileStream>> m_streams;
};

/// Of a part of a picture only the checkpoint is wanted.
struct Nowhere final : output::TileSink {
    void add(const tiles::TileResult&) override {}
    [[nodiscard]] bool replaces() const noexcept override { return true; }
};

}  // namespace

PictureRenderer::PictureRenderer(const worlds::WorldOptions& world,
                                 const RenderPoolOptions& render_pool, const scene::Scene& base,
                                 bool quiet)
    // Until the world is open a signal just ends the program: no work would be lost, and opening a
    // world may take minutes.
    : PictureRenderer(std::make_shared<LoadedWorld>(world, base), render_pool, base, quiet,
                      std::make_unique<thread::StopSignals>()) {}

PictureRenderer::PictureRenderer(std::shared_ptr<LoadedWorld> world,
                                 const RenderPoolOptions& render_pool, const scene::Scene& base,
                                 bool quiet, std::unique_ptr<thread::StopSignals> signals)
    : PictureRenderer(std::move(world), render_pool, base, quiet, signals->token()) {
    m_signals = std::move(signals);
}

PictureRenderer::PictureRenderer(std::shared_ptr<LoadedWorld> world,
                                 const RenderPoolOptions& render_pool, const scene::Scene& base,
                                 bool quiet, std::stop_token stop)
    : m_loaded(std::move(world)),
      m_quiet(quiet),
      m_threads(thread::thread_count(base.processing.threads.value_or(0))),
      m_stop(std::move(stop)),
      m_render_pool(std::make_unique<RenderPool>(render_pool, m_loaded->blocks, m_loaded->source)) {
}

PictureRenderer::~PictureRenderer() = default;

void PictureRenderer::check(const scene::Scene& asked, const std::vector<std::string>& files) {
    const scene::Scene scene = drop_unneeded_layers(asked, files);
    scene::check_is_picture(scene);
    const auto [width, height] = scene.output.size_px;
    for (const std::string& file : files)
        output::check_image_target(file, width, height);
    if (scene.output.denoise)
        output::check_can_denoise();
    if (!streams(scene))
        return;
    const std::string attempt =
        "render " + std::to_string(width) + "x" + std::to_string(height) +
        " pixels: more than the memory limit holds, so they go straight into the file; ";
    const std::string memory = ", or --memory-mib " +
                               std::to_string(output::memory_to_keep_mib(make_shape(scene))) +
                               " and more";
    if (scene.output.denoise)
        throw util::UsageError(attempt + "output.denoise = true; allowed: false" + memory);
    if (scene.quality.time_s > 0)
        throw util::UsageError(attempt + "quality.time_s is set; allowed: 0" + memory);
    for (const std::string& file : files)
        output::check_can_stream(file, make_shape(scene));
}

RenderStatistics PictureRenderer::render(const scene::Scene& asked,
                                         const std::vector<std::string>& files,
                                         const KeepOptions& keep,
                                         std::chrono::steady_clock::time_point start) {
    RenderStatistics statistics;
    statistics.threads = m_threads;
    const scene::Scene scene = drop_unneeded_layers(asked, files, !keep.part);
    prepare(scene, files, keep);
    if (m_part)
        trace(
            [](const RenderJob& job) {
                Nowhere nowhere;
                return render_stream(job, nowhere);
            },
            statistics, start);
    else if (streams(scene))
        render_to_files(statistics, files, start);
    else
        render_to_film(statistics, files, start);
    finish_checkpoint(statistics);
    finish(statistics, start);
    m_checkpoint.reset();
    return statistics;
}

RenderStatistics PictureRenderer::render_tiles(
    const scene::Scene& scene, const std::string& file,
    const std::function<output::TileSink&()>& begin,
    const std::function<void(const RenderStatistics&)>& write, const KeepOptions& keep,
    std::chrono::steady_clock::time_point start) {
    RenderStatistics statistics;
    statistics.threads = m_threads;
    prepare(scene, {file}, keep);
    trace([&](const RenderJob& job) { return render_stream(job, begin()); }, statistics, start);
    if (statistics.counts.missing == 0) {
        finish(statistics, start);
        write(statistics);
    }
    finish_checkpoint(statistics);
    finish(statistics, start);
    m_checkpoint.reset();
    if (statistics.counts.missing > 0)
        throw util::Error("render: " + std::to_string(statistics.counts.missing) +
                          " tiles are missing; nothing was written");
    return statistics;
}

void PictureRenderer::prepare(scene::Scene scene, const std::vector<std::string>& files,
                              const KeepOptions& keep) {
    m_part = keep.part;
    if (scene.output.credit && !m_part && !std::ranges::all_of(files, output::is_exr))
        output::check_credit(m_loaded->world->info().attribution);
    // Parts and checkpoints have whole tiles. Coarse passes are for viewers; at the end of each,
    // workers wait for the last tile.
    const bool keeps = keep.resume || keep.part ||
                       (m_render_pool->is_farm() && keep.on_farms && scene.quality.time_s == 0);
    if (keeps || m_render_pool->is_farm())
        scene.quality.coarse_step = 1;
    m_view = std::make_unique<shade::View>(m_views.make(scene, m_loaded->blocks));
    if (const std::string why = out_of_sight(*m_view, m_loaded->world->info());
        !why.empty() && !std::exchange(m_warned, true))
        util::log_warn("{}", why);
    if (m_render_pool->traces_here())
        prefetch_visible(*m_view, m_loaded->blocks);
    m_checkpoint.reset();
    if (keeps)
        open_checkpoint(scene, files, keep);
}

void PictureRenderer::finish_checkpoint(const RenderStatistics& statistics) {
    if (m_checkpoint && (m_part || statistics.counts.missing > 0))
        m_checkpoint->close();
    else if (m_checkpoint)
        m_checkpoint->finish();
}

void PictureRenderer::open_checkpoint(const scene::Scene& scene,
                                      const std::vector<std::string>& files,
                                      const KeepOptions& keep) {
    farm::check_can_checkpoint(scene);
    const auto path = farm::checkpoint_path(files.front(), keep.part);
    const auto existing = keep.resume || keep.part ? farm::Checkpoint::Existing::kResume
                                                   : farm::Checkpoint::Existing::kRefuse;
    auto inputs = farm::name_inputs(m_loaded->inputs, m_loaded->orthophotos, scene);
    if (const std::string edition = m_loaded->world->edition(); !edition.empty())
        inputs.push_back("state of the archive: " + edition);
    m_checkpoint = std::make_unique<farm::Checkpoint>(
        path, farm::to_key(scene, m_loaded->world->info(), std::move(inputs)), existing);
    if (m_checkpoint->count() > 0 && !m_quiet)
        util::log_info("{} tiles are in {} already", m_checkpoint->count(), path.string());
}

void PictureRenderer::finish(RenderStatistics& statistics,
                             std::chrono::steady_clock::time_point start) const {
    statistics.blocks = m_loaded->blocks.stats();
    statistics.damage = m_loaded->world->damage();
    // Tiles affected by damage in earlier runs are in the picture, too.
    if (m_checkpoint)
        for (const std::string& line : m_checkpoint->damage())
            if (std::find(statistics.damage.begin(), statistics.damage.end(), line) ==
                statistics.damage.end())
                statistics.damage.push_back(line);
    statistics.limit_bytes = m_loaded->blocks.limit_bytes();
    statistics.peak_rss_bytes = peak_rss_bytes();
    statistics.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void PictureRenderer::trace(const std::function<RenderCounts(const RenderJob&)>& work,
                            RenderStatistics& statistics,
                            std::chrono::steady_clock::time_point start) {
    const util::StageTimes::Clock timed(m_loaded->times, "ray tracing (clock)");
    for (bool is_done = false; !is_done;) {
        try {
            const auto processor = m_render_pool->begin(*m_view);
            RenderJob job{*m_view, *processor, m_quiet, m_stop};
            job.start = start;
            job.checkpoint = m_checkpoint.get();
            job.part = m_part;
            job.check_world = [this] { m_loaded->blocks.check_world(); };
            job.damage = [this] { return m_loaded->world->damage(); };
            job.on_progress = [this](std::uint64_t done, std::uint64_t of) {
                m_render_pool->set_progress(done, of);
                if (m_reported)
                    m_reported(done, of);
            };
            if (m_render_pool->is_farm())
                job.details = [this] { return m_render_pool->table(); };
            statistics.counts = work(job);
            processor->close();
            is_done = true;
        } catch (const processors::PictureInvalidated& e) {
            util::log_error("{}; the picture starts again", e.what());
        }
    }
    for (const RenderPool::Participant& participant : m_render_pool->participants())
        statistics.participants.push_back(participant.status);
    statistics.pool = m_render_pool->counts();
}

void PictureRenderer::render_to_film(RenderStatistics& statistics,
                                     const std::vector<std::string>& files,
                                     std::chrono::steady_clock::time_point start) {
    const scene::Scene& scene = m_view->scene;
    output::Film film(scene.output.size_px[0], scene.output.size_px[1], m_view->wants_layers());
    trace([&](const RenderJob& job) { return render_film(job, film); }, statistics, start);
    finish(statistics, start);
    if (scene.output.denoise) {
        const util::StageTimes::Scope timed(m_loaded->times, "denoise");
        output::denoise(film, m_threads);
    }
    const util::StageTimes::Scope timed(m_loaded->times, "write pictures");
    thread::parallel_for(files.size(), m_threads, [&](std::size_t i) {
        output::write_image(
            film, files[i],
            picture_info(*m_view, m_loaded->world->info(), statistics, output::is_exr(files[i])));
    });
}

void PictureRenderer::render_to_files(RenderStatistics& statistics,
                                      const std::vector<std::string>& files,
                                      std::chrono::steady_clock::time_point start) {
    // Known in advance: it is written to the file first.
    const auto samples = static_cast<std::uint32_t>(m_view->scene.quality.samples);
    statistics.counts.samples = samples;
    const output::PictureInfo info =
        picture_info(*m_view, m_loaded->world->info(), statistics, false);
    trace(
        [&](const RenderJob& job) {
            Streams sinks;
            for (const std::string& file : files)
                sinks.to(
                    std::make_unique<output::TileStream>(file, make_shape(m_view->scene), info));
            RenderCounts counts = render_stream(job, sinks);
            if (counts.missing > 0)
                throw util::Error("render: " + std::to_string(counts.missing) +
                                  " tiles are missing; no picture was written");
            sinks.finish(counts.holes.size());
            return counts;
        },
        statistics, start);
}

}  // namespace terravox::render
