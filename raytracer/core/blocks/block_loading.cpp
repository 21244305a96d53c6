// The loaders of the block manager: what they request from the world, and how they handle the
// results.

#include <algorithm>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include "common/thread/stopped_error.hpp"
#include "common/util/free_memory.hpp"
#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/blocks/packed_box.hpp"

namespace terravox::blocks {
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
            Entry& queued = m_cache.entry_of(key);
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
