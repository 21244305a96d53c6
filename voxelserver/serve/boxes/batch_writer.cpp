#include "voxelserver/serve/boxes/batch_writer.hpp"

#include <iterator>
#include <utility>

namespace terravox::boxes {

BatchWriter::BatchWriter(const Limits& limits, std::function<void()> start,
                         std::function<void(const std::vector<Write>&)> write)
    : m_limits(limits), m_start(std::move(start)), m_write(std::move(write)) {
    m_thread = std::thread([this] { run(); });
}

BatchWriter::~BatchWriter() {
    {
        const std::lock_guard lock(m_mutex);
        m_closing = true;
    }
    m_queued.notify_all();
    m_thread.join();
}

bool BatchWriter::put(Write write, std::size_t bytes, WhenFull when_full) {
    std::unique_lock lock(m_mutex);
    if (m_queue_bytes + bytes > m_limits.queue_bytes) {
        if (when_full == WhenFull::kDrop)
            return false;
        m_written.wait(lock, [&] {
            return m_queue_bytes + bytes <= m_limits.queue_bytes || m_queue.empty() || m_closing;
        });
    }
    m_queue_bytes += bytes;
    m_queue.push_back(std::move(write));
    lock.unlock();
    m_queued.notify_one();
    return true;
}

void BatchWriter::mark_used(std::int64_t row) {
    const std::lock_guard lock(m_mutex);
    if (m_queue.size() > m_limits.queue_writes)
        return;  // the times of last use may be late, but the queue must stay short
    Write write;
    write.used_row = row;
    m_queue.push_back(std::move(write));
    m_queued.notify_one();
}

void BatchWriter::flush() {
    std::unique_lock lock(m_mutex);
    m_written.wait(lock, [&] { return m_queue.empty() && !m_busy; });
}

void BatchWriter::run() {
    m_start();
    for (;;) {
        std::vector<Write> writes;
        {
            std::unique_lock lock(m_mutex);
            m_busy = false;
            m_written.notify_all();
            // Wakes up periodically also without work, to pass on an empty batch after a burst.
            const bool work = m_queued.wait_for(lock, m_limits.idle,
                                                [&] { return !m_queue.empty() || m_closing; });
            if (work && m_queue.empty())
                return;
            writes.assign(std::make_move_iterator(m_queue.begin()),
                          std::make_move_iterator(m_queue.end()));
            m_queue.clear();
            m_queue_bytes = 0;
            m_busy = true;
        }
        m_write(writes);
    }
}

}  // namespace terravox::boxes
