#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/util/error.hpp"

namespace terravox::minecraft {

/// Bytes are not the NBT that they should be.
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

/// The head of a list: what its elements are, and how many.
struct NbtList {
    NbtType type = NbtType::kEnd;
    std::uint32_t count = 0;
};

/// An array as it lies in the bytes: big-endian, unaligned.
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
/// fields that it knows and skips the others. What is claimed (lengths, counts) is checked against
/// the bytes that are left before anything is done with it. Nothing here recurses: only skip()
/// follows the data's nesting, down to kMaxDepth. Every call @throws NbtError where the bytes end
/// early or are no NBT; then the reader is of no more use.
class NbtReader {
public:
    static constexpr int kMaxDepth = 512;  ///< as in the game

    explicit NbtReader(std::span<const std::uint8_t> bytes) noexcept
        : m_begin(bytes.data()), m_at(bytes.data()), m_end(bytes.data() + bytes.size()) {}

    /// Enters the compound that a whole file is; its name is passed over.
    void enter_root();
    /// The next field of the compound that is being read. @return false at its end
    [[nodiscard]] bool next(NbtField& field);

    [[nodiscard]] std::int64_t integer(NbtType type);  ///< of a byte, short, int or long
    [[nodiscard]] double number(NbtType type);         ///< of the same, float and double
    [[nodiscard]] std::string_view string();           ///< modified UTF-8
    [[nodiscard]] std::span<const std::uint8_t> byte_array();
    [[nodiscard]] NbtInts int_array() { return array<4>(); }
    [[nodiscard]] NbtLongs long_array() { return array<8>(); }
    [[nodiscard]] NbtList list();
    void skip(NbtType type);  ///< the value of a field or an element

    /// Where the reader stands, to be read again by another one: at(position).
    [[nodiscard]] std::size_t position() const noexcept {
        return static_cast<std::size_t>(m_at - m_begin);
    }
    [[nodiscard]] NbtReader at(std::size_t position) const noexcept;
    /// The bytes from `position` to where the reader stands.
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

/// Modified UTF-8 as UTF-8: NUL and surrogate pairs in their usual form; what is no text becomes
/// '?', control characters too.
[[nodiscard]] std::string utf8_of(std::string_view modified);

}  // namespace terravox::minecraft
