#include "raytracer/core/blocks/block_manager.hpp"

#include <algorithm>

#include "common/thread/start_threads.hpp"

namespace terravox::blocks {

BlockManager::BlockManager(voxel::World& world, std::size_t memory_bytes, int loaders)
    : m_world(world),
      m_cache(memory_bytes),
      m_queue({memory_bytes, static_cast<std::size_t>(std::max(world.preferred_batch(), 1)),
               static_cast<std::size_t>(std::max(loaders, 1))}) {
    for (int level = 0; level <= voxel::kMaxLevel; ++level)
        m_ranges[static_cast<std::size_t>(level)] =
            world.info().bounds.empty() ? voxel::BoxRange{}
                                        : voxel::boxes_over(world.info().bounds, level);
    thread::start_threads(
        m_loaders, m_queue.loader_count(), [this] { load_boxes(); }, [this] { stop(); });
}

BlockManager::~BlockManager() {
    stop();
    for (std::thread& t : m_loaders)
        t.join();
}

void BlockManager::stop() {
    {
        const std::lock_guard lock(m_mutex);
        m_stop = true;
        m_work.notify_all();
        m_loaded.notify_all();
    }
    m_world.stop();
}

// The lock must be held.
void BlockManager::touch(Entry& entry) {
    if (m_cache.touch(entry))
        m_work.notify_all();
}

// Queues the box of an entry without a block, unless it is queued or being loaded already. The lock
// must be held.
void BlockManager::request(const voxel::BoxKey& key, Entry& entry) {
    if (entry.wanted || entry.loading)
        return;
    entry.wanted = true;
    m_queue.add_requested(key);
    m_work.notify_one();
}

BlockPin BlockManager::find(const voxel::BoxKey& key) {
    if (key.level < 0 || key.level > voxel::kMaxLevel ||
        !m_ranges[static_cast<std::size_t>(key.level)].contains(key))
        return m_air;
    const std::lock_guard lock(m_mutex);
    Entry* const entry = m_cache.find(key);
    if (!entry || !entry->block) {
        m_cache.count_miss();
        return nullptr;
    }
    m_cache.count_hit();
    touch(*entry);
    return entry->block;
}

void BlockManager::wait_for(const voxel::BoxKey& key, BlockListener& listener,
                            std::uint64_t ticket) {
    const std::lock_guard lock(m_mutex);
    Entry& entry = m_cache.entry_of(key);
    if (entry.block) {
        listener.on_block_loaded(key, ticket);
        return;
    }
    m_cache.count_wait();
    entry.waits.push_back({&listener, ticket});
    request(key, entry);
}

void BlockManager::forget(const BlockListener& listener, std::optional<std::uint64_t> ticket) {
    const std::lock_guard lock(m_mutex);
    if (m_cache.remove_waits(listener, ticket))
        m_work.notify_all();
    m_queue.drop_requested([this](const voxel::BoxKey& key) { return !m_cache.contains(key); });
}

BlockPin BlockManager::get(const voxel::BoxKey& key) {
    if (BlockPin block = find(key))
        return block;
    std::unique_lock lock(m_mutex);
    while (true) {
        Entry& entry = m_cache.entry_of(key);
        if (entry.block) {
            touch(entry);
            return entry.block;
        }
        if (m_stop)
            return std::make_shared<const Block>(Block{nullptr, true});
        request(key, entry);
        ++entry.getters;
        m_loaded.wait(lock);
        --entry.getters;
    }
}

void BlockManager::prefetch(std::vector<voxel::BoxKey> keys) {
    const std::lock_guard lock(m_mutex);
    m_queue.replace_prefetched(keys);
    m_work.notify_all();
}

void BlockManager::forget_holes() {
    const std::lock_guard lock(m_mutex);
    m_holes.forget([this](const voxel::BoxKey& key) {
        Entry* const entry = m_cache.find(key);
        if (!entry || !entry->block)
            return true;
        if (entry->getters > 0)
            return false;
        touch(*entry);
        m_cache.remove(key);
        return true;
    });
}

BlockStats BlockManager::stats() const {
    const std::lock_guard lock(m_mutex);
    BlockStats out = m_cache.stats();
    out.holes = m_holes.size();
    return out;
}

void BlockManager::check_world() const {
    const std::lock_guard lock(m_mutex);
    m_holes.check_world();
}

bool BlockManager::is_hole(const voxel::BoxKey& key) const {
    const std::lock_guard lock(m_mutex);
    return m_holes.contains(key);
}

std::size_t BlockManager::hole_count() const {
    const std::lock_guard lock(m_mutex);
    return m_holes.size();
}

}  // namespace terravox::blocks
