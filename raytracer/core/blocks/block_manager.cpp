// The loaders of the block manager: what they request from the world, and how they handle the
// results.
#include "raytracer/core/blocks/block_manager.hpp"

#include <algorithm>
#include <utility>

#include "common/thread/start_threads.hpp"
#include "common/thread/stop.hpp"
#include "common/util/process_memory.hpp"

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
    Entry& entry = m_cache.make_entry(key);
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
        Entry& entry = m_cache.make_entry(key);
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

namespace {

constexpr std::size_t kMuchFreed_bytes = std::size_t{64} << 20;

bool is_stopped(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const thread::StoppedError&) {
        return true;
    } catch (...) {
        return false;
    }
}

}  // namespace

// The lock must be held. Returns false if there is nothing to load now.
bool BlockManager::next_request(LoadQueue::Request& request) {
    const auto is_known = [this](const voxel::BoxKey& key) { return m_cache.contains(key); };
    return m_queue.take(m_cache.memory_use(), is_known, request);
}

void BlockManager::load_boxes() {
    LoadQueue::Request request;
    std::unique_lock lock(m_mutex);
    while (true) {
        m_work.wait(lock, [&] { return m_stop || next_request(request); });
        if (m_stop)
            return;
        for (const voxel::BoxKey& key : request.keys) {
            Entry& queued = m_cache.make_entry(key);
            queued.wanted = false;
            queued.loading = true;
        }
        lock.unlock();
        while (!request.keys.empty())
            request.keys = load(request.keys);
        lock.lock();
        m_queue.finish(request);
    }
}

// Returns the boxes to be requested once more: they failed before holes were forgotten.
std::vector<voxel::BoxKey> BlockManager::load(const std::vector<voxel::BoxKey>& keys) {
    // Once a hole, always a hole: a picture has one answer.
    std::vector<voxel::BoxKey> asked;
    std::vector<voxel::BoxKey> holes;
    std::vector<voxel::BoxKey> again;
    std::uint64_t generation = 0;
    {
        const std::lock_guard lock(m_mutex);
        generation = m_holes.generation();
        for (const voxel::BoxKey& key : keys)
            (m_holes.contains(key) ? holes : asked).push_back(key);
    }
    const auto is_hole = [&](const voxel::BoxKey& key, const std::exception_ptr& failure) {
        if (!on_load_failed(key, failure, generation))
            again.push_back(key);
    };
    for (const voxel::BoxKey& key : holes)
        is_hole(key, nullptr);
    std::vector<voxel::BoxKey> missing(asked);
    auto reason = std::make_exception_ptr(util::Error("the world gave no answer"));
    const auto take = [&](const voxel::BoxKey& key, voxel::BoxOutcome outcome) {
        if (std::ranges::find(missing, key) == missing.end())
            return;
        try {
            // A box that is not available must not end the picture; it stays visible, counted and
            // in the exit code.
            if (!outcome.failure)
                on_loaded(key, packed(std::move(outcome.box)));
            else
                is_hole(key, is_stopped(outcome.failure) ? nullptr : outcome.failure);
            std::erase(missing, key);
        } catch (...) {
            // Out of memory, most likely: the box stays among the missing ones.
            const bool has_reason = outcome.failure && !is_stopped(outcome.failure);
            reason = has_reason ? outcome.failure : std::current_exception();
        }
    };
    try {
        m_world.boxes(asked, take);
    } catch (...) {
        reason = std::current_exception();
    }
    // No thread may wait for ever for boxes that the world did not return. Where not even a hole
    // can be recorded, the exception ends the program.
    for (const voxel::BoxKey& key : missing)
        is_hole(key, reason);
    return again;
}

// Returns false if holes were forgotten since the request. The check and the recording of the hole
// are under one lock, so that no forgotten hole is recorded.
bool BlockManager::on_load_failed(const voxel::BoxKey& key, const std::exception_ptr& failure,
                                  std::uint64_t generation) {
    std::unique_lock lock(m_mutex);
    if (generation != m_holes.generation() && !m_stop)
        return false;
    if (failure && !m_stop)
        m_holes.add(key, failure);
    on_loaded(key, {nullptr, true}, std::move(lock));
    return true;
}

void BlockManager::on_loaded(const voxel::BoxKey& key, Block made) {
    on_loaded(key, std::move(made), std::unique_lock(m_mutex));
}

// Changes nothing when memory is missing.
void BlockManager::on_loaded(const voxel::BoxKey& key, Block made,
                             std::unique_lock<std::mutex> lock) {
    auto block = std::make_shared<const Block>(std::move(made));
    std::vector<BlockPin> evicted;  // freed without the lock
    keep(key, std::move(block), evicted);
    m_queue.on_box_loaded();
    m_loaded.notify_all();
    for (const BlockPin& gone : evicted)
        m_freed_bytes += gone->memory_bytes();
    const bool much = m_freed_bytes > kMuchFreed_bytes;
    if (much)
        m_freed_bytes = 0;
    lock.unlock();
    evicted.clear();
    if (much)
        util::trim_heap();
}

// The lock must be held.
void BlockManager::keep(const voxel::BoxKey& key, BlockPin block, std::vector<BlockPin>& evicted) {
    Entry& entry = m_cache.insert(key, std::move(block));
    bool will_be_read = false;
    for (const BlockCache::Wait& wait : entry.waits)
        will_be_read |= wait.listener->on_block_loaded(key, wait.ticket);
    if (will_be_read)
        m_cache.set_unseen(entry);
    entry.waits.clear();
    entry.waits.shrink_to_fit();
    try {
        m_cache.evict(evicted);
    } catch (const std::bad_alloc&) {
        // The next box evicts the rest.
    }
}

}  // namespace terravox::blocks
