#include "raytracer/core/blocks/load_queue.hpp"

#include <algorithm>

#include "common/util/log.hpp"
#include "common/voxel/world.hpp"

namespace terravox::blocks {
namespace {

constexpr std::size_t kMaxReasons = 100;

}  // namespace

void HoleRecord::add(const voxel::BoxKey& key, const std::exception_ptr& failure) {
    std::string reason;
    try {
        std::rethrow_exception(failure);
    } catch (const voxel::ChangedError&) {
        m_holes.insert(key);
        if (!m_changed)
            m_changed = failure;
        return;
    } catch (const std::exception& e) {
        reason = e.what();
    } catch (...) {
        reason = "an error without a name";
    }
    // A damaged file fails with the same message for each of its boxes: it is logged once, and the
    // boxes are counted at the end.
    if (m_holes.insert(key).second && m_reasons.size() < kMaxReasons &&
        m_reasons.insert(reason).second)
        util::log_error("hole at box {}: {}", voxel::to_string(key), reason);
}

void HoleRecord::forget(const std::function<bool(const voxel::BoxKey&)>& may_forget) {
    ++m_generation;
    std::erase_if(m_holes, may_forget);
}

void HoleRecord::check_world() const {
    if (m_changed)
        std::rethrow_exception(m_changed);
}

namespace {

std::size_t max_prefetching(const LoadQueue::Limits& limits) noexcept {
    return limits.batch == 1 ? limits.loaders
                             : std::max<std::size_t>(limits.loaders - limits.loaders / 4, 1);
}

}  // namespace

LoadQueue::LoadQueue(const Limits& limits) noexcept
    : m_limits(limits), m_max_prefetching(max_prefetching(limits)) {}

bool LoadQueue::take(const MemoryUse& memory, const Predicate& is_known, Request& request) {
    request.keys.clear();
    if (memory.unseen_bytes > m_limits.memory_bytes / 4)
        return false;
    request.prefetched = m_requested.empty();
    if (!request.prefetched)
        take_requested(memory, request.keys);
    else if (m_prefetching < m_max_prefetching)
        take_prefetched(memory, is_known, request.keys);
    if (request.keys.empty())
        return false;
    ++m_busy;
    m_prefetching += request.prefetched ? 1 : 0;
    m_boxes_under_way += request.keys.size();
    return true;
}

void LoadQueue::finish(const Request& request) noexcept {
    --m_busy;
    m_prefetching -= request.prefetched ? 1 : 0;
}

// Shares the queue among the idle loaders, of which there is at least the calling one.
std::size_t LoadQueue::measure_share(std::size_t queued) const noexcept {
    const std::size_t idle = m_limits.loaders - m_busy;
    return std::clamp<std::size_t>((queued + idle - 1) / idle, 1, m_limits.batch);
}

// Bytes that the boxes under way and `more` additional ones may need, at the average size so far.
std::size_t LoadQueue::expected_bytes(const MemoryUse& memory, std::size_t more) const noexcept {
    return (m_boxes_under_way + more) * memory.mean_box_bytes;
}

// The first box is taken even without room for it, or none would ever be loaded; others only where
// everything requested fits.
void LoadQueue::take_requested(const MemoryUse& memory, std::vector<voxel::BoxKey>& keys) {
    const std::size_t max = measure_share(m_requested.size());
    const std::size_t room_bytes = m_limits.memory_bytes / 4;
    while (!m_requested.empty() && keys.size() < max &&
           (keys.empty() ||
            memory.unseen_bytes + expected_bytes(memory, keys.size() + 1) <= room_bytes)) {
        keys.push_back(m_requested.front());
        m_requested.pop_front();
    }
}

void LoadQueue::take_prefetched(const MemoryUse& memory, const Predicate& is_known,
                                std::vector<voxel::BoxKey>& keys) {
    const std::size_t max = measure_share(m_prefetched.size());
    const std::size_t room_bytes = m_limits.memory_bytes / 4 * 3;
    while (!m_prefetched.empty() && keys.size() < max && memory.bytes < room_bytes &&
           (keys.empty() || memory.bytes + expected_bytes(memory, keys.size() + 1) < room_bytes)) {
        const voxel::BoxKey key = m_prefetched.front();
        m_prefetched.pop_front();
        const bool is_taken = std::find(keys.begin(), keys.end(), key) != keys.end();
        if (!is_taken && !is_known(key))
            keys.push_back(key);
    }
}

}  // namespace terravox::blocks
