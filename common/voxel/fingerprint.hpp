#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// XXH3 hash, 128 bits.
[[nodiscard]] voxel::Fingerprint to_fingerprint(std::string_view bytes) noexcept;

/// Serialises values to consecutive bytes (little-endian, as on every supported machine), for
/// storage or hashing. Strings and lists are preceded by their length, so that different sequences
/// of values never give the same bytes.
class ByteWriter {
public:
    template <class T>
    void add(const T& value) {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>,
                      "structures have padding: member by member");
        m_bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void add(std::string_view text) {
        add(static_cast<std::uint64_t>(text.size()));
        m_bytes.append(text);
    }
    void add(const std::string& text) { add(std::string_view(text)); }
    void add(const voxel::Fingerprint& print) {
        add(print[0]);
        add(print[1]);
    }
    template <class T>
    void add_all(const std::vector<T>& values) {
        add(static_cast<std::uint64_t>(values.size()));
        for (const T& v : values)
            add(v);
    }
    [[nodiscard]] const std::string& bytes() const noexcept { return m_bytes; }
    /// The hash of the bytes added so far.
    [[nodiscard]] voxel::Fingerprint fingerprint() const noexcept {
        return to_fingerprint(m_bytes);
    }

private:
    std::string m_bytes;
};

/// Reads values written by ByteWriter from untrusted bytes: after the first missing value, all
/// further reads return 0 or empty, and ok() returns false.
class ByteReader {
public:
    explicit ByteReader(std::string_view bytes) : m_left(bytes) {}
    template <class T>
    [[nodiscard]] T get() {
        static_assert(std::is_arithmetic_v<T>);
        T out{};
        if (const auto part = take(sizeof out); !part.empty())
            std::memcpy(&out, part.data(), sizeof out);
        return out;
    }
    [[nodiscard]] std::string text() { return std::string(take(get<std::uint64_t>())); }
    [[nodiscard]] voxel::Fingerprint fingerprint() {
        const auto a = get<std::uint64_t>();
        const auto b = get<std::uint64_t>();
        return {a, b};
    }
    /// Reads the length of a list.
    /// @param min_bytes minimum size of each element in bytes: a list longer than the remaining
    /// bytes allow is invalid
    [[nodiscard]] std::size_t count(std::size_t min_bytes) {
        const auto n = get<std::uint64_t>();
        if (n > m_left.size() / min_bytes)
            m_ok = false;
        return m_ok ? static_cast<std::size_t>(n) : 0;
    }
    /// Whether all reads so far have succeeded.
    [[nodiscard]] bool ok() const noexcept { return m_ok; }
    /// Whether all reads have succeeded and no bytes are left.
    [[nodiscard]] bool finished() const noexcept { return m_ok && m_left.empty(); }

private:
    [[nodiscard]] std::string_view take(std::uint64_t size) {
        if (!m_ok || size > m_left.size()) {
            m_ok = false;
            return {};
        }
        const auto out = m_left.substr(0, static_cast<std::size_t>(size));
        m_left.remove_prefix(out.size());
        return out;
    }
    std::string_view m_left;
    bool m_ok = true;
};

/// A fingerprint of a file's content, computed from its size, its modification time, and its first
/// and last 64 KiB: reading all of it would cost as much as a cache hit saves. Its name and folder
/// are not included.
/// @param what the kind of file, for messages, e.g. "point cloud"
/// @throws Error when it cannot be read
[[nodiscard]] voxel::Fingerprint file_identity(const std::filesystem::path& file, const char* what);

/// Formats a fingerprint as 32 hexadecimal digits.
[[nodiscard]] std::string to_hex(const voxel::Fingerprint& print);

}  // namespace terravox::voxel
