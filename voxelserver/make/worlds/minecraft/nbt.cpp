#include "voxelserver/make/worlds/minecraft/nbt.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include "common/util/utf8.hpp"

namespace terravox::minecraft {
namespace {

// Minimum bytes of a value of a type; 0 = its size is not fixed.
std::uint64_t fixed_size(NbtType type) noexcept {
    switch (type) {
        case NbtType::kByte: return 1;
        case NbtType::kShort: return 2;
        case NbtType::kInt:
        case NbtType::kFloat: return 4;
        case NbtType::kLong:
        case NbtType::kDouble: return 8;
        default: return 0;
    }
}

std::string to_number(NbtType type) {
    return std::to_string(static_cast<int>(type));
}

}  // namespace

void NbtReader::fail(const std::string& what) const {
    throw NbtError("NBT, byte " + std::to_string(position()) + ": " + what);
}

const std::uint8_t* NbtReader::take(std::uint64_t n) {
    if (n > left())
        fail(std::to_string(n) + " bytes wanted, " + std::to_string(left()) + " left");
    const std::uint8_t* const at = m_at;
    m_at += n;
    return at;
}

std::uint64_t NbtReader::take_big_endian(int width) {
    const std::uint8_t* bytes = take(static_cast<std::uint64_t>(width));
    std::uint64_t value = 0;
    for (int i = 0; i < width; ++i)
        value = value << 8 | bytes[i];
    return value;
}

std::uint64_t NbtReader::take_count(std::uint64_t width) {
    const auto count = static_cast<std::int32_t>(take_big_endian(4));
    if (count < 0)
        fail("a length of " + std::to_string(count));
    if (static_cast<std::uint64_t>(count) * width > left())
        fail("a length of " + std::to_string(count) + ", " + std::to_string(left()) +
             " bytes left");
    return static_cast<std::uint64_t>(count);
}

void NbtReader::enter_root() {
    const std::uint64_t type = take_big_endian(1);
    if (type != static_cast<std::uint64_t>(NbtType::kCompound))
        fail("a file of type " + std::to_string(type) + "; allowed: 10, a compound");
    take(take_big_endian(2));
}

bool NbtReader::next(NbtField& field) {
    const std::uint64_t type = take_big_endian(1);
    if (type > static_cast<std::uint64_t>(NbtType::kLongs))
        fail("type " + std::to_string(type) + "; allowed: 0 to 12");
    field.type = static_cast<NbtType>(type);
    if (field.type == NbtType::kEnd)
        return false;
    field.name = string();
    return true;
}

std::int64_t NbtReader::integer(NbtType type) {
    switch (type) {
        case NbtType::kByte: return static_cast<std::int8_t>(take_big_endian(1));
        case NbtType::kShort: return static_cast<std::int16_t>(take_big_endian(2));
        case NbtType::kInt: return static_cast<std::int32_t>(take_big_endian(4));
        case NbtType::kLong: return static_cast<std::int64_t>(take_big_endian(8));
        default: fail("type " + to_number(type) + " where a whole number belongs");
    }
}

std::string_view NbtReader::string() {
    const std::uint64_t size = take_big_endian(2);
    return {reinterpret_cast<const char*>(take(size)), static_cast<std::size_t>(size)};
}

std::span<const std::uint8_t> NbtReader::byte_array() {
    const std::uint64_t count = take_count(1);
    return {take(count), static_cast<std::size_t>(count)};
}

NbtList NbtReader::list() {
    const std::uint64_t type = take_big_endian(1);
    if (type > static_cast<std::uint64_t>(NbtType::kLongs))
        fail("a list of type " + std::to_string(type) + "; allowed: 0 to 12");
    NbtList out{static_cast<NbtType>(type), 0};
    const auto count = static_cast<std::int32_t>(take_big_endian(4));
    if (count <= 0)
        return out;  // as the game: an empty list
    if (out.type == NbtType::kEnd)
        fail("a list of " + std::to_string(count) + " elements without a type");
    // Each element takes at least a byte, so that a count never causes more work than there are
    // bytes.
    const std::uint64_t least = std::max<std::uint64_t>(fixed_size(out.type), 1);
    if (static_cast<std::uint64_t>(count) * least > left())
        fail("a list of " + std::to_string(count) + " elements, " + std::to_string(left()) +
             " bytes left");
    out.count = static_cast<std::uint32_t>(count);
    return out;
}

// Open values (compounds, and lists of elements without fixed size) are on a stack of its own.
void NbtReader::skip(NbtType type) {
    struct Open {
        NbtType type;
        std::uint32_t left;
    };  // of a list: the type of its elements, and how many are left
    // Marks an open compound: the type of no list.
    constexpr auto kCompound = static_cast<NbtType>(0xFF);
    std::array<Open, kMaxDepth> open;
    int depth = 0;
    for (;;) {
        if (const std::uint64_t size = fixed_size(type); size != 0) {
            take(size);
        } else if (type == NbtType::kString) {
            static_cast<void>(string());
        } else if (type == NbtType::kBytes) {
            static_cast<void>(byte_array());
        } else if (type == NbtType::kInts) {
            static_cast<void>(int_array());
        } else if (type == NbtType::kLongs) {
            static_cast<void>(long_array());
        } else {
            if (depth == kMaxDepth)
                fail("nested deeper than " + std::to_string(kMaxDepth));
            Open opened{kCompound, 0};
            if (type == NbtType::kList) {
                const NbtList head = list();
                opened = {head.type, head.count};
                if (const std::uint64_t each = fixed_size(head.type); each != 0) {
                    take(each * head.count);
                    opened.left = 0;
                }
            } else if (type != NbtType::kCompound) {
                fail("type " + to_number(type));
            }
            open[static_cast<std::size_t>(depth++)] = opened;
        }
        for (;;) {  // to the next value within the open ones
            if (depth == 0)
                return;
            Open& top = open[static_cast<std::size_t>(depth - 1)];
            if (top.type == kCompound) {
                NbtField field;
                if (next(field)) {
                    type = field.type;
                    break;
                }
            } else if (top.left > 0) {
                --top.left;
                type = top.type;
                break;
            }
            --depth;
        }
    }
}

NbtReader NbtReader::at(std::size_t position) const noexcept {
    NbtReader out(*this);
    out.m_at = m_begin + position;
    return out;
}

std::string_view NbtReader::since(std::size_t position) const noexcept {
    return {reinterpret_cast<const char*>(m_begin) + position, this->position() - position};
}

namespace {

// The code unit at `i`, which is advanced past it. nullopt: none.
std::optional<std::uint32_t> code_unit(std::string_view text, std::size_t& i) noexcept {
    const auto byte = [&](std::size_t at) {
        return static_cast<std::uint32_t>(static_cast<unsigned char>(text[at]));
    };
    const auto follows = [&](std::size_t at) {
        return at < text.size() && (byte(at) & 0xC0) == 0x80;
    };
    const std::uint32_t first = byte(i++);
    if (first < 0x80)
        return first;
    if ((first & 0xE0) == 0xC0 && follows(i))
        return (first & 0x1F) << 6 | (byte(i++) & 0x3F);
    if ((first & 0xF0) == 0xE0 && follows(i) && follows(i + 1)) {
        i += 2;
        return (first & 0x0F) << 12 | (byte(i - 2) & 0x3F) << 6 | (byte(i - 1) & 0x3F);
    }
    return std::nullopt;
}

}  // namespace

std::string to_utf8(std::string_view modified) {
    std::string out;
    out.reserve(modified.size());
    for (std::size_t i = 0; i < modified.size();) {
        std::uint32_t c = code_unit(modified, i).value_or('?');
        if (c >= 0xD800 && c < 0xDC00 && i < modified.size()) {
            std::size_t after = i;
            const std::uint32_t low = code_unit(modified, after).value_or(0);
            if (low >= 0xDC00 && low < 0xE000) {
                c = 0x10000 + ((c & 0x3FF) << 10 | (low & 0x3FF));
                i = after;
            }
        }
        util::append_utf8(out, c < 0x20 || c == 0x7F || (c >= 0xD800 && c < 0xE000) ? '?' : c);
    }
    return out;
}

}  // namespace terravox::minecraft
