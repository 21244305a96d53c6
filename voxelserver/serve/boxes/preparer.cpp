#include "voxelserver/serve/boxes/preparer.hpp"

#include <algorithm>
#include <chrono>

#include "common/thread/start_threads.hpp"

namespace terravox::boxes {

BoxTraversal::BoxTraversal(voxel::World& world) : m_world(world) {
    const voxel::WorldInfo& info = world.info();
    if (info.bounds.empty())
        return;
    const auto range = voxel::boxes_over(info.bounds, info.levels - 1);
    for (std::int32_t bz = range.max.bz - 1; bz >= range.min.bz; --bz)
        for (std::int32_t bx = range.max.bx - 1; bx >= range.min.bx; --bx)
            push(info.levels - 1, bx, bz);
}

bool BoxTraversal::next(voxel::BoxKey& key) {
    while (m_current.by >= m_by_end) {
        if (m_open.empty())
            return false;
        Node& node = m_open.back();
        if (!node.opened && node.level > 0) {
            node.opened = true;
            const auto [level, bx, bz, opened] = node;
            if (m_world.column(level, bx, bz).empty()) {
                m_open.pop_back();
                continue;
            }
            for (int i = 3; i >= 0; --i)
                push(level - 1, 2 * bx + (i & 1), 2 * bz + (i >> 1));
            continue;
        }
        const Node done = node;
        m_open.pop_back();
        const auto column = m_world.column(done.level, done.bx, done.bz);
        m_current = {done.level, done.bx, column.by_begin, done.bz};
        m_by_end = column.by_end;
    }
    key = m_current;
    ++m_current.by;
    return true;
}

std::uint64_t BoxTraversal::count(voxel::World& world) {
    BoxTraversal walk(world);
    voxel::BoxKey ignored;
    std::uint64_t out = 0;
    while (walk.next(ignored))
        ++out;
    return out;
}

Preparer::Preparer(BoxCache& cache, int lanes, std::function<void(const std::string&)> failed)
    : m_cache(cache),
      m_on_failure(std::move(failed)),
      m_walk(cache.world()),
      m_running(std::max(lanes, 1)) {
    const auto stop_all = [this] {
        stop();
        m_cache.close();
    };
    thread::start_threads(
        m_lanes, static_cast<std::size_t>(std::max(lanes, 1)), [this] { work(); }, stop_all);
}

Preparer::~Preparer() {
    stop();
    m_cache.close();  // a thread may be waiting for the machine to become idle
    for (std::thread& t : m_lanes)
        t.join();
}

// Another request may be rejected while this one waits for the same box: that is not a failure of
// the box.
bool Preparer::make(const voxel::BoxKey& key) {
    constexpr std::chrono::milliseconds kPause{20};
    while (!m_stop) {
        try {
            return m_cache.find_or_make_when_idle(key) != nullptr;
        } catch (const OverloadedError&) {
            std::this_thread::sleep_for(kPause);
        }
    }
    return false;
}

void Preparer::work() {
    try {
        std::call_once(m_counted, [&] { m_total = BoxTraversal::count(m_cache.world()); });
    } catch (const std::exception& e) {
        const std::lock_guard lock(m_mutex);
        m_on_failure(e.what());
    }
    while (!m_stop) {
        voxel::BoxKey key;
        try {
            {
                const std::lock_guard lock(m_mutex);
                if (!m_walk.next(key))
                    break;
            }
            if (!make(key))
                break;
        } catch (const std::exception& e) {
            const std::lock_guard lock(m_mutex);
            ++m_failed;
            m_on_failure(e.what());
        }
        ++m_done;
    }
    --m_running;
}

}  // namespace terravox::boxes
