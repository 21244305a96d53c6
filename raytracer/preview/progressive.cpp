#include "raytracer/preview/progressive.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "raytracer/output/image_writer.hpp"
#include "raytracer/render/render.hpp"
#include "raytracer/sched/thread_processor.hpp"
#include "raytracer/tiles/tile_plan.hpp"

namespace terravox {
namespace {

constexpr std::chrono::milliseconds kStopPeriod{10};

}  // namespace

Progressive::~Progressive() { stop(); }

void Progressive::stop() noexcept {
    m_stop = true;
    if (m_thread.joinable()) m_thread.join();
    m_stop = false;
}

void Progressive::start(const Scene& scene) {
    stop();
    View view = make_view(scene, m_blocks);
    {
        const std::lock_guard lock(m_mutex);
        const auto [width, height] = scene.output.size_px;
        // The last picture stays until tiles of the new one replace it: no flicker while the camera moves.
        if (width != m_width || height != m_height) {
            m_width = width, m_height = height;
            m_rgb.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 40);
        }
        m_status = {};
        m_failure = nullptr;
    }
    m_thread = std::thread([this, view = std::move(view)] {
        try {
            run(view);
        } catch (...) {
            const std::lock_guard lock(m_mutex);
            m_failure = std::current_exception();
        }
    });
}

void Progressive::run(const View& view) {
    const auto& q = view.scene.quality;
    const auto [width, height] = view.scene.output.size_px;
    const auto begin = std::chrono::steady_clock::now();
    Film film(width, height);
    foresee_boxes(view, m_blocks);
    ThreadProcessor processor(view, m_blocks, m_threads);
    const auto passes = plan_tiles(width, height, q.coarse_step, q.tile.in_picture(width), q.tile_order);
    {
        const std::lock_guard lock(m_mutex);
        m_status.tiles_total = passes.size() * passes.front().size();
    }
    for (const auto& tiles : passes) {
        std::size_t submitted = 0, done = 0;
        while (done < tiles.size()) {
            while (submitted < tiles.size() && submitted - done < static_cast<std::size_t>(processor.capacity())) processor.submit(tiles[submitted++]);
            while (!processor.wait(kStopPeriod) && !m_stop) {}
            if (m_stop) return;  // the processor's destructor cancels what is left
            const auto result = processor.take();
            if (!result) return;
            film.add(*result);
            ++done;
            develop_tile(view, film, result->tile);
            const std::lock_guard lock(m_mutex);
            ++m_status.tiles_done;
            m_status.rays += result->counts.all_rays();
            m_status.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        }
    }
    const std::lock_guard lock(m_mutex);
    m_status.finished = true;
}

void Progressive::develop_tile(const View& view, const Film& film, const RenderTile& tile) {
    const auto& output = view.scene.output;
    const int width = film.width_px();
    const Developer develop(view.exposure_ev, output.tone);
    std::vector<std::uint8_t> row(static_cast<std::size_t>(tile.x1 - tile.x0) * 3);
    for (int y = tile.y0; y < tile.y1; ++y) {
        for (int x = tile.x0; x < tile.x1; ++x) {
            const Colour c = develop(film.at(x, y).colour);
            std::uint8_t* to = &row[static_cast<std::size_t>(x - tile.x0) * 3];
            to[0] = static_cast<std::uint8_t>(std::lround(c.r * 255)), to[1] = static_cast<std::uint8_t>(std::lround(c.g * 255)), to[2] = static_cast<std::uint8_t>(std::lround(c.b * 255));
        }
        const std::lock_guard lock(m_mutex);
        std::copy(row.begin(), row.end(), m_rgb.begin() + (static_cast<std::ptrdiff_t>(y) * width + tile.x0) * 3);
    }
    const std::lock_guard lock(m_mutex);
    ++m_version;
}

Progressive::Status Progressive::status() const {
    const std::lock_guard lock(m_mutex);
    return m_status;
}

bool Progressive::copy_if_new(std::vector<std::uint8_t>& rgb, int& width_px, int& height_px, std::uint64_t& seen) const {
    const std::lock_guard lock(m_mutex);
    if (seen == m_version) return false;
    rgb = m_rgb;
    width_px = m_width, height_px = m_height;
    seen = m_version;
    return true;
}

void Progressive::check() {
    const std::lock_guard lock(m_mutex);
    if (const auto failure = std::exchange(m_failure, nullptr)) std::rethrow_exception(failure);
}

}  // namespace terravox
