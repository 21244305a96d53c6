#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"

namespace terravox::boxes {

class SqliteError;

/// The kind of a cached item.
enum class Kind : int { kBox = 0, kMapTile = 1 };

/// The bytes of an item, and the extent of its inputs.
struct Item {
    std::uint64_t tag = 0;                     ///< opaque to the cache: returned as it was given
    std::shared_ptr<const std::string> bytes;  ///< nullptr is a value, too: known to be empty
    voxel::InputExtent reach;
};

struct DiskStats {
    std::uint64_t hits = 0, misses = 0, writes = 0, evictions = 0, dropped = 0, damaged = 0;
    std::uint64_t bytes = 0, entries = 0;
};

/// A persistent cache. Thread-safe; several processes may share a file.
///
/// An item is valid only while the fingerprint of its reach equals the one at the time of put(): a
/// change of the inputs invalidates only the items that it reaches, and reverting the change makes
/// them valid again. Invalid items are never requested and are therefore evicted first, since
/// eviction is LRU once the file exceeds its limit. Each item has a checksum; a damaged one is
/// treated as absent, with a warning.
///
/// One SQLite file in WAL mode: if the process is killed, an item is stored completely or not at
/// all. Writing is done by a separate thread, which batches the queued items into one transaction.
/// A file that cannot be opened, written to or read is reported once; from then on nothing is
/// stored.
///
/// Three locks: one for the reading connection, one for the connection that lists and counts (which
/// may take long in a large file, and must not delay requests for boxes), one for the queue to the
/// writer; no lock is held while another is taken.
class DiskCache {
public:
    using FingerprintOf = std::function<voxel::Fingerprint(const voxel::InputExtent&)>;

    /// @param limit_bytes limit of the file; its write-ahead log (some MiB) is not included
    /// @param fingerprint thread-safe; outlives the cache
    DiskCache(std::filesystem::path file, std::uint64_t limit_bytes, FingerprintOf fingerprint);
    ~DiskCache();  ///< writes the queued items first
    DiskCache(const DiskCache&) = delete;
    DiskCache& operator=(const DiskCache&) = delete;

    [[nodiscard]] std::optional<Item> find(Kind kind, const voxel::BoxKey& key);

    enum class WhenFull { kDrop, kWait };
    /// Queues an item for writing.
    /// @param when_full what to do when the queue is full; dropped items are counted
    void put(Kind kind, const voxel::BoxKey& key, const Item& item,
             WhenFull when_full = WhenFull::kDrop);

    void flush();  ///< returns when all queued items are on disk

    /// Whether nothing is stored any more because the file cannot be opened, read or written to.
    /// When only writing fails, its items can still be found.
    [[nodiscard]] bool failing() const noexcept { return m_broken || m_read_only; }
    [[nodiscard]] DiskStats stats();  ///< the number of entries may be some seconds old
    /// A counter that increases with every change of the cache's content.
    [[nodiscard]] std::uint64_t changes() const noexcept { return m_changes; }
    /// Keys of the currently valid items of a level, in Morton order.
    /// @param most maximum number of keys to return
    [[nodiscard]] std::vector<voxel::BoxKey> keys(Kind kind, int level, std::size_t most);

    [[nodiscard]] const std::filesystem::path& file() const noexcept { return m_file; }
    [[nodiscard]] std::uint64_t limit_bytes() const noexcept { return m_limit_bytes; }

private:
    class Connection;
    struct Write {
        Kind kind = Kind::kBox;
        voxel::BoxKey key;
        Item item;
        /// When not 0: the row to mark as used; all other members are then ignored.
        std::int64_t touched = 0;
    };
    void open();
    void begin_anew();
    void write_on();
    void count_now_and_then();
    void stop_writing(const std::exception& e);
    [[nodiscard]] std::size_t write_all(const std::vector<Write>& writes);
    void evict();
    void touch(std::int64_t row);
    void complain(const SqliteError& e);
    void give_up(const SqliteError& e);

    const std::filesystem::path m_file;
    const std::uint64_t m_limit_bytes;
    const FingerprintOf m_fingerprint;
    std::atomic<bool> m_broken{false}, m_read_only{false};
    std::atomic<std::uint64_t> m_hits{0}, m_misses{0}, m_writes{0}, m_evictions{0}, m_dropped{0},
        m_damaged{0}, m_changes{0};

    std::mutex m_reading;  ///< guards m_reader
    std::unique_ptr<Connection> m_reader;
    std::mutex m_listing;  ///< guards m_lister
    std::unique_ptr<Connection> m_lister;
    std::unique_ptr<Connection> m_writer;  ///< used only by the writing thread
    std::atomic<std::uint64_t> m_entries{0};
    /// Last count; used only by the writing thread.
    std::chrono::steady_clock::time_point m_counted;

    std::mutex m_queueing;  ///< guards the following members
    std::condition_variable m_queued, m_written;
    std::deque<Write> m_queue;
    std::size_t m_queue_bytes = 0;
    /// m_busy: whether the writing thread is working; its first task is to count.
    bool m_busy = true, m_closing = false;
    std::thread m_thread;
};

}  // namespace terravox::boxes
