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

/// A file that is written from front to back, and may be read back. Every failure is an Error that
/// names it. Not thread-safe.
class ByteFile {
public:
    /// Creates `path`, or truncates it.
    /// @param named the name in messages
    ByteFile(const std::filesystem::path& path, std::string named);
    ByteFile(ByteFile&&) = default;
    // Deleted: it would free the buffer of a file that is still open.
    ByteFile& operator=(ByteFile&&) = delete;
    /// An unnamed file in the folder of `target`, for data that is spooled until its size is known.
    /// It vanishes with its owner, also after a crash.
    [[nodiscard]] static ByteFile spool_for(const std::filesystem::path& target);

    void put(std::span<const std::byte> bytes);
    void put(std::string_view text) { put(std::as_bytes(std::span(text))); }
    template <class T>
    void put_value(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        put(std::as_bytes(std::span(&value, 1)));
    }
    [[nodiscard]] std::uint64_t bytes() const noexcept { return m_bytes; }  ///< written so far

    /// Reads back what was written. Nothing may be written after it.
    void read(std::uint64_t offset, std::span<std::byte> out);
    /// Appends all of this to `to`. Nothing may be written after it.
    void copy_to(ByteFile& to);
    void close();  ///< passes all bytes to the operating system

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
