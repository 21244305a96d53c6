#pragma once

#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace terravox::exports {

static_assert(std::endian::native == std::endian::little,
              "all formats written here are little-endian: a big-endian port needs a swap");

/// A file that is written from front to back, and may be read again. Every failure is an Error that
/// names it. Not thread-safe.
class ByteFile {
public:
    /// Makes `path`, or empties it. @param named stands in messages
    ByteFile(const std::filesystem::path& path, std::string named);
    ByteFile(ByteFile&&) = default;
    ByteFile& operator=(ByteFile&&) =
        delete;  // it would free the buffer of a file that is still open
    /// A file without a name, beside `target`: what is spooled until its size is known. It is gone
    /// with its owner, also after a crash.
    [[nodiscard]] static ByteFile spool_for(const std::filesystem::path& target);

    void put(std::span<const std::byte> bytes);
    void put(std::string_view text) { put(std::as_bytes(std::span(text))); }
    template <class T>
    void put_value(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        put(std::as_bytes(std::span(&value, 1)));
    }
    [[nodiscard]] std::uint64_t bytes() const noexcept { return m_bytes; }  ///< written so far

    /// Reads what was written. Ends the writing.
    void read(std::uint64_t offset, std::span<std::byte> out);
    /// Appends all of this to `to`. Ends the writing.
    void copy_to(ByteFile& to);
    void close();  ///< all bytes are with the system

private:
    struct Close {
        void operator()(std::FILE* f) const noexcept { std::fclose(f); }
    };
    ByteFile(std::FILE* file, std::string named);
    [[noreturn]] void fail() const;
    std::string m_named;
    std::vector<char> m_buffer;  // outlives m_file
    std::unique_ptr<std::FILE, Close> m_file;
    std::uint64_t m_bytes = 0;
};

}  // namespace terravox::exports
