#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/util/error.hpp"

namespace terravox::minecraft {

/// The bytes are not the expected NBT.
class NbtError : public util::Error {
public:
    using util::Error::Error;
};

enum class NbtType : std::uint8_t {
    kEnd,
    kByte,
    kShort,
    kInt,
    kLong,
    kFloat,
    kDouble,
    kBytes,
    kString,
    kList,
    kCompound,
    kInts,
    kLongs
};

/// A field of a compound: its type and its name in modified UTF-8. The name lies in the reader's
/// bytes.
struct NbtField {
    NbtType type = NbtType::kEnd;
    std::string_view name;
};

/// The head of a list: the type of its elements, and their number.
struct NbtList {
    NbtType type = NbtType::kEnd;
    std::uint32_t count = 0;
};

/// An array as stored: big-endian, unaligned.
template <int kWidth>
struct NbtArray {
    const std::uint8_t* bytes = nullptr;
    std::size_t count = 0;
    [[nodiscard]] bool empty() const noexcept { return count == 0; }
    /// @param i below count
    [[nodiscard]] std::uint64_t operator[](std::size_t i) const noexcept {
        std::uint64_t value = 0;
        for (int b = 0; b < kWidth; ++b)
            value = value << 8 | bytes[i * kWidth + static_cast<std::size_t>(b)];
        return value;
    }
};
using NbtInts = NbtArray<4>;
using NbtLongs = NbtArray<8>;

/// Reads NBT (Java edition, big-endian) from front to back, without copies: the caller pulls the
/// fields that it knows and skips the others. Lengths and counts are checked against the remaining
/// bytes before they are used. Nothing here recurses: only skip() follows the data's nesting, down
/// to kMaxDepth.
/// @throws NbtError from every call where the bytes end early or are not NBT; the reader must not
/// be used after that
class NbtReader {
public:
    static constexpr int kMaxDepth = 512;  ///< as in the game

    explicit NbtReader(std::span<const std::uint8_t> bytes) noexcept
        : m_begin(bytes.data()), m_at(bytes.data()), m_end(bytes.data() + bytes.size()) {}

    /// Enters the compound that a whole file consists of; its name is skipped.
    void enter_root();
    /// The next field of the compound that is being read.
    /// @return false at its end
    [[nodiscard]] bool next(NbtField& field);

    [[nodiscard]] std::int64_t integer(NbtType type);  ///< of a byte, short, int or long
    [[nodiscard]] std::string_view string();           ///< modified UTF-8
    [[nodiscard]] std::span<const std::uint8_t> byte_array();
    [[nodiscard]] NbtInts int_array() { return array<4>(); }
    [[nodiscard]] NbtLongs long_array() { return array<8>(); }
    [[nodiscard]] NbtList list();
    void skip(NbtType type);  ///< the value of a field or an element

    /// The current position, from which another reader can read again: at(position).
    [[nodiscard]] std::size_t position() const noexcept {
        return static_cast<std::size_t>(m_at - m_begin);
    }
    [[nodiscard]] NbtReader at(std::size_t position) const noexcept;
    /// The bytes from `position` to the current position.
    [[nodiscard]] std::string_view since(std::size_t position) const noexcept;

private:
    [[noreturn]] void fail(const std::string& what) const;
    [[nodiscard]] std::size_t left() const noexcept {
        return static_cast<std::size_t>(m_end - m_at);
    }
    /// The next n bytes.
    const std::uint8_t* take(std::uint64_t n);
    std::uint64_t take_big_endian(int width);
    std::uint64_t take_count(std::uint64_t width);
    template <int kWidth>
    NbtArray<kWidth> array() {
        const std::uint64_t count = take_count(kWidth);
        return {take(count * kWidth), static_cast<std::size_t>(count)};
    }

    const std::uint8_t* m_begin;
    const std::uint8_t* m_at;
    const std::uint8_t* m_end;
};

/// Modified UTF-8 as UTF-8: NUL and surrogate pairs in their usual form; invalid sequences and
/// control characters become '?'.
[[nodiscard]] std::string to_utf8(std::string_view modified);

}  // namespace terravox::minecraft
