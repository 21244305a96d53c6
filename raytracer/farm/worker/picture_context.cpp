#include "raytracer/farm/worker/picture_context.hpp"

#include <algorithm>

#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/stage_times.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/tiles/tile_codec.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::farm {
namespace {

constexpr int kThreadsPerCollector = 8;
// Copies of a tile's pixels: as they were traced, as the codec orders them, and compressed.
constexpr std::uint64_t kCopies = 3;

/// @return nullptr, which is logged, if this worker's configuration does not allow the server that
/// the coordinator names
std::unique_ptr<voxel::World> open_server(const WorkerWorld& world, const scene::Scene& scene,
                                          util::StageTimes& times) {
    const remote::HttpOrigin origin = remote::HttpOrigin::of(world.server);
    if (!world.http.ranges(origin).empty())
        return worlds::open_address(world.server, world.http, times,
                                    std::chrono::seconds(scene.processing.box_timeout_s),
                                    world.ending.get_token());
    util::log_info(
        "{} is not among the origins that this worker may use; boxes are requested from the "
        "coordinator",
        origin.text());
    return nullptr;
}

worlds::WorldOptions make_options(const std::string& input, const scene::Scene& scene) {
    worlds::WorldOptions out = scene::to_world_options(scene);
    out.inputs = {input};
    return out;
}

/// The world as the worker can open it itself.
/// @return nullptr, which is logged, if it differs from the coordinator's or is not available
std::unique_ptr<voxel::World> open_own(const WorkerWorld& world, const std::string& scene_text) {
    static util::StageTimes times;
    if (world.server.empty() && world.generated.empty())
        return nullptr;
    try {
        // Only what a generated world needs is used of a coordinator's scene; the time limit for a
        // server is this worker's default.
        scene::Scene scene;
        const scene::Scene asked = unpack_scene(scene_text);
        scene.generated = asked.generated;
        scene.world.voxel_m = world.coordinator->info().voxel_m;
        std::unique_ptr<voxel::World> own;
        if (!world.server.empty())
            own = open_server(world, scene, times);
        // The coordinator's text is interpreted as a seed, never as a path.
        else if (world.generated.starts_with("generated:"))
            own = worlds::open_world(make_options(world.generated, scene), times,
                                     world.ending.get_token());
        else
            throw util::Error("open the world: the coordinator names no generated:SEED");
        if (own)
            own = worlds::with_plane(std::move(own), asked.world.plane);
        if (!own || pack_world(own->info()) == world.info_text)
            return own;
        util::log_warn(
            "{} is another world here than the coordinator's; its boxes are requested "
            "from the coordinator",
            world.server.empty() ? world.generated : world.server);
    } catch (const util::Error& e) {
        if (!world.ending.stop_requested())
            util::log_warn("{}; boxes are requested from the coordinator", e.what());
    }
    return nullptr;
}

}  // namespace

PictureContext::PictureContext(std::uint64_t picture, PictureSpec spec,
                               std::shared_ptr<WorkerWorld> world, int threads,
                               std::size_t memory_bytes, Answers answers)
    : m_picture(picture),
      m_spec(std::move(spec)),
      m_world(std::move(world)),
      m_threads(threads),
      m_memory_bytes(memory_bytes),
      m_answers(std::move(answers)) {
    m_thread = thread::start_thread("a picture", [this] { run(); });
}

void PictureContext::end() noexcept {
    cancel();
    std::call_once(m_joined, [&] { m_thread.join(); });
}

void PictureContext::add(std::uint64_t id, const tiles::RenderTile& tile) {
    const std::lock_guard lock(m_mutex);
    if (m_cancelled)
        return;
    m_waiting.emplace_back(id, tile);
    m_work.notify_all();
}

void PictureContext::drop(const std::vector<std::uint64_t>& ids) {
    const std::lock_guard lock(m_mutex);
    const auto is_dropped = [&](const auto& lease) {
        return std::find(ids.begin(), ids.end(), lease.first) != ids.end();
    };
    std::erase_if(m_waiting, is_dropped);
    if (m_processor != nullptr)
        for (const auto& lease : m_begun)
            if (is_dropped(lease))
                m_processor->withdraw(lease.second);
    std::erase_if(m_begun, is_dropped);
    m_work.notify_all();
    m_idle.notify_all();
}

std::vector<std::uint64_t> PictureContext::drop_all() {
    std::vector<std::uint64_t> ids;
    const std::lock_guard lock(m_mutex);
    for (const auto& [id, tile] : m_waiting)
        ids.push_back(id);
    m_waiting.clear();
    if (m_processor != nullptr)
        for (const tiles::RenderTile& tile : m_processor->take_back()) {
            const auto begun = std::find_if(m_begun.begin(), m_begun.end(),
                                            [&](const auto& b) { return b.second == tile; });
            if (begun == m_begun.end())
                continue;
            ids.push_back(begun->first);
            m_begun.erase(begun);
        }
    m_work.notify_all();
    m_idle.notify_all();
    return ids;
}

