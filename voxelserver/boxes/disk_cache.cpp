#include "voxelserver/boxes/disk_cache.hpp"

#include <spdlog/spdlog.h>
#include <xxhash.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#include "common/voxel/morton.hpp"
#include "voxelserver/boxes/sqlite.hpp"

namespace terravox::boxes {

namespace fs = std::filesystem;
namespace {

constexpr std::size_t kQueueBytes = std::size_t{16} << 20;
// Overhead of an item in addition to its bytes, approximately.
constexpr std::size_t kRowBytes = 200;
// Resolution of the time of last use, so that a row in steady use is not written each time.
constexpr std::int64_t kTouchAfter_s = 600;
constexpr int kEvictRows = 64;  // per batch
constexpr std::chrono::seconds kIdle{6};

// With WAL and synchronous=NORMAL, killing the process loses nothing, a power failure loses the
// latest writes, and neither leaves partial items.
constexpr const char* kPragmas =
    "PRAGMA synchronous=NORMAL; PRAGMA cache_size=-2000; PRAGMA journal_size_limit=4194304; PRAGMA "
    "wal_autocheckpoint=400; PRAGMA temp_store=MEMORY;";
// Stored in the file, so set for new files only: setting them again would write to the file, and
// each start would wait for the disk. auto_vacuum must be chosen before the first table is created.
constexpr const char* kParts =
    "SELECT count(*) FROM sqlite_master WHERE name IN ('item', 'item_key', 'item_used')";
constexpr std::int64_t kPartsOfAll = 3;
constexpr const char* kSchema =
    "PRAGMA page_size=8192; PRAGMA auto_vacuum=INCREMENTAL; PRAGMA journal_mode=WAL;"
    "CREATE TABLE IF NOT EXISTS item(id INTEGER PRIMARY KEY, kind INT, level INT, morton INT, bx "
    "INT, by INT, bz INT, fingerprint0 INT, fingerprint1 INT,"
    " min_bx INT, min_bz INT, max_bx INT, max_bz INT, used INT, tag INT, checksum INT, bytes BLOB);"
    "CREATE UNIQUE INDEX IF NOT EXISTS item_key ON item(kind, level, morton, bx, by, bz, "
    "fingerprint0, fingerprint1, min_bx, min_bz, max_bx, max_bz);"
    "CREATE INDEX IF NOT EXISTS item_used ON item(used);";
constexpr const char* kFind =
    "SELECT id, fingerprint0, fingerprint1, min_bx, min_bz, max_bx, max_bz, used, tag, checksum, "
    "bytes FROM item"
    " WHERE kind=?1 AND level=?2 AND morton=?3 AND bx=?4 AND by=?5 AND bz=?6 ORDER BY used DESC";
constexpr const char* kKeys =
    "SELECT bx, by, bz, fingerprint0, fingerprint1, min_bx, min_bz, max_bx, max_bz FROM item "
    "INDEXED BY item_key WHERE kind=?1 AND level=?2 ORDER BY morton";
constexpr const char* kPut =
    "INSERT OR REPLACE INTO item(kind, level, morton, bx, by, bz, fingerprint0, fingerprint1, "
    "min_bx, min_bz, max_bx, max_bz, used, tag, checksum, bytes)"
    " VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16)";

std::int64_t now_s() {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
}

std::int64_t morton_of(const voxel::BoxKey& key) {
    return static_cast<std::int64_t>(voxel::morton_encode(key.bx, key.by, key.bz));
}

// Covers the whole row: bits that were corrupted on the disk must not become voxels.
std::uint64_t checksum_of(Kind kind, const voxel::BoxKey& key, const voxel::Fingerprint& print,
                          const Item& item) {
    const std::int64_t facts[] = {static_cast<int>(kind),
                                  key.level,
                                  key.bx,
                                  key.by,
                                  key.bz,
                                  static_cast<std::int64_t>(print[0]),
                                  static_cast<std::int64_t>(print[1]),
                                  item.reach.min_bx,
                                  item.reach.min_bz,
                                  item.reach.max_bx,
                                  item.reach.max_bz,
                                  static_cast<std::int64_t>(item.tag),
                                  item.bytes ? 1 : 0};
    const std::uint64_t seed = XXH3_64bits(facts, sizeof facts);
    return item.bytes ? XXH3_64bits_withSeed(item.bytes->data(), item.bytes->size(), seed) : seed;
}

voxel::InputExtent reach_at(const Statement& row, int column) {
    const auto value = [&](int i) { return static_cast<std::int32_t>(row.integer(column + i)); };
    return {value(0), value(1), value(2), value(3)};
}

voxel::Fingerprint fingerprint_at(const Statement& row, int column) {
    return {static_cast<std::uint64_t>(row.integer(column)),
            static_cast<std::uint64_t>(row.integer(column + 1))};
}

void bind_key(Statement& s, Kind kind, const voxel::BoxKey& key) {
    s.bind(1, static_cast<int>(kind))
        .bind(2, key.level)
        .bind(3, morton_of(key))
        .bind(4, key.bx)
        .bind(5, key.by)
        .bind(6, key.bz);
}

void remove_files(const fs::path& file) {
    std::error_code ignored;
    for (const char* tail : {"", "-wal", "-shm"})
        fs::remove(file.string() + tail, ignored);
}

}  // namespace

class DiskCache::Connection {
public:
    explicit Connection(const fs::path& file) : database(file.string()) {
        database.run(kPragmas);
        if (database.number(kParts) != kPartsOfAll)
            database.run(kSchema);
        find.emplace(database.get(), kFind);
        put.emplace(database.get(), kPut);
        touch.emplace(database.get(), "UPDATE item SET used=?1 WHERE id=?2");
        evict.emplace(
            database.get(),
            "DELETE FROM item WHERE id IN (SELECT id FROM item ORDER BY used, id LIMIT ?1)");
    }
    [[nodiscard]] std::uint64_t used_bytes() {
        return static_cast<std::uint64_t>(
            (database.number("PRAGMA page_count") - database.number("PRAGMA freelist_count")) *
            database.number("PRAGMA page_size"));
    }
    Database database;
    std::optional<Statement> find, put, touch, evict;
};

DiskCache::DiskCache(fs::path file, std::uint64_t limit_bytes, FingerprintOf fingerprint)
    : m_file(std::move(file)), m_limit_bytes(limit_bytes), m_fingerprint(std::move(fingerprint)) {
    std::error_code failed;
    fs::create_directories(m_file.parent_path(), failed);
    try {
        open();
    } catch (const SqliteError& e) {
        give_up(e);
        if (e.why() == SqliteError::Why::kDamaged)
            begin_anew();
    }
    if (m_broken)
        return;
    m_thread = std::thread([this] { write_on(); });
}

// Deleting the file is acceptable, since it is only a cache.
void DiskCache::begin_anew() {
    m_reader.reset();
    m_lister.reset();
    m_writer.reset();
    try {
        open();
        m_broken = false;
    } catch (const SqliteError& e) {
        spdlog::warn("{}", e.what());
    }
}

void DiskCache::open() {
    m_writer = std::make_unique<Connection>(m_file);
    m_reader = std::make_unique<Connection>(m_file);
    m_lister = std::make_unique<Connection>(m_file);
}

DiskCache::~DiskCache() {
    {
        const std::lock_guard lock(m_queueing);
        m_closing = true;
    }
    m_queued.notify_all();
    if (m_thread.joinable())
        m_thread.join();
}

std::optional<Item> DiskCache::find(Kind kind, const voxel::BoxKey& key) {
    if (m_broken)
        return std::nullopt;
    std::int64_t used_row = 0, damaged_row = 0;
    std::optional<Item> out;
    try {
        const std::lock_guard lock(m_reading);
        Statement& row = *m_reader->find;
        const Resetting reset(row);
        bind_key(row, kind, key);
        while (!out && row.step()) {
            Item item;
            item.reach = reach_at(row, 3);
            const voxel::Fingerprint print = fingerprint_at(row, 1);
            if (m_fingerprint(item.reach) != print)
                continue;
            item.tag = static_cast<std::uint64_t>(row.integer(8));
            item.bytes = row.bytes(10);
            if (checksum_of(kind, key, print, item) != static_cast<std::uint64_t>(row.integer(9))) {
                damaged_row = row.integer(0);
                continue;
            }
            if (now_s() - row.integer(7) > kTouchAfter_s)
                used_row = row.integer(0);
            out = std::move(item);
        }
    } catch (const SqliteError& e) {
        complain(e);
    }
    if (damaged_row != 0) {
        ++m_damaged;
        spdlog::warn("read {} from the cache file {}: wrong checksum; it is made again",
                     voxel::to_string(key), m_file.string());
    }
    if (used_row != 0)
        touch(used_row);
    ++(out ? m_hits : m_misses);
    return out;
}

void DiskCache::put(Kind kind, const voxel::BoxKey& key, const Item& item, WhenFull when_full) {
    const std::size_t bytes = kRowBytes + (item.bytes ? item.bytes->size() : 0);
    if (failing() || bytes > m_limit_bytes / 4)
        return;
    std::unique_lock lock(m_queueing);
    if (m_queue_bytes + bytes > kQueueBytes) {
        if (when_full == WhenFull::kDrop) {
            ++m_dropped;
            return;
        }
        m_written.wait(lock, [&] {
            return m_queue_bytes + bytes <= kQueueBytes || m_queue.empty() || m_closing;
        });
    }
    m_queue_bytes += bytes;
    m_queue.push_back({kind, key, item, 0});
    lock.unlock();
    m_queued.notify_one();
}

void DiskCache::touch(std::int64_t row) {
    const std::lock_guard lock(m_queueing);
    if (m_queue.size() > 10'000)
        return;  // the times of last use may be late, but the queue must stay short
    Write write;
    write.touched = row;
    m_queue.push_back(std::move(write));
    m_queued.notify_one();
}

void DiskCache::flush() {
    std::unique_lock lock(m_queueing);
    m_written.wait(lock, [&] { return (m_queue.empty() && !m_busy) || !m_thread.joinable(); });
}

void DiskCache::write_on() {
    try {
        count_now_and_then();
    } catch (const SqliteError& e) {
        complain(e);
    }
    for (;;) {
        std::vector<Write> writes;
        {
            std::unique_lock lock(m_queueing);
            m_busy = false;
            m_written.notify_all();
            // Wakes up periodically also without work, to update the counts after a burst.
            const bool work =
                m_queued.wait_for(lock, kIdle, [&] { return !m_queue.empty() || m_closing; });
            if (work && m_queue.empty())
                return;
            writes.assign(std::make_move_iterator(m_queue.begin()),
                          std::make_move_iterator(m_queue.end()));
            m_queue.clear();
            m_queue_bytes = 0;
            m_busy = true;
        }
        if (failing())
            continue;
        try {
            if (!writes.empty()) {
                m_writes += write_all(writes);
                ++m_changes;
                evict();
            }
            count_now_and_then();
        } catch (const SqliteError& e) {
            m_dropped += writes.size();
            if (e.why() == SqliteError::Why::kOther)
                stop_writing(e);
            else
                complain(e);
        } catch (const std::exception& e) {
            m_dropped += writes.size();
            stop_writing(e);
        }
    }
}

// For example on a full disk: the stored items stay valid.
void DiskCache::stop_writing(const std::exception& e) {
    if (!m_read_only.exchange(true))
        spdlog::warn("{}; further boxes are kept in memory only", e.what());
}

// Counting reads a whole index.
void DiskCache::count_now_and_then() {
    constexpr auto kEach = std::chrono::seconds(5);
    if (const auto now = std::chrono::steady_clock::now();
        m_counted == std::chrono::steady_clock::time_point{} || now - m_counted > kEach) {
        m_entries = static_cast<std::uint64_t>(
            m_writer->database.number("SELECT count(*) FROM item INDEXED BY item_used"));
        m_counted = now;
    }
}

std::size_t DiskCache::write_all(const std::vector<Write>& writes) {
    std::size_t count = 0;
    m_writer->database.run("BEGIN IMMEDIATE");
    try {
        for (const Write& w : writes) {
            if (w.touched != 0) {
                m_writer->touch->bind(1, now_s()).bind(2, w.touched);
                m_writer->touch->run();
                continue;
            }
            const voxel::Fingerprint print = m_fingerprint(w.item.reach);
            Statement& put = *m_writer->put;
            const Resetting reset(put);
            bind_key(put, w.kind, w.key);
            put.bind(7, static_cast<std::int64_t>(print[0]))
                .bind(8, static_cast<std::int64_t>(print[1]));
            put.bind(9, w.item.reach.min_bx)
                .bind(10, w.item.reach.min_bz)
                .bind(11, w.item.reach.max_bx)
                .bind(12, w.item.reach.max_bz);
            put.bind(13, now_s()).bind(14, static_cast<std::int64_t>(w.item.tag));
            put.bind(15, static_cast<std::int64_t>(checksum_of(w.kind, w.key, print, w.item)))
                .bind_bytes(16, w.item.bytes.get());
            put.step();
            ++count;
        }
        m_writer->database.run("COMMIT");
    } catch (...) {
        sqlite3_exec(m_writer->database.get(), "ROLLBACK", nullptr, nullptr, nullptr);
        throw;
    }
    return count;
}

void DiskCache::evict() {
    while (m_writer->used_bytes() > m_limit_bytes) {
        m_writer->evict->bind(1, kEvictRows);
        m_writer->evict->run();
        const int gone = sqlite3_changes(m_writer->database.get());
        if (gone == 0)
            break;
        m_evictions += static_cast<std::uint64_t>(gone);
    }
    // Freed pages are reused; they are returned to the file system only when the file has exceeded
    // its limit.
    if (static_cast<std::uint64_t>(m_writer->database.number("PRAGMA page_count") *
                                   m_writer->database.number("PRAGMA page_size")) > m_limit_bytes)
        m_writer->database.run("PRAGMA incremental_vacuum");
}

DiskStats DiskCache::stats() {
    DiskStats out;
    out.hits = m_hits;
    out.misses = m_misses;
    out.writes = m_writes;
    out.evictions = m_evictions;
    out.dropped = m_dropped;
    out.damaged = m_damaged;
    if (m_broken)
        return out;
    try {
        const std::lock_guard lock(m_listing);
        out.bytes = m_lister->used_bytes();
        out.entries = m_entries;
    } catch (const SqliteError& e) {
        complain(e);
    }
    return out;
}

std::vector<voxel::BoxKey> DiskCache::keys(Kind kind, int level, std::size_t most) {
    std::vector<voxel::BoxKey> out;
    if (m_broken)
        return out;
    try {
        const std::lock_guard lock(m_listing);
        Statement row(m_lister->database.get(), kKeys);
        row.bind(1, static_cast<int>(kind)).bind(2, level);
        while (out.size() < most && row.step())
            if (m_fingerprint(reach_at(row, 5)) == fingerprint_at(row, 3))
                out.push_back({level, static_cast<std::int32_t>(row.integer(0)),
                               static_cast<std::int32_t>(row.integer(1)),
                               static_cast<std::int32_t>(row.integer(2))});
    } catch (const SqliteError& e) {
        complain(e);
    }
    return out;
}

// When another process writes for long, some items are lost, but not the cache. A damaged file is
// deleted, so that the next process starts with a new one.
void DiskCache::complain(const SqliteError& e) {
    if (e.why() == SqliteError::Why::kBusy) {
        spdlog::debug("{}", e.what());
        return;
    }
    give_up(e);
}

void DiskCache::give_up(const SqliteError& e) {
    if (m_broken.exchange(true))
        return;
    if (e.why() == SqliteError::Why::kDamaged)
        remove_files(m_file);
    spdlog::warn("{}; {}", e.what(),
                 e.why() == SqliteError::Why::kDamaged ? "the cache file is removed"
                                                       : "finished boxes are kept in memory only");
}

}  // namespace terravox::boxes
