#pragma once

#include <cstdint>
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

/// A fingerprint of a file's content, computed from its size, its modification time, and its first
/// and last 64 KiB: reading all of it would cost as much as a cache hit saves. Its name and folder
/// are not included.
/// @param what the kind of file, for messages, e.g. "point cloud"
/// @throws Error when it cannot be read
[[nodiscard]] voxel::Fingerprint file_identity(const std::filesystem::path& file, const char* what);

/// Formats a fingerprint as 32 hexadecimal digits.
[[nodiscard]] std::string to_hex(const voxel::Fingerprint& print);

}  // namespace terravox::voxel
