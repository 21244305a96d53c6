#include "voxelserver/make/worlds/luanti/map_database.hpp"

#include <map>
#include <string>
#include <system_error>

#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::luanti {
namespace {

constexpr int kMaxValue_bytes = 16 << 20;  // and row: the largest blocks have some hundred KiB

// Encoded places: z * 2^24 + y * 2^12 + x, each in [-2048, 2048).
constexpr std::int64_t kEncodedOrigin = 0x800800800;
constexpr std::int64_t kEncodedEnd = std::int64_t{1} << 36;

std::int64_t encoded(const BlockPlace& place) noexcept {
    return std::int64_t{mirrored(place.z)} * (1 << 24) + std::int64_t{place.y} * (1 << 12) +
           place.x;
}

std::optional<BlockPlace> decoded(std::int64_t number) noexcept {
    if (number < -kEncodedOrigin || number >= kEncodedEnd - kEncodedOrigin)
        return std::nullopt;
    const std::int64_t bits = number + kEncodedOrigin;
    const auto part = [&](int shift) {
        return static_cast<std::int32_t>(bits >> shift & 0xFFF) - kFarthestBlock;
    };
    return BlockPlace{part(0), part(12), mirrored(part(24))};
}

/// The place that the key of a row stands for.
std::optional<BlockPlace> find_place(const sqlite::Statement& row, bool is_encoded) noexcept {
    const auto first = row.integer(0);
    if (!first)
        return std::nullopt;
    if (is_encoded)
        return decoded(*first);
    const auto y = row.integer(1);
    const auto z = row.integer(2);
    if (!y || !z || !within_world(*first, *y, *z))
        return std::nullopt;
    return BlockPlace{static_cast<std::int32_t>(*first), static_cast<std::int32_t>(*y),
                      mirrored(static_cast<std::int32_t>(*z))};
}

/// Whether the file is a database whose changes go into a write-ahead log first, as its head says.
bool is_in_wal_mode(const std::filesystem::path& file) {
    constexpr std::size_t kReadVersionAt = 19;
    constexpr char kWal = 2;
    const std::string head = util::read_start(file, kReadVersionAt + 1);
    return head.size() > kReadVersionAt && head[kReadVersionAt] == kWal;
}

}  // namespace

MapDatabase::MapDatabase(const std::filesystem::path& file)
    : m_file(file), m_attempt("read the map " + file.string()) {
    open();
}

// In WAL mode a reader needs files next to the map, which SQLite would make. A map that its server
// has closed is read without them: nothing says then when it is opened again, so that its state is
// compared after each reading.
void MapDatabase::open() {
    m_select.reset();
    m_settled.reset();
    if (const FileState now = state(); now.is_settled && is_in_wal_mode(m_file))
        m_settled = now;
    m_database = sqlite::open_untrusted(
        m_file, {.immutable = m_settled.has_value(), .max_value_bytes = kMaxValue_bytes},
        m_attempt);
    find_schema();
}

MapDatabase::FileState MapDatabase::state() const {
    std::error_code ignored;
    FileState out;
    out.bytes = std::filesystem::file_size(m_file, ignored);
    out.changed = std::filesystem::last_write_time(m_file, ignored);
    out.is_settled = sqlite::is_settled(m_file);
    return out;
}

bool MapDatabase::has_changed() const {
    return m_settled && state() != *m_settled;
}

void MapDatabase::fail() const {
    throw util::Error(m_attempt + ": " + sqlite::last_error(m_database.get()));
}

sqlite::Statement MapDatabase::prepare(const char* sql) {
    return sqlite::Statement(m_database.get(), sql, [this] { fail(); });
}

// Only a plain table with a primary key is accepted: a view or virtual table could be endless, and
// without a key each block would cost a scan of the file. Generated columns are not listed.
void MapDatabase::find_schema() {
    sqlite::Statement tables = prepare(
        "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = 'blocks'"
        " AND sql NOT LIKE 'CREATE VIRTUAL%'");
    std::map<std::string, bool> is_key_of_column;
    if (tables.step()) {
        sqlite::Statement columns = prepare("PRAGMA table_info(blocks)");
        while (columns.step())
            is_key_of_column[columns.text(1).value_or("")] = columns.to_integer(5) > 0;
    }
    const auto is_key = [&](const char* column) {
        const auto found = is_key_of_column.find(column);
        return found != is_key_of_column.end() && found->second;
    };
    m_encoded = is_key("pos");
    if (!is_key_of_column.contains("data") ||
        !(m_encoded || (is_key("x") && is_key("y") && is_key("z"))))
        throw util::Error(
            m_attempt +
            ": no blocks of a known form; allowed: a table 'blocks' with data and the "
            "primary key pos, or x, y, z");
    m_select = std::make_unique<sqlite::Statement>(
        prepare(m_encoded ? "SELECT data FROM blocks WHERE pos = ?1"
                          : "SELECT data FROM blocks WHERE x = ?1 AND y = ?2 AND z = ?3"));
}

std::uint64_t MapDatabase::for_each_place(const std::function<void(const BlockPlace&)>& visit) {
    const std::lock_guard lock(m_mutex);
    if (has_changed())
        open();
    sqlite::Statement keys =
        prepare(m_encoded ? "SELECT pos FROM blocks" : "SELECT x, y, z FROM blocks");
    std::uint64_t misplaced = 0;
    while (keys.step()) {
        if (const auto place = find_place(keys, m_encoded))
            visit(*place);
        else
            ++misplaced;
    }
    if (has_changed())
        throw util::Error(m_attempt + ": its server has opened it meanwhile; allowed: once more");
    return misplaced;
}

std::vector<std::uint8_t> MapDatabase::read(const BlockPlace& place) {
    const std::lock_guard lock(m_mutex);
    constexpr int kTries = 3;
    for (int i = 0; i < kTries; ++i) {
        if (has_changed())
            open();
        try {
            std::vector<std::uint8_t> out = read_now(place);
            if (!has_changed())
                return out;
        } catch (const util::Error&) {
            if (!has_changed())
                throw;
        }
    }
    throw util::Error("the server of the map opens and closes it again and again");
}

std::vector<std::uint8_t> MapDatabase::read_now(const BlockPlace& place) {
    const sqlite::StatementReset resetting(*m_select);
    if (m_encoded)
        m_select->bind(0, encoded(place));
    else
        m_select->bind(0, place.x).bind(1, place.y).bind(2, mirrored(place.z));
    if (!m_select->step())
        return {};
    const auto bytes = m_select->bytes(0);
    if (!bytes || bytes->empty())
        throw util::Error("no bytes are stored");
    return {bytes->begin(), bytes->end()};
}

}  // namespace terravox::luanti
