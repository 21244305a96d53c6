#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"

namespace terravox::boxes {

/// The kind of a cached item.
enum class Kind : int { kBox = 0, kMapTile = 1 };

/// The bytes of an item, and the extent of its inputs.
struct Item {
    std::uint64_t tag = 0;                     ///< opaque to the cache: returned as it was given
    std::shared_ptr<const std::string> bytes;  ///< nullptr is a value, too: known to be empty
    voxel::InputExtent reach;
};

/// A queue of writes, and the thread that passes them on in batches. Thread-safe.
///
/// The thread takes everything that is queued as one batch, in the order in which it was queued.
/// One lock guards the queue; it is not held while the functions given to the constructor run.
class BatchWriter {
public:
    struct Write {
        Kind kind = Kind::kBox;
        voxel::BoxKey key;
        Item item;
        /// When not 0: the row to mark as used; all other members are then ignored.
        std::int64_t used_row = 0;
    };

    struct Limits {
        std::size_t queue_bytes = std::size_t{16} << 20;  ///< sum of the sizes of queued items
        /// Rows are marked as used while no more than this number of writes is queued.
        std::size_t queue_writes = 10'000;
        /// An empty batch is written after this time without work.
        std::chrono::milliseconds idle{6000};
    };

    /// Starts the thread. Both functions are called on it only; what they refer to outlives the
    /// writer.
    /// @param start called once, before the first batch; must not throw
    /// @param write called with each batch; must not throw
    /// @throws std::system_error when the thread cannot be started
    BatchWriter(const Limits& limits, std::function<void()> start,
                std::function<void(const std::vector<Write>&)> write);
    ~BatchWriter();  ///< writes the queued writes first
    BatchWriter(const BatchWriter&) = delete;
    BatchWriter& operator=(const BatchWriter&) = delete;

    enum class WhenFull { kDrop, kWait };
    /// Queues an item.
    /// @param bytes size of the item, for the limit of the queue
    /// @param when_full what to do when the queue is full. An item larger than the limit is
    /// dropped, or waits until the queue is empty.
    /// @return false when the item was dropped
    [[nodiscard]] bool put(Write write, std::size_t bytes, WhenFull when_full);

    /// Queues the marking of a row as used; does nothing while the queue is long.
    /// @param row not 0
    void mark_used(std::int64_t row);

    void flush();  ///< returns when `start` has run and all queued writes are written

private:
    void run();

    const Limits m_limits;
    const std::function<void()> m_start;
    const std::function<void(const std::vector<Write>&)> m_write;

    std::mutex m_mutex;  ///< guards the following members, except m_thread
    std::condition_variable m_queued;
    std::condition_variable m_written;
    std::deque<Write> m_queue;
    std::size_t m_queue_bytes = 0;
    bool m_busy = true;  ///< whether the thread is working; its first task is `start`
    bool m_closing = false;
    std::thread m_thread;
};

}  // namespace terravox::boxes
