// The loaders of the block manager: what they request from the world, and how they handle the
// results.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <string>

#include "common/thread/stopped_error.hpp"
#include "common/util/free_memory.hpp"
#include "raytracer/blocks/block_manager.hpp"

namespace terravox::blocks {
namespace {

constexpr std::size_t kMaxReasons = 100;
constexpr std::size_t kMuchFreed_bytes = std::size_t{64} << 20;
// Of a box, until one has been loaded.
constexpr std::size_t kGuessed_bytes = std::size_t{64} << 10;

template <class Kind>
bool is(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const Kind&) {
        return true;
    } catch (...) {
        return false;
    }
}

std::string reason_of(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const std::exception& e) {
        return e.what();
    } catch (...) {
        return "an error without a name";
    }
}

}  // namespace

// Shares the queue among the idle loaders. The caller, one of them, holds the lock.
std::size_t BlockManager::share_of(std::size_t queued) const noexcept {
    const std::size_t idle = m_loader_count - m_busy;
    return std::clamp<std::size_t>((queued + idle - 1) / idle, 1, m_batch);
}

// Bytes that the requested boxes and `more` additional ones may need, at the average size so far.
std::size_t BlockManager::coming_bytes(std::size_t more) const noexcept {
    std::uint64_t loaded = 0, bytes = 0;
    for (const auto& level : m_stats.levels) {
        loaded += level.loaded;
        bytes += level.bytes_loaded;
    }
    return (m_coming + more) *
           (loaded > 0 ? static_cast<std::size_t>(bytes / loaded) : kGuessed_bytes);
}

// The lock must be held. Returns false if there is nothing to load now.
bool BlockManager::next_keys(std::vector<voxel::BoxKey>& keys) {
    keys.clear();
    if (m_unseen_bytes > m_limit_bytes / 4)
        return false;
    if (!m_wanted.empty())
        take_wanted(share_of(m_wanted.size()), keys);
    else if (m_ahead < m_max_ahead)
        take_prefetched(share_of(m_prefetched.size()), keys);
    return !keys.empty();
}

// The first box is taken even without room for it, or none would ever be loaded; others only where
// everything requested fits.
void BlockManager::take_wanted(std::size_t most, std::vector<voxel::BoxKey>& keys) {
    while (!m_wanted.empty() && keys.size() < most &&
           (keys.empty() || m_unseen_bytes + coming_bytes(keys.size() + 1) <= m_limit_bytes / 4)) {
        keys.push_back(m_wanted.front());
        m_wanted.pop_front();
    }
}

void BlockManager::take_prefetched(std::size_t most, std::vector<voxel::BoxKey>& keys) {
    const std::size_t room_bytes = m_limit_bytes / 4 * 3;
    while (!m_prefetched.empty() && keys.size() < most && m_stats.bytes < room_bytes &&
           (keys.empty() || m_stats.bytes + coming_bytes(keys.size() + 1) < room_bytes)) {
        const voxel::BoxKey key = m_prefetched.front();
        m_prefetched.pop_front();
        // Loaded, or being loaded.
        const bool known =
            m_entries.contains(key) || std::find(keys.begin(), keys.end(), key) != keys.end();
        if (!known)
            keys.push_back(key);
    }
}

void BlockManager::load_boxes() {
    std::vector<voxel::BoxKey> keys;
    std::unique_lock lock(m_mutex);
    while (true) {
        m_work.wait(lock, [&] { return m_stop || next_keys(keys); });
        if (m_stop)
            return;
        bool ahead = true;
        for (const voxel::BoxKey& key : keys) {
            Entry& queued = m_entries[key];
            ahead = ahead && !queued.wanted;
            queued.wanted = false;
            queued.loading = true;
        }
        ++m_busy;
        m_ahead += ahead ? 1 : 0;
        m_coming += keys.size();
        lock.unlock();
        while (!keys.empty())
            keys = load(keys);
        lock.lock();
        --m_busy;
        m_ahead -= ahead ? 1 : 0;
    }
}

// Returns the boxes to be requested once more: they failed before holes were forgotten.
std::vector<voxel::BoxKey> BlockManager::load(const std::vector<voxel::BoxKey>& keys) {
    // Once a hole, always a hole: a picture has one answer.
    std::vector<voxel::BoxKey> asked, holes, again;
    std::uint64_t forgotten = 0;
    {
        const std::lock_guard lock(m_mutex);
        forgotten = m_forgotten;
        for (const voxel::BoxKey& key : keys)
            (m_holes.contains(key) ? holes : asked).push_back(key);
    }
    const auto is_hole = [&](const voxel::BoxKey& key, const std::exception_ptr& failure) {
        if (!come_as_hole(key, failure, forgotten))
            again.push_back(key);
    };
    for (const voxel::BoxKey& key : holes)
        is_hole(key, nullptr);
    std::vector<voxel::BoxKey> missing(asked);
    auto reason = std::make_exception_ptr(util::Error("the world gave no answer"));
    const auto take = [&](const voxel::BoxKey& key, voxel::BoxOutcome outcome) {
        if (std::erase(missing, key) == 0)
            return;
        // A box that is not available must not end the picture; it stays visible, counted and in
        // the exit code.
        if (!outcome.failure)
            return come(key, {std::move(outcome.box), false});
        is_hole(key, is<thread::StoppedError>(outcome.failure) ? nullptr : outcome.failure);
    };
    try {
        m_world.boxes(asked, take);
    } catch (...) {
        reason = std::current_exception();
    }
    // No thread may wait for ever for boxes that the world did not return.
    for (const voxel::BoxKey& key : missing)
        is_hole(key, reason);
    return again;
}

// Returns false if holes were forgotten since the request. The check and the recording of the hole
// are under one lock, so that no forgotten hole is recorded.
bool BlockManager::come_as_hole(const voxel::BoxKey& key, const std::exception_ptr& failure,
                                std::uint64_t forgotten) {
    std::unique_lock lock(m_mutex);
    if (forgotten != m_forgotten && !m_stop)
        return false;
    if (failure)
        note_hole(key, failure);
    come(key, {nullptr, true}, std::move(lock));
    return true;
}

void BlockManager::come(const voxel::BoxKey& key, Block made) {
    come(key, std::move(made), std::unique_lock(m_mutex));
}

void BlockManager::come(const voxel::BoxKey& key, Block made, std::unique_lock<std::mutex> lock) {
    auto block = std::make_shared<const Block>(std::move(made));
    std::vector<BlockPin> evicted;  // freed without the lock
    --m_coming;
    keep(key, std::move(block), evicted);
    m_came.notify_all();
    for (const BlockPin& gone : evicted)
        m_freed_bytes += gone->memory_bytes();
    const bool much = m_freed_bytes > kMuchFreed_bytes;
    if (much)
        m_freed_bytes = 0;
    lock.unlock();
    evicted.clear();
    if (much)
        util::give_back_free_memory();
}

// The lock must be held.
void BlockManager::note_hole(const voxel::BoxKey& key, const std::exception_ptr& failure) {
    const bool changed = is<voxel::ChangedError>(failure);
    const std::string reason = reason_of(failure);
    if (m_stop)
        return;
    if (changed) {
        m_holes.insert(key);
        if (!m_changed)
            m_changed = failure;
        return;
    }
    // A damaged file fails with the same message for each of its boxes: it is logged once, and the
    // boxes are counted at the end.
    if (m_holes.insert(key).second && m_hole_reasons.size() < kMaxReasons &&
        m_hole_reasons.insert(reason).second)
        spdlog::error("hole at box {}: {}", voxel::to_string(key), reason);
}

}  // namespace terravox::blocks
