#include "voxelserver/serve/boxes/prefetch_queue.hpp"

namespace terravox::boxes {

void PrefetchQueue::add(const std::vector<voxel::BoxKey>& keys,
                        const std::function<bool(const voxel::BoxKey&)>& wanted) {
    const std::lock_guard lock(m_mutex);
    if (m_closed)
        return;
    for (const voxel::BoxKey& key : keys)
        if (wanted(key) && m_queued.insert(key).second)
            m_keys.push_front(key);
    while (m_keys.size() > m_max_keys) {
        m_queued.erase(m_keys.back());
        m_keys.pop_back();
    }
    m_changed.notify_all();
}

std::optional<voxel::BoxKey> PrefetchQueue::take() {
    std::unique_lock lock(m_mutex);
    m_changed.wait(lock, [&] { return m_closed || !m_keys.empty(); });
    if (m_closed)
        return std::nullopt;
    const voxel::BoxKey key = m_keys.front();
    m_keys.pop_front();
    m_queued.erase(key);
    return key;
}

void PrefetchQueue::close() {
    {
        const std::lock_guard lock(m_mutex);
        m_closed = true;
    }
    m_changed.notify_all();
}

std::size_t PrefetchQueue::size() const {
    const std::lock_guard lock(m_mutex);
    return m_keys.size();
}

}  // namespace terravox::boxes
