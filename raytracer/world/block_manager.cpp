#include "raytracer/world/block_manager.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/free_memory.hpp"

namespace terravox {
namespace {

constexpr std::size_t kMostReasons = 100;
constexpr std::size_t kMuchFreed_bytes = std::size_t{64} << 20;
constexpr std::size_t kMostRemembered = std::size_t{1} << 20;  // keys, for the count of boxes loaded again: some 50 MiB

}  // namespace

BlockManager::BlockManager(voxel::World& world, std::size_t memory_bytes, int loaders) : m_world(world), m_limit_bytes(memory_bytes) {
    for (int level = 0; level <= voxel::kMaxLevel; ++level)
        m_ranges[static_cast<std::size_t>(level)] = world.info().bounds.empty() ? voxel::BoxRange{} : voxel::boxes_over(world.info().bounds, level);
    for (int i = 0; i < std::max(loaders, 1); ++i) m_loaders.emplace_back([this] { load_boxes(); });
}

BlockManager::~BlockManager() {
    {
        const std::lock_guard lock(m_mutex);
        m_stop = true;
        m_work.notify_all();
    }
    m_world.stop();
    for (std::thread& t : m_loaders) t.join();
}

void BlockManager::touch(Entry& entry) {
    if (entry.unseen) {
        entry.unseen = false;
        m_unseen_bytes -= entry.block->memory_bytes();
        m_work.notify_all();
    }
    m_order.splice(m_order.begin(), m_order, entry.place);
}

BlockPin BlockManager::find(const voxel::BoxKey& key) {
    if (key.level < 0 || key.level > voxel::kMaxLevel || !m_ranges[static_cast<std::size_t>(key.level)].contains(key)) return m_air;
    const std::lock_guard lock(m_mutex);
    const auto found = m_entries.find(key);
    if (found == m_entries.end() || !found->second.block) {
        ++m_stats.misses;
        return nullptr;
    }
    ++m_stats.hits;
    touch(found->second);
    return found->second.block;
}

void BlockManager::wait_for(const voxel::BoxKey& key, BlockListener& listener, std::uint64_t ticket) {
    const std::lock_guard lock(m_mutex);
    Entry& entry = m_entries[key];
    if (entry.block) {
        listener.block_came(key, ticket);
        return;
    }
    ++m_stats.waits;
    entry.waits.push_back({&listener, ticket});
    if (entry.wanted || entry.loading) return;
    entry.wanted = true;
    m_wanted.push_back(key);
    m_work.notify_one();
}

void BlockManager::forget(const BlockListener& listener) {
    const std::lock_guard lock(m_mutex);
    for (auto it = m_entries.begin(); it != m_entries.end();) {
        Entry& entry = it->second;
        std::erase_if(entry.waits, [&](const Wait& w) { return w.listener == &listener; });
        if (entry.unseen && entry.block && entry.getters == 0) touch(entry);  // its looker may have been this one
        const bool idle = !entry.block && entry.waits.empty() && !entry.loading && entry.getters == 0;
        it = idle ? m_entries.erase(it) : std::next(it);
    }
    std::erase_if(m_wanted, [&](const voxel::BoxKey& key) { return !m_entries.contains(key); });
}

BlockPin BlockManager::get(const voxel::BoxKey& key) {
    if (BlockPin block = find(key)) return block;
    std::unique_lock lock(m_mutex);
    while (true) {
        Entry& entry = m_entries[key];
        if (entry.block) {
            touch(entry);
            return entry.block;
        }
        if (!entry.wanted && !entry.loading) {
            entry.wanted = true;
            m_wanted.push_back(key);
            m_work.notify_one();
        }
        ++entry.getters;
        m_came.wait(lock);
        --entry.getters;
    }
}

void BlockManager::prefetch(std::vector<voxel::BoxKey> keys) {
    const std::lock_guard lock(m_mutex);
    m_foreseen.assign(keys.begin(), keys.end());
    m_work.notify_all();
}

// The lock is held. False: nothing to load now.
bool BlockManager::next_key(voxel::BoxKey& key) {
    if (m_unseen_bytes > m_limit_bytes / 4) return false;
    if (!m_wanted.empty()) {
        key = m_wanted.front();
        m_wanted.pop_front();
        return true;
    }
    while (!m_foreseen.empty() && m_stats.bytes < m_limit_bytes / 4 * 3) {
        key = m_foreseen.front();
        m_foreseen.pop_front();
        const auto found = m_entries.find(key);
        if (found == m_entries.end()) return true;  // else it is here, or on its way
    }
    return false;
}

void BlockManager::load_boxes() {
    std::unique_lock lock(m_mutex);
    while (true) {
        voxel::BoxKey key;
        m_work.wait(lock, [&] { return m_stop || next_key(key); });
        if (m_stop) return;
        Entry& queued = m_entries[key];
        queued.wanted = false, queued.loading = true;
        lock.unlock();
        BlockPin block = make(key);
        std::vector<BlockPin> evicted;  // freed without the lock
        lock.lock();
        keep(key, std::move(block), evicted);
        m_came.notify_all();
        if (!evicted.empty()) {
            for (const BlockPin& gone : evicted) m_freed_bytes += gone->memory_bytes();
            const bool much = m_freed_bytes > kMuchFreed_bytes;
            if (much) m_freed_bytes = 0;
            lock.unlock();
            evicted.clear();
            if (much) util::give_back_free_memory();
            lock.lock();
        }
    }
}

BlockPin BlockManager::make(const voxel::BoxKey& key) {
    Block made;
    {
        const std::lock_guard lock(m_mutex);
        made.hole = m_holes.contains(key);  // once a hole, always a hole: a picture has one answer
    }
    if (made.hole) return std::make_shared<const Block>(std::move(made));
    try {
        made.box = m_world.box(key);
    } catch (const std::exception& e) {
        // One box less must not lose the picture; it stays visible, counted and in the exit code.
        made.hole = true;
        note_hole(key, e.what());
    } catch (...) {
        made.hole = true;
        note_hole(key, "an error without a name");
    }
    return std::make_shared<const Block>(std::move(made));
}

void BlockManager::note_hole(const voxel::BoxKey& key, const std::string& reason) {
    const std::lock_guard lock(m_mutex);
    if (m_stop) return;
    // A damaged file fails in the same words for each of its boxes: said once, the boxes are counted at the end.
    if (m_holes.insert(key).second && m_hole_reasons.size() < kMostReasons && m_hole_reasons.insert(reason).second)
        spdlog::error("hole at box {}: {}", voxel::to_string(key), reason);
}

// The lock is held.
void BlockManager::keep(const voxel::BoxKey& key, BlockPin block, std::vector<BlockPin>& evicted) {
    Entry& entry = m_entries[key];
    const std::size_t bytes = block->memory_bytes();
    auto& level = m_stats.levels[static_cast<std::size_t>(key.level)];
    ++level.loaded, level.bytes_loaded += bytes;
    if (m_loaded_once.contains(key)) ++level.reloaded;
    else if (m_loaded_once.size() < kMostRemembered) m_loaded_once.insert(key);
    entry.loading = false;
    entry.block = std::move(block);
    m_order.push_front(key);
    entry.place = m_order.begin();
    m_stats.bytes += bytes;
    if (!entry.waits.empty()) {
        entry.unseen = true;
        m_unseen_bytes += bytes;
        for (const Wait& wait : entry.waits) wait.listener->block_came(key, wait.ticket);
        entry.waits.clear();
        entry.waits.shrink_to_fit();
    }
    evict(evicted);
    m_stats.peak_bytes = std::max(m_stats.peak_bytes, m_stats.bytes);
}

void BlockManager::evict(std::vector<BlockPin>& evicted) {
    auto it = m_order.end();
    while (m_stats.bytes > m_limit_bytes && it != m_order.begin()) {
        --it;
        const auto found = m_entries.find(*it);
        Entry& entry = found->second;
        // A pin can only be taken under the lock, so one that nobody holds now stays free until it is gone.
        if (entry.unseen || entry.getters > 0 || entry.block.use_count() > 1 || it == m_order.begin()) continue;
        m_stats.bytes -= entry.block->memory_bytes();
        ++m_stats.levels[static_cast<std::size_t>(it->level)].evicted;
        evicted.push_back(std::move(entry.block));
        m_entries.erase(found);
        it = m_order.erase(it);
    }
}

BlockStats BlockManager::stats() const {
    const std::lock_guard lock(m_mutex);
    BlockStats out = m_stats;
    out.entries = m_order.size();
    out.holes = m_holes.size();
    return out;
}

std::size_t BlockManager::hole_count() const {
    const std::lock_guard lock(m_mutex);
    return m_holes.size();
}

}  // namespace terravox
