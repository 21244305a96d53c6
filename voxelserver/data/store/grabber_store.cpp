#include "voxelserver/data/store/grabber_store.hpp"

#include <sqlite3.h>
#include <algorithm>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::store {
namespace {

using Rows = sqlite::Statement;

constexpr int kMaxValue_bytes = 1'000'000;  // and row: the longest are lists of addresses
constexpr int kStepsPerCallback = 1'000'000;
constexpr int kMaxCallbacks = 2'000;

int count_down(void* callbacks_left) noexcept {
    return --*static_cast<int*>(callbacks_left) < 0 ? 1 : 0;
}

}  // namespace

ReadOnlyDatabase::ReadOnlyDatabase(const std::filesystem::path& file, bool immutable)
    : m_attempt("read the store's list " + file.string()),
      m_callbacks_left(kMaxCallbacks),
      m_database(sqlite::open_untrusted(
          file, {.immutable = immutable, .max_value_bytes = kMaxValue_bytes}, m_attempt)) {
    sqlite3_progress_handler(m_database.get(), kStepsPerCallback, count_down, &m_callbacks_left);
}

void ReadOnlyDatabase::fail() const {
    const int code = sqlite3_errcode(m_database.get()) & 0xff;
    const char* hint = code == SQLITE_NOTADB || code == SQLITE_CORRUPT
                           ? "; allowed: a sound fishnet.gpkg that the grabber made"
                           : "";
    throw util::Error(m_attempt + ": " + sqlite::last_error(m_database.get()) + hint);
}

std::optional<std::int64_t> ReadOnlyDatabase::number(const char* sql) {
    Rows rows = query(sql);
    return rows.step() ? rows.integer(0) : std::nullopt;
}

bool ReadOnlyDatabase::has_table(const char* name) {
    Rows rows = query("SELECT name, sql FROM sqlite_master WHERE type = 'table'");
    while (rows.step())
        if (rows.text(0) == name)
            return !rows.text(1).value_or("").starts_with("CREATE VIRTUAL");
    return false;
}

sqlite::Statement ReadOnlyDatabase::query(const char* sql) {
    return sqlite::Statement(m_database.get(), sql, [this] { fail(); });
}

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxRows = 1'000'000;
constexpr std::size_t kMaxSquares = 100'000;
constexpr std::size_t kLongestText = 4096;
constexpr std::int64_t kGeoPackage = 0x47504B47;  // "GPKG"

[[nodiscard]] bool plain(const std::string& text) {
    return text.size() <= kLongestText &&
           std::none_of(text.begin(), text.end(),
                        [](unsigned char c) { return c < ' ' || c == 127; });
}

/// Names become parts of paths and of web pages.
[[nodiscard]] bool is_name(const std::string& text) {
    return !text.empty() && text[0] != '.' && plain(text) &&
           text.find_first_of("/\\") == std::string::npos;
}

/// Whether a path has the form in which the grabber writes it, such as lidar/<source>/<square>.laz,
/// so that it cannot refer to another folder.
/// @param folders below the first one
[[nodiscard]] bool is_place(const std::string& path, std::string_view first, std::size_t folders,
                            std::initializer_list<std::string_view> endings) {
    if (std::none_of(endings.begin(), endings.end(),
                     [&](std::string_view ending) { return path.ends_with(ending); }))
        return false;
    std::size_t parts = 0;
    std::size_t begin = 0;
    for (std::size_t end = 0; end != std::string::npos; begin = end + 1, ++parts) {
        end = path.find('/', begin);
        const std::string part = path.substr(begin, end == std::string::npos ? end : end - begin);
        if (!is_name(part) || (parts == 0 && part != first))
            return false;
    }
    return parts == folders + 2;
}

/// The length of a regular file; nullopt when there is none.
[[nodiscard]] std::optional<std::uint64_t> find_length(const fs::path& file) {
    std::error_code failed;
    if (!fs::is_regular_file(file, failed))
        return std::nullopt;
    const std::uintmax_t size = fs::file_size(file, failed);
    return failed ? std::nullopt : std::optional<std::uint64_t>(size);
}

/// Shortens a message of a server or the system, which may be long or have several lines, to one
/// line.
[[nodiscard]] std::string one_line(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 127; }, ' ');
    if (text.size() > kLongestText) {
        std::size_t end = kLongestText;
        while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80)
            --end;  // not within a UTF-8 character
        text.resize(end);
    }
    return text;
}

