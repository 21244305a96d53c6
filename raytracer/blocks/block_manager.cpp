#include "raytracer/blocks/block_manager.hpp"

#include <algorithm>

#include "common/thread/start_threads.hpp"

namespace terravox::blocks {
namespace {

// Keys remembered to count boxes that are loaded again: some 50 MiB.
constexpr std::size_t kMaxRemembered = std::size_t{1} << 20;

// A box with a waiter must not be queued behind whole batches of others.
std::size_t loaders_ahead(std::size_t loaders, std::size_t batch) noexcept {
    return batch == 1 ? loaders : std::max<std::size_t>(loaders - loaders / 4, 1);
}

}  // namespace

BlockManager::BlockManager(voxel::World& world, std::size_t memory_bytes, int loaders)
    : m_world(world),
      m_limit_bytes(memory_bytes),
      m_batch(static_cast<std::size_t>(std::max(world.preferred_batch(), 1))),
      m_loader_count(static_cast<std::size_t>(std::max(loaders, 1))),
      m_max_ahead(loaders_ahead(m_loader_count, m_batch)) {
    for (int level = 0; level <= voxel::kMaxLevel; ++level)
        m_ranges[static_cast<std::size_t>(level)] =
            world.info().bounds.empty() ? voxel::BoxRange{}
                                        : voxel::boxes_over(world.info().bounds, level);
    thread::start_threads(m_loaders, m_loader_count, [this] { load_boxes(); }, [this] { stop(); });
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
        m_came.notify_all();
    }
    m_world.stop();
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
    if (key.level < 0 || key.level > voxel::kMaxLevel ||
        !m_ranges[static_cast<std::size_t>(key.level)].contains(key))
        return m_air;
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

void BlockManager::wait_for(const voxel::BoxKey& key, BlockListener& listener,
                            std::uint64_t ticket) {
    const std::lock_guard lock(m_mutex);
    Entry& entry = m_entries[key];
    if (entry.block) {
        listener.block_came(key, ticket);
        return;
    }
    ++m_stats.waits;
    entry.waits.push_back({&listener, ticket});
    if (entry.wanted || entry.loading)
        return;
    entry.wanted = true;
    m_wanted.push_back(key);
    m_work.notify_one();
}

void BlockManager::forget(const BlockListener& listener, std::optional<std::uint64_t> ticket) {
    const std::lock_guard lock(m_mutex);
    for (auto it = m_entries.begin(); it != m_entries.end();) {
        Entry& entry = it->second;
        std::erase_if(entry.waits, [&](const Wait& w) {
            return w.listener == &listener && (!ticket || w.ticket == *ticket);
        });
        if (entry.unseen && entry.block && entry.getters == 0)
            touch(entry);  // this call may be the read that the box was kept for
        const bool idle =
            !entry.block && entry.waits.empty() && !entry.loading && entry.getters == 0;
        it = idle ? m_entries.erase(it) : std::next(it);
    }
    std::erase_if(m_wanted, [&](const voxel::BoxKey& key) { return !m_entries.contains(key); });
}

BlockPin BlockManager::get(const voxel::BoxKey& key) {
    if (BlockPin block = find(key))
        return block;
    std::unique_lock lock(m_mutex);
    while (true) {
        Entry& entry = m_entries[key];
        if (entry.block) {
            touch(entry);
            return entry.block;
        }
        if (m_stop)
            return std::make_shared<const Block>(Block{nullptr, true});
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
    m_prefetched.assign(keys.begin(), keys.end());
    m_work.notify_all();
}

// The lock must be held.
void BlockManager::keep(const voxel::BoxKey& key, BlockPin block, std::vector<BlockPin>& evicted) {
    Entry& entry = m_entries[key];
    const std::size_t bytes = block->memory_bytes();
    auto& level = m_stats.levels[static_cast<std::size_t>(key.level)];
    ++level.loaded;
    level.bytes_loaded += bytes;
    if (m_loaded_once.contains(key))
        ++level.reloaded;
    else if (m_loaded_once.size() < kMaxRemembered)
        m_loaded_once.insert(key);
    entry.loading = false;
    entry.block = std::move(block);
    m_order.push_front(key);
    entry.place = m_order.begin();
    m_stats.bytes += bytes;
    for (const Wait& wait : entry.waits)
        entry.unseen |= wait.listener->block_came(key, wait.ticket);
    if (entry.unseen)
        m_unseen_bytes += bytes;
    entry.waits.clear();
    entry.waits.shrink_to_fit();
    evict(evicted);
    m_stats.peak_bytes = std::max(m_stats.peak_bytes, m_stats.bytes);
}

void BlockManager::evict(std::vector<BlockPin>& evicted) {
    auto it = m_order.end();
    while (m_stats.bytes > m_limit_bytes && it != m_order.begin()) {
        --it;
        const auto found = m_entries.find(*it);
        Entry& entry = found->second;
        // A pin can only be taken under the lock, so a block without one now stays unpinned until
        // it is evicted.
        if (entry.unseen || entry.getters > 0 || entry.block.use_count() > 1 ||
            it == m_order.begin())
            continue;
        m_stats.bytes -= entry.block->memory_bytes();
        ++m_stats.levels[static_cast<std::size_t>(it->level)].evicted;
        evicted.push_back(std::move(entry.block));
        m_entries.erase(found);
        it = m_order.erase(it);
    }
}

void BlockManager::forget_holes() {
    const std::lock_guard lock(m_mutex);
    ++m_forgotten;
    std::erase_if(m_holes, [this](const voxel::BoxKey& key) {
        const auto found = m_entries.find(key);
        if (found == m_entries.end() || !found->second.block)
            return true;
        if (found->second.getters > 0)
            return false;
        if (found->second.unseen)
            touch(found->second);
        m_stats.bytes -= found->second.block->memory_bytes();
        m_order.erase(found->second.place);
        m_entries.erase(found);
        return true;
    });
}

BlockStats BlockManager::stats() const {
    const std::lock_guard lock(m_mutex);
    BlockStats out = m_stats;
    out.entries = m_order.size();
    out.holes = m_holes.size();
    return out;
}

void BlockManager::check_world() const {
    const std::lock_guard lock(m_mutex);
    if (m_changed)
        std::rethrow_exception(m_changed);
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
