#include "voxelserver/data/sqlite/untrusted_database.hpp"

#include <sqlite3.h>

#include <filesystem>
#include <string>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/sqlite/database.hpp"

using namespace terravox;

namespace {

constexpr int kMaxValue_bytes = 1000;

/// A database with one table that has one row: a text of the given length.
void make_database(const std::filesystem::path& file, int text_bytes) {
    test::Database(file).run("CREATE TABLE t (a TEXT); INSERT INTO t VALUES ('" +
                             std::string(static_cast<std::size_t>(text_bytes), 'x') +
                             "'); CREATE VIEW v AS SELECT load_extension('nothing') AS a");
}

/// @return SQLite's code of the first statement's first step
int first_step(sqlite3* database, const char* sql) {
    sqlite3_stmt* statement = nullptr;
    int code = sqlite3_prepare_v2(database, sql, -1, &statement, nullptr);
    if (code == SQLITE_OK)
        code = sqlite3_step(statement);
    sqlite3_finalize(statement);
    return code;
}

sqlite::Connection open(const std::filesystem::path& file, bool immutable = false) {
    return sqlite::open_untrusted(
        file, {.immutable = immutable, .max_value_bytes = kMaxValue_bytes}, "read the list");
}

}  // namespace

TEST_CASE("a file name's own characters never become parameters of SQLite's URI",
          "[voxelserver][sqlite]") {
    const test::TemporaryFolder folder;
    for (const char* name :
         {"plain.db", "a?mode=memory", "a#b.db", "50%3f.db", "\xc5\xbd upa.db"}) {
        const auto file = folder.path() / name;
        make_database(file, 10);
        for (const bool immutable : {false, true}) {
            CAPTURE(name, immutable);
            const sqlite::Connection database = open(file, immutable);
            CHECK(first_step(database.get(), "SELECT a FROM t") == SQLITE_ROW);
        }
    }
}

TEST_CASE("an untrusted database is read-only, and its values are limited",
          "[voxelserver][sqlite]") {
    const test::TemporaryFolder folder;
    make_database(folder.path() / "short.db", kMaxValue_bytes / 2);
    make_database(folder.path() / "long.db", kMaxValue_bytes + 1);

    const sqlite::Connection usual = open(folder.path() / "short.db");
    CHECK(first_step(usual.get(), "SELECT a FROM t") == SQLITE_ROW);
    CHECK(first_step(usual.get(), "INSERT INTO t VALUES ('b')") == SQLITE_READONLY);
    CHECK(first_step(usual.get(), "SELECT a FROM v") != SQLITE_ROW);

    const sqlite::Connection longer = open(folder.path() / "long.db");
    CHECK(first_step(longer.get(), "SELECT a FROM t") == SQLITE_TOOBIG);
}

TEST_CASE("a database that cannot be opened is an error that names the attempt",
          "[voxelserver][sqlite]") {
    const test::TemporaryFolder folder;
    CHECK_THROWS_WITH(open(folder.path() / "missing.db"),
                      "read the list: unable to open database file");
    CHECK_FALSE(std::filesystem::exists(folder.path() / "missing.db"));
}

TEST_CASE("SQLite's message is one printable line", "[voxelserver][sqlite]") {
    const test::TemporaryFolder folder;
    make_database(folder.path() / "a.db", 10);
    const sqlite::Connection database = open(folder.path() / "a.db");
    first_step(database.get(), "SELECT \"line\n\x1b[1m\" FROM t");
    first_step(database.get(), "SELECT [line\n\x1b[1m] FROM t");
    CHECK(sqlite::last_error(database.get()) == "no such column: line  [1m");
    first_step(database.get(), ("SELECT [" + std::string(500, 'n') + "] FROM t").c_str());
    CHECK(sqlite::last_error(database.get()).size() == 300);
    CHECK(sqlite::last_error(nullptr) == "out of memory");
}
