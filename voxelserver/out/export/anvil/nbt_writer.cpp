#include "voxelserver/out/export/anvil/nbt_writer.hpp"

#include <bit>
#include <type_traits>

#include "common/util/utf8.hpp"

namespace terravox::exports::anvil {
namespace {

constexpr std::size_t kMaxString_bytes = 65'535;

void put_three(std::string& out, std::uint32_t code) {
    out += static_cast<char>(0xe0 | code >> 12);
    out += static_cast<char>(0x80 | (code >> 6 & 0x3f));
    out += static_cast<char>(0x80 | (code & 0x3f));
}

}  // namespace

std::string java_utf8(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        std::string one;
        const auto [length, code] = util::first_character(text);
        if (length == 0) {
            one = "?";
        } else if (text[0] == '\0') {
            one = "\xc0\x80";
        } else if (length == 4) {
            put_three(one, 0xd800 + ((code - 0x10000) >> 10));
            put_three(one, 0xdc00 + ((code - 0x10000) & 0x3ff));
        } else {
            one = text.substr(0, length);
        }
        if (out.size() + one.size() > kMaxString_bytes)
            break;
        out += one;
        text.remove_prefix(length == 0 ? 1 : length);
    }
    return out;
}

template <class Number>
void NbtWriter::big_endian(Number value) {
    const auto bits = static_cast<std::make_unsigned_t<Number>>(value);
    for (int shift = static_cast<int>(sizeof(Number)) * 8 - 8; shift >= 0; shift -= 8)
        m_out += static_cast<char>(bits >> shift & 0xff);
}

void NbtWriter::tag(NbtTag tag, std::string_view name) {
    m_out += static_cast<char>(tag);
    value_string(name);
}
void NbtWriter::list(std::string_view name, NbtTag of, std::int32_t count) {
    tag(NbtTag::kList, name);
    m_out += static_cast<char>(of);
    big_endian(count);
}
void NbtWriter::put_byte(std::string_view name, std::int8_t value) {
    tag(NbtTag::kByte, name);
    big_endian(value);
}
void NbtWriter::put_int(std::string_view name, std::int32_t value) {
    tag(NbtTag::kInt, name);
    big_endian(value);
}
void NbtWriter::put_long(std::string_view name, std::int64_t value) {
    tag(NbtTag::kLong, name);
    big_endian(value);
}
void NbtWriter::put_float(std::string_view name, float value) {
    tag(NbtTag::kFloat, name);
    big_endian(std::bit_cast<std::int32_t>(value));
}
void NbtWriter::put_double(std::string_view name, double value) {
    tag(NbtTag::kDouble, name);
    big_endian(std::bit_cast<std::int64_t>(value));
}
void NbtWriter::put_string(std::string_view name, std::string_view value) {
    tag(NbtTag::kString, name);
    value_string(value);
}
void NbtWriter::put_longs(std::string_view name, std::span<const std::uint64_t> values) {
    tag(NbtTag::kLongArray, name);
    big_endian(static_cast<std::int32_t>(values.size()));
    for (const std::uint64_t value : values)
        big_endian(value);
}
void NbtWriter::value_string(std::string_view value) {
    const std::string text = java_utf8(value);
    big_endian(static_cast<std::uint16_t>(text.size()));
    m_out += text;
}

}  // namespace terravox::exports::anvil