/// The grabber's fishnet.gpkg: tables as grabber/migrations makes them.
class FishnetReader {
public:
    FishnetReader(fs::path folder, bool immutable)
        : m_folder(std::move(folder)),
          m_file(m_folder / "fishnet.gpkg"),
          m_database(m_file, immutable) {
        // An empty database has been created by the grabber and not yet filled.
        if (m_database.number("SELECT count(*) FROM sqlite_master") == 0)
            return;
        if (m_database.number("PRAGMA application_id") != kGeoPackage)
            fail("is no GeoPackage");
        if (!m_database.has_table("terravox_schema"))
            fail("is a GeoPackage, but no store: it has no table terravox_schema");
        const auto version = m_database.number("SELECT max(version) FROM terravox_schema");
        if (version != kGrabberSchema)
            fail("its version is " + (version ? std::to_string(*version) : "missing") +
                 "; allowed: " + std::to_string(kGrabberSchema) +
                 (version && *version < kGrabberSchema ? "; terravox grab resume brings it there"
                                                       : ""));
        for (const char* table : {"squares", "orthophotos"})
            if (!m_database.has_table(table))
                fail(std::string("has no table ") + table);
        m_filled = true;
    }

    [[nodiscard]] std::vector<StoredSquare> squares() {
        std::vector<StoredSquare> out;
        if (!m_filled)
            return out;
        Rows rows = m_database.query(
            "SELECT source, name, state, verified_at IS NOT NULL, file_path, file_bytes, "
            "point_count, error_message, "
            "crs, class_table, licence, attribution, min_x, min_y, min_z, max_x, max_y, "
            "max_z, west, south, east, north, grid_crs "
            "FROM squares WHERE state <> 'known' ORDER BY source, name, grid");
        for (std::size_t row = 0; rows.step(); ++row) {
            m_where = "squares." + std::to_string(row) + ".";
            StoredSquare square = read_square(rows);
            if (!out.empty() && out.back().source == square.source &&
                out.back().name == square.name)
                fail(m_where + "name: " + square.source + "/" + square.name + " twice");
            if (row >= kMaxSquares)
                fail("more than " + std::to_string(kMaxSquares) + " wanted squares");
            out.push_back(std::move(square));
        }
        return out;
    }

    [[nodiscard]] std::vector<StoredOrthophoto> orthophotos() {
        std::vector<StoredOrthophoto> out;
        if (!m_filled)
            return out;
        Rows rows = m_database.query(
            "SELECT file_path, file_bytes, licence, attribution FROM orthophotos "
            "WHERE verified_at IS NOT NULL ORDER BY file_path");
        for (std::size_t row = 0; rows.step(); ++row) {
            m_where = "orthophotos." + std::to_string(row) + ".";
            if (row >= kMaxRows)
                fail("more than " + std::to_string(kMaxRows) + " orthophotos");
            const std::string path = text(rows, 0, "file_path", true);
            if (!is_place(path, "ortho", 2, {".tif"}))
                fail(m_where + "file_path = '" + path +
                     "'; allowed: ortho/<source>/<grid>/<square>.tif");
            const auto length = find_length(m_folder / path);
            if (length == count(rows, 1, "file_bytes"))
                out.push_back({m_folder / path, text(rows, 2, "licence", false),
                               text(rows, 3, "attribution", false)});
            else
                util::log_warn("read the store {}: {} {}; it is left out", m_folder.string(), path,
                               length ? "has another length than it had" : "is not there any more");
        }
        return out;
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw util::Error("read the store's list {}: {}", m_file.string(), what);
    }

    /// @return empty for NULL, when `required` is not set
    [[nodiscard]] std::string text(const Rows& rows, int column, const char* name,
                                   bool required) const {
        if (rows.is_null(column)) {
            if (required)
                fail(m_where + name + " is missing");
            return {};
        }
        std::optional<std::string> out = rows.text(column);
        if (!out)
            fail(m_where + name + " is no text");
        if (!plain(*out))
            fail(m_where + name + " is no line of up to " + std::to_string(kLongestText) +
                 " characters");
        return *std::move(out);
    }

    [[nodiscard]] std::uint64_t count(const Rows& rows, int column, const char* name) const {
        const auto out = rows.integer(column);
        if (!out || *out <= 0)
            fail(m_where + name + " is no whole number above 0");
        return static_cast<std::uint64_t>(*out);
    }

    [[nodiscard]] std::string name(const Rows& rows, int column, const char* field) const {
        std::string out = text(rows, column, field, true);
        if (!is_name(out))
            fail(m_where + field + " = '" + out + "' is no name");
        return out;
    }

    /// Sets the bounds: of the file's points; for a square without a file, those in its catalogue.
    void read_bounds(const Rows& rows, StoredSquare& square) const {
        constexpr int kPoints = 12;
        constexpr int kSquare = 18;
        constexpr int kSquareCrs = 22;
        const bool points = !rows.is_null(kPoints);
        square.bounds_crs = points ? square.crs : text(rows, kSquareCrs, "grid_crs", false);
        if (!points && rows.is_null(kSquare))
            return;
        StoredBounds& out = square.bounds.emplace();
        const auto number = [&](int column) {
            const auto value = rows.number(column);
            if (!value)
                fail(m_where + (points ? "min_x to max_z" : "west to north") +
                     " are not all numbers");
            return *value;
        };
        for (int i = 0; i < (points ? 3 : 2); ++i) {
            const auto axis = static_cast<std::size_t>(i);
            out.min[axis] = number((points ? kPoints : kSquare) + i);
            out.max[axis] = number((points ? kPoints + 3 : kSquare + 2) + i);
        }
    }