void PictureContext::cancel() noexcept {
    const std::lock_guard lock(m_mutex);
    m_cancelled = true;
    m_waiting.clear();
    m_begun.clear();
    if (m_processor != nullptr)
        m_processor->cancel();
    m_work.notify_all();
    m_idle.notify_all();
}

bool PictureContext::wait_idle(std::chrono::steady_clock::time_point until) {
    std::unique_lock lock(m_mutex);
    return m_idle.wait_until(lock, until,
                             [&] { return m_cancelled || (m_waiting.empty() && m_begun.empty()); });
}

PictureContext::Load PictureContext::load() const {
    const std::lock_guard lock(m_mutex);
    // Boxes exist once the processor does.
    return {m_waiting.size(), m_begun.size(),
            m_processor != nullptr ? m_world->blocks->stats().bytes : 0};
}

bool PictureContext::open_world() {
    const std::lock_guard lock(m_world->opening);
    if (m_world->blocks) {
        // Holes of an earlier picture are forgotten: the coordinator decides what is a hole now.
        m_world->blocks->forget_holes();
        return true;
    }
    voxel::World* source = m_world->coordinator.get();
    if (auto own = open_own(*m_world, m_spec.scene)) {
        m_world->own = std::make_unique<FallbackWorld>(std::move(own), *m_world->coordinator);
        source = m_world->own.get();
    }
    if (m_world->ending.stop_requested())
        return false;
    m_world->blocks = std::make_unique<blocks::BlockManager>(*source, m_memory_bytes,
                                                             source->useful_concurrency(m_threads));
    return true;
}

void PictureContext::run() {
    try {
        if (open_world())
            trace();
    } catch (const std::exception&) {
        m_answers.failed(0, util::to_message(std::current_exception()));
        cancel();
    }
    m_over = true;
}

void PictureContext::trace() {
    const shade::View view = unpack(m_spec, m_world->coordinator->info());
    processors::ThreadProcessor processor(view, *m_world->blocks, m_threads);
    {
        const std::lock_guard lock(m_mutex);
        m_processor = &processor;
        if (m_cancelled)
            processor.cancel();
    }
    // However this ends, no thread may use the processor after it is destroyed.
    std::vector<std::thread> collectors;
    const auto count = static_cast<std::size_t>(m_threads / kThreadsPerCollector + 1);
    std::exception_ptr failure;
    try {
        thread::start_threads(
            collectors, count, [&] { collect(processor); }, [&] { processor.cancel(); });
        feed(processor, view.content());
    } catch (...) {
        failure = std::current_exception();
    }
    processor.cancel();
    for (std::thread& t : collectors)
        t.join();
    {
        const std::lock_guard lock(m_mutex);
        m_processor = nullptr;
    }
    if (failure)
        std::rethrow_exception(failure);
}

// The lock must be held.
bool PictureContext::has_room(const tiles::RenderTile& tile, tiles::PixelContent content) const {
    std::uint64_t bytes = tiles::pixel_bytes(tile, content);
    for (const auto& [id, begun] : m_begun)
        bytes += tiles::pixel_bytes(begun, content);
    return m_begun.empty() || kCopies * bytes <= m_memory_bytes;
}

void PictureContext::feed(processors::TileProcessor& processor, tiles::PixelContent content) {
    std::unique_lock lock(m_mutex);
    while (true) {
        m_work.wait(lock, [&] {
            return m_cancelled ||
                   (!m_waiting.empty() && has_room(m_waiting.front().second, content));
        });
        if (m_cancelled)
            return;
        if (const auto [id, tile] = m_waiting.front();
            tiles::pixel_bytes(tile, content) > kMaxLease_bytes) {
            m_waiting.pop_front();
            m_idle.notify_all();
            lock.unlock();
            m_answers.failed(id, "a tile of " + std::to_string(tiles::pixel_bytes(tile, content)) +
                                     " bytes of pixels; allowed: up to " +
                                     std::to_string(kMaxLease_bytes) +
                                     ", so make quality.tile smaller");
            lock.lock();
            continue;
        }
        m_begun.push_back(m_waiting.front());
        m_waiting.pop_front();
        const tiles::RenderTile tile = m_begun.back().second;
        lock.unlock();
        processor.submit(tile);
        lock.lock();
    }
}

void PictureContext::collect(processors::TileProcessor& processor) {
    try {
        while (auto result = processor.take()) {
            std::uint64_t id = 0;
            {
                const std::lock_guard lock(m_mutex);
                const auto begun = std::find_if(m_begun.begin(), m_begun.end(), [&](const auto& b) {
                    return b.second == result->tile;
                });
                if (begun == m_begun.end())
                    continue;
                id = begun->first;
            }
            m_answers.done(id, std::move(*result));
            // Erased only after sending: when wait_idle() returns, all results have been sent.
            const std::lock_guard lock(m_mutex);
            std::erase_if(m_begun, [&](const auto& b) { return b.first == id; });
            m_work.notify_all();
            m_idle.notify_all();
        }
    } catch (const std::exception& e) {
        m_answers.failed(0, e.what());
        cancel();
    }
}

}  // namespace terravox::farm
