#include "raytracer/core/blocks/block_cache.hpp"

#include <algorithm>
#include <iterator>

namespace terravox::blocks {
namespace {

// Keys remembered to count boxes that are loaded again: some 50 MiB.
constexpr std::size_t kMaxRemembered = std::size_t{1} << 20;
// Of a box, until one has been loaded.
constexpr std::size_t kGuessed_bytes = std::size_t{64} << 10;

}  // namespace

BlockCache::Entry& BlockCache::insert(const voxel::BoxKey& key, BlockPin block) {
    Entry& entry = m_entries[key];
    m_order.push_front(key);
    const bool reloaded = m_loaded_once.contains(key);
    if (!reloaded && m_loaded_once.size() < kMaxRemembered) {
        try {
            m_loaded_once.insert(key);
        } catch (...) {
            m_order.pop_front();
            throw;
        }
    }
    const std::size_t bytes = block->memory_bytes();
    auto& level = m_stats.levels[static_cast<std::size_t>(key.level)];
    ++level.loaded;
    level.bytes_loaded += bytes;
    level.reloaded += reloaded ? 1 : 0;
    entry.loading = false;
    entry.block = std::move(block);
    entry.place = m_order.begin();
    m_stats.bytes += bytes;
    return entry;
}

void BlockCache::set_unseen(Entry& entry) noexcept {
    entry.unseen = true;
    m_unseen_bytes += entry.block->memory_bytes();
}

void BlockCache::evict(std::vector<BlockPin>& evicted) {
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
        evicted.push_back(entry.block);  // may throw, and then nothing has changed
        m_stats.bytes -= entry.block->memory_bytes();
        ++m_stats.levels[static_cast<std::size_t>(it->level)].evicted;
        m_entries.erase(found);
        it = m_order.erase(it);
    }
    m_stats.peak_bytes = std::max(m_stats.peak_bytes, m_stats.bytes);
}

void BlockCache::remove(const voxel::BoxKey& key) {
    const auto found = m_entries.find(key);
    m_stats.bytes -= found->second.block->memory_bytes();
    m_order.erase(found->second.place);
    m_entries.erase(found);
}

bool BlockCache::remove_waits(const BlockListener& listener, std::optional<std::uint64_t> ticket) {
    bool was_unseen = false;
    for (auto it = m_entries.begin(); it != m_entries.end();) {
        Entry& entry = it->second;
        std::erase_if(entry.waits, [&](const Wait& w) {
            return w.listener == &listener && (!ticket || w.ticket == *ticket);
        });
        if (entry.unseen && entry.block && entry.getters == 0)
            was_unseen |= touch(entry);  // this call may be the read that the box was kept for
        const bool idle =
            !entry.block && entry.waits.empty() && !entry.loading && entry.getters == 0;
        it = idle ? m_entries.erase(it) : std::next(it);
    }
    return was_unseen;
}

BlockStats BlockCache::stats() const {
    BlockStats out = m_stats;
    out.entries = m_order.size();
    return out;
}

MemoryUse BlockCache::memory_use() const noexcept {
    std::uint64_t loaded = 0;
    std::uint64_t bytes = 0;
    for (const auto& level : m_stats.levels) {
        loaded += level.loaded;
        bytes += level.bytes_loaded;
    }
    const std::size_t mean_bytes =
        loaded > 0 ? static_cast<std::size_t>(bytes / loaded) : kGuessed_bytes;
    return {m_stats.bytes, m_unseen_bytes, mean_bytes};
}

}  // namespace terravox::blocks
