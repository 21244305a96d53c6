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

/// What a kept item is.
enum class Kind : int { kBox = 0, kMapTile = 1 };

/// Bytes and what they were made of.
struct Item {
    std::uint64_t tag = 0;                     ///< the maker's own: it comes back as it was given
    std::shared_ptr<const std::string> bytes;  ///< nullptr is a value, too: known to be empty
    voxel::InputExtent reach;
};

struct DiskStats {
    std::uint64_t hits = 0, misses = 0, writes = 0, evictions = 0, dropped = 0, damaged = 0;
    std::uint64_t bytes = 0, entries = 0;
};

/// Items on disk, from one process to the next. Thread-safe; several processes may share a file.
///
/// An item counts only while the fingerprint of its reach is what it was when it was put: a change
/// of the inputs makes just those items useless that it reached, and taking the change back makes
/// them good again. Useless ones are never asked for and so go first: what was used longest ago
/// goes when the file passes its limit. Each item has a checksum; a damaged one counts as absent,
/// with a warning.
///
/// One SQLite file in WAL mode: a killed process leaves all or nothing of an item. Writing has a
/// thread of its own, which puts what has gathered in one transaction. A file that cannot be
/// opened, written to or read is reported once; from then on nothing is kept.
///
/// Three locks: one for the reading connection, one for the connection that lists and counts (which
/// may take long in a large file, and must not hold up whoever wants a box), one for the queue to
/// the writer; none is held while another is taken.
class DiskCache {
public:
    using FingerprintOf = std::function<voxel::Fingerprint(const voxel::InputExtent&)>;

    /// @param limit_bytes of the file; its write-ahead log (some MiB) comes on top  @param
    /// fingerprint thread-safe; outlives the cache
    DiskCache(std::filesystem::path file, std::uint64_t limit_bytes, FingerprintOf fingerprint);
    ~DiskCache();  ///< writes what still waits
    DiskCache(const DiskCache&) = delete;
    DiskCache& operator=(const DiskCache&) = delete;

    [[nodiscard]] std::optional<Item> find(Kind kind, const voxel::BoxKey& key);

    enum class WhenFull { kDrop, kWait };
    /// Participants an item to the writer. @param when_full what to do when too much waits to be
    /// written; dropped items are counted
    void put(Kind kind, const voxel::BoxKey& key, const Item& item,
             WhenFull when_full = WhenFull::kDrop);

    void flush();  ///< returns when all that was put is on disk

    /// Nothing more is kept: the file cannot be opened, read or written to. What it holds can still
    /// be found where only writing fails.
    [[nodiscard]] bool failing() const noexcept { return m_broken || m_read_only; }
    [[nodiscard]] DiskStats stats();  ///< entries: as counted some seconds ago
    /// Rises with every change of what is kept.
    [[nodiscard]] std::uint64_t changes() const noexcept { return m_changes; }
    /// Keys of a level that are good now, in the order of their Morton codes. @param most no more
    /// than so many
    [[nodiscard]] std::vector<voxel::BoxKey> keys(Kind kind, int level, std::size_t most);

    [[nodiscard]] const std::filesystem::path& file() const noexcept { return m_file; }
    [[nodiscard]] std::uint64_t limit_bytes() const noexcept { return m_limit_bytes; }

private:
    class Connection;
    struct Write {
        Kind kind = Kind::kBox;
        voxel::BoxKey key;
        Item item;
        std::int64_t touched = 0;  ///< a row that was used, when not 0: nothing else of this counts
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
    std::unique_ptr<Connection> m_writer;  ///< used by the writing thread alone
    std::atomic<std::uint64_t> m_entries{0};
    std::chrono::steady_clock::time_point m_counted;  ///< of the writing thread

    std::mutex m_queueing;  ///< guards what follows
    std::condition_variable m_queued, m_written;
    std::deque<Write> m_queue;
    std::size_t m_queue_bytes = 0;
    bool m_busy = true,
         m_closing =
             false;  ///< m_busy: the writing thread has something in hand, at first counting
    std::thread m_thread;
};

}  // namespace terravox::boxes
