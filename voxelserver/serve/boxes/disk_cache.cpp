#include "voxelserver/serve/boxes/disk_cache.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <chrono>

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

/// Numbers of columns in the results of statements, and of the parameters that become columns: in
/// the order of kIndexedColumns, kOtherColumns and id.
struct Column {
    enum : int {
        kKind,
        kLevel,
        kMorton,
        kBx,
        kBy,
        kBz,
        kFingerprint0,
        kFingerprint1,
        kMinBx,
        kMinBz,
        kMaxBx,
        kMaxBz,
        kUsed,
        kTag,
        kChecksum,
        kBytes,
        kId
    };
};
// What is read of these alone is read of the index.
constexpr std::string_view kIndexedColumns =
    "kind, level, morton, bx, by, bz, fingerprint0, fingerprint1, min_bx, min_bz, max_bx, max_bz";
constexpr std::string_view kOtherColumns = "used, tag, checksum, bytes";

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

std::int32_t read_int32(const Statement& row, int column) {
    return static_cast<std::int32_t>(row.to_integer(column));
}

voxel::InputExtent read_reach(const Statement& row) {
    return {read_int32(row, Column::kMinBx), read_int32(row, Column::kMinBz),
            read_int32(row, Column::kMaxBx), read_int32(row, Column::kMaxBz)};
}

voxel::Fingerprint read_fingerprint(const Statement& row) {
    return {static_cast<std::uint64_t>(row.to_integer(Column::kFingerprint0)),
            static_cast<std::uint64_t>(row.to_integer(Column::kFingerprint1))};
}

void bind_key(Statement& s, Kind kind, const voxel::BoxKey& key) {
    s.bind(Column::kKind, static_cast<int>(kind))
        .bind(Column::kLevel, key.level)
        .bind(Column::kMorton, to_morton(key))
        .bind(Column::kBx, key.bx)
        .bind(Column::kBy, key.by)
        .bind(Column::kBz, key.bz);
}

void bind_item(Statement& s, const voxel::Fingerprint& print, const Item& item,
               std::uint64_t checksum) {
    s.bind(Column::kFingerprint0, static_cast<std::int64_t>(print[0]))
        .bind(Column::kFingerprint1, static_cast<std::int64_t>(print[1]))
        .bind(Column::kMinBx, item.reach.min_bx)
        .bind(Column::kMinBz, item.reach.min_bz)
        .bind(Column::kMaxBx, item.reach.max_bx)
        .bind(Column::kMaxBz, item.reach.max_bz)
        .bind(Column::kUsed, now_s())
        .bind(Column::kTag, static_cast<std::int64_t>(item.tag))
        .bind(Column::kChecksum, static_cast<std::int64_t>(checksum))
        .bind_bytes(Column::kBytes, item.bytes.get());
}

void remove_files(const fs::path& file) {
    std::error_code ignored;
    for (const char* tail : {"", "-wal", "-shm"})
        fs::remove(file.string() + tail, ignored);
}

/// A connection to a file that has the schema.
class CacheDatabase : public Database {
public:
    explicit CacheDatabase(const fs::path& file) : Database(file.string()) {
        run(kPragmas);
        if (number(kParts) != kPartsOfAll)
            run(kSchema);
    }
};

}  // namespace

class DiskCache::Connection {
public:
    explicit Connection(const fs::path& file) : database(file) {}
    [[nodiscard]] std::uint64_t used_bytes() {
        return static_cast<std::uint64_t>(
            (database.number("PRAGMA page_count") - database.number("PRAGMA freelist_count")) *
            database.number("PRAGMA page_size"));
    }
    CacheDatabase database;
    Statement find =
        database.prepare(fmt::format("SELECT {}, {}, id FROM item WHERE kind=?1 AND level=?2 AND "
                                     "morton=?3 AND bx=?4 AND by=?5 AND bz=?6 ORDER BY used DESC",
                                     kIndexedColumns, kOtherColumns));
    Statement put = database.prepare(
        fmt::format("INSERT OR REPLACE INTO item({}, {}) VALUES(?1, ?2, ?3, ?4, ?5, "
                    "?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16)",
                    kIndexedColumns, kOtherColumns));
    Statement mark_used = database.prepare("UPDATE item SET used=?1 WHERE id=?2");
    Statement evict = database.prepare(
        "DELETE FROM item WHERE id IN (SELECT id FROM item ORDER BY used, id LIMIT ?1)");
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
    bool is_damaged = false;
    std::optional<Item> out;
    try {
        const std::lock_guard lock(m_reader_mutex);
        Statement& row = m_reader->find;
        const StatementReset reset(row);
        bind_key(row, kind, key);
        while (!out && row.step()) {
            Item item;
            item.reach = read_reach(row);
            const voxel::Fingerprint print = read_fingerprint(row);
            if (m_fingerprint(item.reach) != print)
                continue;
            item.tag = static_cast<std::uint64_t>(row.to_integer(Column::kTag));
            if (const auto bytes = row.bytes(Column::kBytes))
                item.bytes = std::make_shared<const std::string>(*bytes);
            if (compute_checksum(kind, key, print, item) !=
                static_cast<std::uint64_t>(row.to_integer(Column::kChecksum))) {
                is_damaged = true;
                continue;
            }
            if (now_s() - row.to_integer(Column::kUsed) > kTouchAfter_s)
                used_row = row.to_integer(Column::kId);
            out = std::move(item);
        }
    } catch (const SqliteError& e) {
        warn(e);
    }
    if (is_damaged) {
        count(&DiskStats::damaged);
        util::log_warn("read {} from the cache file {}: wrong checksum; it is made again",
                       voxel::to_string(key), m_file.string());
    }
    if (used_row != 0)
        m_batch_writer->mark_used(used_row);
    count(out ? &DiskStats::hits : &DiskStats::misses);
    return out;
}