    [[nodiscard]] StoredSquare read_square(const Rows& rows) const {
        StoredSquare out;
        out.source = name(rows, 0, "source");
        out.name = name(rows, 1, "name");
        const std::string state = text(rows, 2, "state", true);
        out.crs = text(rows, 8, "crs", false);
        out.class_table = text(rows, 9, "class_table", false);
        out.licence = text(rows, 10, "licence", false);
        out.attribution = text(rows, 11, "attribution", false);
        read_bounds(rows, out);
        if (!rows.is_null(7)) {
            auto said = rows.text(7);
            if (!said)
                fail(m_where + "error_message is no text");
            out.error = one_line(*std::move(said));
        }
        const bool usable = state == "verified" || state == "converted";
        if (usable)
            use_file(rows, out, StoredState::kFailed);
        else if (state == "wanted" || state == "fetching" || state == "fetched") {
            out.error.clear();
            // Requested again: until the new file is complete, the old one is used.
            if (rows.integer(3) == 1)
                use_file(rows, out, StoredState::kWanted);
        } else if (state == "missing")
            out.state = StoredState::kMissing;
        else if (state == "failed")
            out.state = StoredState::kFailed;
        else
            fail(m_where + "state = '" + state +
                 "'; allowed: known, wanted, fetching, fetched, verified, converted, missing, "
                 "failed");
        return out;
    }

    /// @param otherwise the state of the square when its file is missing or has changed
    void use_file(const Rows& rows, StoredSquare& out, StoredState otherwise) const {
        const std::string path = text(rows, 4, "file_path", true);
        if (!is_place(path, "lidar", 1, {".laz", ".las"}))
            fail(m_where + "file_path = '" + path +
                 "'; allowed: lidar/<source>/<square>.laz or .las");
        out.bytes = count(rows, 5, "file_bytes");
        out.points = count(rows, 6, "point_count");
        const auto length = find_length(m_folder / path);
        out.error.clear();
        out.state = otherwise;
        if (length == out.bytes) {
            out.state = StoredState::kFetched;
            out.file = m_folder / path;
        } else if (otherwise == StoredState::kFailed)
            out.error = !length ? path + " is not there any more; fetch it again"
                                : path + " has " + std::to_string(*length) + " bytes; it had " +
                                      std::to_string(out.bytes) + " when it was fetched";
    }

    const fs::path m_folder;
    const fs::path m_file;
    ReadOnlyDatabase m_database;
    bool m_filled = false;
    std::string m_where;  // names the row in messages
};

[[nodiscard]] GrabberStore read_fishnet(const fs::path& folder, bool immutable) {
    FishnetReader reader(folder, immutable);
    GrabberStore out;
    out.squares = reader.squares();
    out.orthophotos = reader.orthophotos();
    out.folder = folder;
    return out;
}

}  // namespace

std::vector<const StoredSquare*> GrabberStore::fetched() const {
    std::vector<const StoredSquare*> out;
    for (const StoredSquare& s : squares)
        if (s.state == StoredState::kFetched)
            out.push_back(&s);
    return out;
}

GrabberStore read_grabber_store(const fs::path& folder) {
    const auto fail = [&](const std::string& what) {
        return util::Error("read the store {}: {}", folder.string(), what);
    };
    std::error_code failed;
    if (!fs::is_directory(folder, failed))
        throw fail("no such folder; terravox grab fetch --store makes one");
    const fs::path file = folder / "fishnet.gpkg";
    if (!fs::exists(file, failed)) {
        if (fs::exists(folder / ".grabber.lock", failed))
            return {};
        throw fail("it has no fishnet.gpkg; allowed: a folder that the grabber fills");
    }
    if (!fs::is_regular_file(file, failed))
        throw fail("its fishnet.gpkg is not a plain file");
    // Without a write-ahead log everything is in the file itself, which is then opened as
    // immutable: SQLite creates no file next to it that the grabber, as another user, could not
    // write to, and a read-only disk suffices. If the grabber starts meanwhile, the store is read
    // again.
    if (sqlite::is_settled(file)) {
        try {
            GrabberStore out = read_fishnet(folder, true);
            if (sqlite::is_settled(file))
                return out;
        } catch (const util::Error&) {
            if (sqlite::is_settled(file))
                throw;
        }
    }
    return read_fishnet(folder, false);
}

const char* to_name(StoredState state) noexcept {
    switch (state) {
        case StoredState::kWanted: return "wanted";
        case StoredState::kFetched: return "fetched";
        case StoredState::kFailed: return "failed";
        case StoredState::kMissing: return "missing";
    }
    return "failed";
}

}  // namespace terravox::store
