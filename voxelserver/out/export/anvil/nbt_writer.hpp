#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace terravox::exports::anvil {

enum class NbtTag : std::uint8_t {
    kEnd = 0,
    kByte = 1,
    kInt = 3,
    kLong = 4,
    kFloat = 5,
    kDouble = 6,
    kString = 8,
    kList = 9,
    kCompound = 10,
    kLongArray = 12
};

/// Writes NBT, the tree of named values in Minecraft's files: big-endian, uncompressed. Every
/// compound that is begun must be ended. A list starts with the number of its elements; the
/// elements are written without names: value_...().
class NbtWriter {
public:
    /// Begins a compound; the root is one without a name.
    void begin(std::string_view name) { tag(NbtTag::kCompound, name); }
    void end() { m_out += '\0'; }  ///< of a compound, also of one in a list
    void list(std::string_view name, NbtTag of, std::int32_t count);
    void put_byte(std::string_view name, std::int8_t value);
    void put_int(std::string_view name, std::int32_t value);
    void put_long(std::string_view name, std::int64_t value);
    void put_float(std::string_view name, float value);
    void put_double(std::string_view name, double value);
    void put_string(std::string_view name, std::string_view value);
    void put_longs(std::string_view name, std::span<const std::uint64_t> values);
    void value_string(std::string_view value);
    void raw(std::string_view bytes) { m_out += bytes; }  ///< finished tags

    [[nodiscard]] const std::string& bytes() const noexcept { return m_out; }
    void clear() noexcept { m_out.clear(); }

private:
    void tag(NbtTag tag, std::string_view name);
    template <class Number>
    void big_endian(Number value);
    std::string m_out;
};

/// UTF-8 as Java writes it: code points beyond U+FFFF as two halves, NUL as two bytes, invalid
/// UTF-8 as '?'. At most 65,535 bytes: the rest is cut off.
[[nodiscard]] std::string java_utf8(std::string_view text);

}  // namespace terravox::exports::anvil
