#pragma once

#include <filesystem>
#include <memory>
#include <string>

struct sqlite3;

namespace terravox::sqlite {

struct CloseDatabase {
    void operator()(sqlite3* database) const noexcept;
};
/// A connection to an SQLite file, for one thread at a time.
using Connection = std::unique_ptr<sqlite3, CloseDatabase>;

struct UntrustedFileOptions {
    /// true: no process writes to the file; no lock is taken and no file next to it is read, so
    /// that a read-only disk suffices. What is_settled() is opened so, and is still settled when it
    /// has been read. false: the content of its write-ahead log is included, and locks of other
    /// processes are waited for for ten seconds. Neither makes a file next to it, nor changes one.
    bool immutable = false;
    int max_value_bytes = 0;  ///< limit of a value and of a row; longer ones are errors; at least 1
};

/// Whether all of a database is in its file: it has no write-ahead log, or an empty one, as any
/// program that has it open for writing in that mode fills.
[[nodiscard]] bool is_settled(const std::filesystem::path& file);

/// Opens a file that another program makes, and may be writing to, read-only, with SQLite's
/// precautions against hostile files: no function or table of the file's schema is trusted, and
/// values are limited. The cost of statements is not limited.
/// @param attempt  begins the error message: "read the map FILE"
/// @throws util::Error when SQLite cannot open it, or its log lacks the file by which it is read;
/// the content is first read by a statement
[[nodiscard]] Connection open_untrusted(const std::filesystem::path& file,
                                        const UntrustedFileOptions& options,
                                        const std::string& attempt);

/// SQLite's message for the last error, or for a connection that could not be allocated (nullptr),
/// as one line of at most 300 printable characters: it may quote the file.
[[nodiscard]] std::string last_error(sqlite3* database);

}  // namespace terravox::sqlite
