#include "voxelserver/serve/boxes/disk_cache.hpp"

#include <xxhash.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#include "common/util/log.hpp"
#include "common/voxel/box.hpp"
#include "voxelserver/serve/boxes/sqlite.hpp"

namespace terravox::boxes {

namespace fs = std::filesystem;
namespace {

// Overhead of an item in addition to its bytes, approximately.
constexpr std::size_t kRowBytes = 200;
// Resolution of the time of last use, so that a row in steady use is not written each time.
constexpr std::int64_t kTouchAfter_s = 600;
constexpr int kEvictRows = 64;  // per batch

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

std::int64_t to_morton(const voxel::BoxKey& key) {
    return static_cast<std::int64_t>(voxel::morton_encode(key.bx, key.by, key.bz));
}

// Covers the whole row: bits that were corrupted on the disk must not become voxels.
std::uint64_t compute_checksum(Kind kind, const voxel::BoxKey& key, const voxel::Fingerprint& print,
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
        .bind(3, to_morton(key))
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
        mark_used.emplace(database.get(), "UPDATE item SET used=?1 WHERE id=?2");
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
    std::optional<Statement> find;
    std::optional<Statement> put;
    std::optional<Statement> mark_used;
    std::optional<Statement> evict;
};

DiskCache::DiskCache(fs::path file, std::uint64_t limit_bytes, MakeFingerprint fingerprint)
    : m_file(std::move(file)), m_limit_bytes(limit_bytes), m_fingerprint(std::move(fingerprint)) {
    std::error_code failed;
    fs::create_directories(m_file.parent_path(), failed);
    try {
        open();
    } catch (const SqliteError& e) {
        disable(e);
        if (e.category() == SqliteError::Category::kDamaged)
            recreate();
    }
    if (m_broken)
        return;
    m_batch_writer.emplace(
        BatchWriter::Limits{}, [this] { begin_writing(); },
        [this](const std::vector<BatchWriter::Write>& writes) { write_batch(writes); });
}

// Deleting the file is acceptable, since it is only a cache.
void DiskCache::recreate() {
    m_reader.reset();
    m_lister.reset();
    m_writer.reset();
    try {
        open();
        m_broken = false;
    } catch (const SqliteError& e) {
        util::log_warn("{}", e.what());
    }
}

void DiskCache::open() {
    m_writer = std::make_unique<Connection>(m_file);
    m_reader = std::make_unique<Connection>(m_file);
    m_lister = std::make_unique<Connection>(m_file);
}

DiskCache::~DiskCache() = default;

std::optional<Item> DiskCache::find(Kind kind, const voxel::BoxKey& key) {
    if (m_broken)
        return std::nullopt;
    std::int64_t used_row = 0;
    std::int64_t damaged_row = 0;
    std::optional<Item> out;
    try {
        const std::lock_guard lock(m_reader_mutex);
        Statement& row = *m_reader->find;
        const StatementReset reset(row);
        bind_key(row, kind, key);
        while (!out && row.step()) {
            Item item;
            item.reach = reach_at(row, 3);
            const voxel::Fingerprint print = fingerprint_at(row, 1);
            if (m_fingerprint(item.reach) != print)
                continue;
            item.tag = static_cast<std::uint64_t>(row.integer(8));
            item.bytes = row.bytes(10);
            if (compute_checksum(kind, key, print, item) !=
                static_cast<std::uint64_t>(row.integer(9))) {
                damaged_row = row.integer(0);
                continue;
            }
            if (now_s() - row.integer(7) > kTouchAfter_s)
                used_row = row.integer(0);
            out = std::move(item);
        }
    } catch (const SqliteError& e) {
        warn(e);
    }
    if (damaged_row != 0) {
        ++m_counters.damaged;
        util::log_warn("read {} from the cache file {}: wrong checksum; it is made again",
                       voxel::to_string(key), m_file.string());
    }
    if (used_row != 0)
        m_batch_writer->mark_used(used_row);
    ++(out ? m_counters.hits : m_counters.misses);
    return out;
}

void DiskCache::put(Kind kind, const voxel::BoxKey& key, const Item& item, WhenFull when_full) {
    const std::size_t bytes = kRowBytes + (item.bytes ? item.bytes->size() : 0);
    if (failing() || bytes > m_limit_bytes / 4)
        return;
    if (!m_batch_writer->put({kind, key, item, 0}, bytes, when_full))
        ++m_counters.dropped;
}

void DiskCache::flush() {
    if (m_batch_writer)
        m_batch_writer->flush();
}

void DiskCache::begin_writing() {
    try {
        count_periodically();
    } catch (const SqliteError& e) {
        warn(e);
    }
}

// An empty batch, after a burst, only updates the counts.
void DiskCache::write_batch(const std::vector<BatchWriter::Write>& writes) {
    if (failing())
        return;
    try {
        if (!writes.empty()) {
            m_counters.writes += write_all(writes);
            ++m_counters.changes;
            evict();
        }
        count_periodically();
    } catch (const SqliteError& e) {
        m_counters.dropped += writes.size();
        if (e.category() == SqliteError::Category::kOther)
            stop_writing(e);
        else
            warn(e);
    } catch (const std::exception& e) {
        m_counters.dropped += writes.size();
        stop_writing(e);
    }
}

// For example on a full disk: the stored items stay valid.
void DiskCache::stop_writing(const std::exception& e) {
    if (!m_read_only.exchange(true))
        util::log_warn("{}; further boxes are kept in memory only", e.what());
}

// Counting reads a whole index.
void DiskCache::count_periodically() {
    constexpr auto kEach = std::chrono::seconds(5);
    if (const auto now = std::chrono::steady_clock::now();
        m_counted == std::chrono::steady_clock::time_point{} || now - m_counted > kEach) {
        m_counters.entries = static_cast<std::uint64_t>(
            m_writer->database.number("SELECT count(*) FROM item INDEXED BY item_used"));
        m_counted = now;
    }
}

std::size_t DiskCache::write_all(const std::vector<BatchWriter::Write>& writes) {
    std::size_t count = 0;
    m_writer->database.run("BEGIN IMMEDIATE");
    try {
        for (const BatchWriter::Write& w : writes) {
            if (w.used_row != 0) {
                m_writer->mark_used->bind(1, now_s()).bind(2, w.used_row);
                m_writer->mark_used->run();
                continue;
            }
            const voxel::Fingerprint print = m_fingerprint(w.item.reach);
            Statement& put = *m_writer->put;
            const StatementReset reset(put);
            bind_key(put, w.kind, w.key);
            put.bind(7, static_cast<std::int64_t>(print[0]))
                .bind(8, static_cast<std::int64_t>(print[1]));
            put.bind(9, w.item.reach.min_bx)
                .bind(10, w.item.reach.min_bz)
                .bind(11, w.item.reach.max_bx)
                .bind(12, w.item.reach.max_bz);
            put.bind(13, now_s()).bind(14, static_cast<std::int64_t>(w.item.tag));
            put.bind(15, static_cast<std::int64_t>(compute_checksum(w.kind, w.key, print, w.item)))
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
        m_counters.evictions += static_cast<std::uint64_t>(gone);
    }
    // Freed pages are reused; they are returned to the file system only when the file has exceeded
    // its limit.
    if (static_cast<std::uint64_t>(m_writer->database.number("PRAGMA page_count") *
                                   m_writer->database.number("PRAGMA page_size")) > m_limit_bytes)
        m_writer->database.run("PRAGMA incremental_vacuum");
}

DiskStats DiskCache::stats() {
    DiskStats out;
    out.hits = m_counters.hits;
    out.misses = m_counters.misses;
    out.writes = m_counters.writes;
    out.evictions = m_counters.evictions;
    out.dropped = m_counters.dropped;
    out.damaged = m_counters.damaged;
    if (m_broken)
        return out;
    try {
        const std::lock_guard lock(m_lister_mutex);
        out.bytes = m_lister->used_bytes();
        out.entries = m_counters.entries;
    } catch (const SqliteError& e) {
        warn(e);
    }
    return out;
}

std::vector<voxel::BoxKey> DiskCache::keys(Kind kind, int level, std::size_t max_keys) {
    std::vector<voxel::BoxKey> out;
    if (m_broken)
        return out;
    try {
        const std::lock_guard lock(m_lister_mutex);
        Statement row(m_lister->database.get(), kKeys);
        row.bind(1, static_cast<int>(kind)).bind(2, level);
        while (out.size() < max_keys && row.step())
            if (m_fingerprint(reach_at(row, 5)) == fingerprint_at(row, 3))
                out.push_back({level, static_cast<std::int32_t>(row.integer(0)),
                               static_cast<std::int32_t>(row.integer(1)),
                               static_cast<std::int32_t>(row.integer(2))});
    } catch (const SqliteError& e) {
        warn(e);
    }
    return out;
}

// When another process writes for long, some items are lost, but not the cache. A damaged file is
// deleted, so that the next process starts with a new one.
void DiskCache::warn(const SqliteError& e) {
    if (e.category() == SqliteError::Category::kBusy) {
        util::log_debug("{}", e.what());
        return;
    }
    disable(e);
}

void DiskCache::disable(const SqliteError& e) {
    if (m_broken.exchange(true))
        return;
    if (e.category() == SqliteError::Category::kDamaged)
        remove_files(m_file);
    util::log_warn("{}; {}", e.what(),
                   e.category() == SqliteError::Category::kDamaged
                       ? "the cache file is removed"
                       : "finished boxes are kept in memory only");
}

}  // namespace terravox::boxes
