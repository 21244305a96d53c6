#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "common/util/cache.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/boxes/batch_writer.hpp"

namespace terravox::boxes {

class SqliteError;

struct DiskStats : util::CacheStats {
    std::uint64_t writes = 0;
    std::uint64_t dropped = 0;
    std::uint64_t damaged = 0;
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
/// Four locks: one for the counts, one for the reading connection, one for the connection that
/// lists and counts (which may take long in a large file, and must not delay requests for boxes),
/// one for the queue to the writer; no lock is held while another is taken.
class DiskCache {
public:
    using MakeFingerprint = std::function<voxel::Fingerprint(const voxel::InputExtent&)>;

    /// @param limit_bytes limit of the file; its write-ahead log (some MiB) is not included
    /// @param fingerprint thread-safe; outlives the cache
    DiskCache(std::filesystem::path file, std::uint64_t limit_bytes, MakeFingerprint fingerprint);
    ~DiskCache();  ///< writes the queued items first
    DiskCache(const DiskCache&) = delete;
    DiskCache& operator=(const DiskCache&) = delete;

    [[nodiscard]] std::optional<Item> find(Kind kind, const voxel::BoxKey& key);

    using WhenFull = BatchWriter::WhenFull;
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
    /// @param max_keys maximum number of keys to return
    [[nodiscard]] std::vector<voxel::BoxKey> keys(Kind kind, int level, std::size_t max_keys);

    [[nodiscard]] const std::filesystem::path& file() const noexcept { return m_file; }
    [[nodiscard]] std::uint64_t limit_bytes() const noexcept { return m_limit_bytes; }

private:
    class Connection;
    void open();
    void recreate();
    void count_periodically();
    void stop_writing(const std::exception& e);
    void begin_writing();
    void write_batch(const std::vector<BatchWriter::Write>& writes);
    [[nodiscard]] std::size_t write_all(const std::vector<BatchWriter::Write>& writes);
    void evict();
    void count(std::uint64_t DiskStats::* what, std::uint64_t many = 1);
    void warn(const SqliteError& e);
    void disable(const SqliteError& e);

    const std::filesystem::path m_file;
    const std::uint64_t m_limit_bytes;
    const MakeFingerprint m_fingerprint;
    std::atomic<bool> m_broken{false};
    std::atomic<bool> m_read_only{false};
    std::atomic<std::uint64_t> m_changes{0};

    std::mutex m_stats_mutex;  ///< guards m_stats
    DiskStats m_stats;         ///< without bytes; entries as of the last count

    std::mutex m_reader_mutex;  ///< guards m_reader
    std::unique_ptr<Connection> m_reader;
    std::mutex m_lister_mutex;  ///< guards m_lister
    std::unique_ptr<Connection> m_lister;
    std::unique_ptr<Connection> m_writer;  ///< used only by the writing thread
    /// Last count; used only by the writing thread.
    std::chrono::steady_clock::time_point m_counted;

    /// nullopt when the file could not be opened: m_broken is then set for good. The last member,
    /// since its thread uses the others until it is joined.
    std::optional<BatchWriter> m_batch_writer;
};

}  // namespace terravox::boxes