void DiskCache::put(Kind kind, const voxel::BoxKey& key, const Item& item, WhenFull when_full) {
    const std::size_t bytes = kRowBytes + (item.bytes ? item.bytes->size() : 0);
    if (failing() || bytes > m_limit_bytes / 4)
        return;
    if (!m_batch_writer->put({kind, key, item, 0}, bytes, when_full))
        count(&DiskStats::dropped);
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
            count(&DiskStats::writes, write_all(writes));
            ++m_changes;
            evict();
        }
        count_periodically();
    } catch (const SqliteError& e) {
        count(&DiskStats::dropped, writes.size());
        if (e.category() == SqliteError::Category::kOther)
            stop_writing(e);
        else
            warn(e);
    } catch (const std::exception& e) {
        count(&DiskStats::dropped, writes.size());
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
        const auto entries = static_cast<std::uint64_t>(
            m_writer->database.number("SELECT count(*) FROM item INDEXED BY item_used"));
        const std::lock_guard lock(m_stats_mutex);
        m_stats.entries = entries;
        m_counted = now;
    }
}

std::size_t DiskCache::write_all(const std::vector<BatchWriter::Write>& writes) {
    std::size_t count = 0;
    m_writer->database.run("BEGIN IMMEDIATE");
    try {
        for (const BatchWriter::Write& w : writes) {
            if (w.used_row != 0) {
                m_writer->mark_used.bind(0, now_s()).bind(1, w.used_row).run();
                continue;
            }
            const voxel::Fingerprint print = m_fingerprint(w.item.reach);
            Statement& put = m_writer->put;
            const StatementReset reset(put);
            bind_key(put, w.kind, w.key);
            bind_item(put, print, w.item, compute_checksum(w.kind, w.key, print, w.item));
            (void)put.step();
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
        m_writer->evict.bind(0, kEvictRows).run();
        const int gone = sqlite3_changes(m_writer->database.get());
        if (gone == 0)
            break;
        count(&DiskStats::evictions, static_cast<std::uint64_t>(gone));
    }
    // Freed pages are reused; they are returned to the file system only when the file has exceeded
    // its limit.
    if (static_cast<std::uint64_t>(m_writer->database.number("PRAGMA page_count") *
                                   m_writer->database.number("PRAGMA page_size")) > m_limit_bytes)
        m_writer->database.run("PRAGMA incremental_vacuum");
}

void DiskCache::count(std::uint64_t DiskStats::* what, std::uint64_t many) {
    const std::lock_guard lock(m_stats_mutex);
    m_stats.*what += many;
}

DiskStats DiskCache::stats() {
    DiskStats out;
    {
        const std::lock_guard lock(m_stats_mutex);
        out = m_stats;
    }
    if (m_broken) {
        out.entries = 0;
        return out;
    }
    try {
        const std::lock_guard lock(m_lister_mutex);
        out.bytes = m_lister->used_bytes();
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
        Statement row = m_lister->database.prepare(
            fmt::format("SELECT {} FROM item INDEXED BY item_key WHERE kind=?1 AND "
                        "level=?2 ORDER BY morton",
                        kIndexedColumns));
        row.bind(Column::kKind, static_cast<int>(kind)).bind(Column::kLevel, level);
        while (out.size() < max_keys && row.step())
            if (m_fingerprint(read_reach(row)) == read_fingerprint(row))
                out.push_back({level, read_int32(row, Column::kBx), read_int32(row, Column::kBy),
                               read_int32(row, Column::kBz)});
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
