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
    /// true: no process writes to the file; no lock is taken and no file next to it is read or
    /// created, so that a read-only disk suffices. false: the content of its write-ahead log is
    /// included, and locks of other processes are waited for for ten seconds.
    bool immutable = false;
    int max_value_bytes = 0;  ///< limit of a value and of a row; longer ones are errors; at least 1
};

/// Opens a file that another program makes, and may be writing to, read-only, with SQLite's
/// precautions against hostile files: no function or table of the file's schema is trusted, and
/// values are limited. The cost of statements is not limited.
/// @param attempt  begins the error message: "read the map FILE"
/// @throws util::Error when SQLite cannot open it; the content is first read by a statement
[[nodiscard]] Connection open_untrusted(const std::filesystem::path& file,
                                        const UntrustedFileOptions& options,
                                        const std::string& attempt);

/// SQLite's message for the last error, or for a connection that could not be allocated (nullptr),
/// as one line of at most 300 printable characters: it may quote the file.
[[nodiscard]] std::string last_error(sqlite3* database);

}  // namespace terravox::sqlite
