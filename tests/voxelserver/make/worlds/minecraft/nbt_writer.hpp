#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::test {

using Bytes = std::vector<std::uint8_t>;

/// Writes NBT for tests, with no regard for sense: broken NBT is wanted as well.
class NbtWriter {
public:
    Bytes bytes;

    NbtWriter& raw(std::uint64_t value, int width) {
        for (int i = width - 1; i >= 0; --i)
            bytes.push_back(i < 8 ? static_cast<std::uint8_t>(value >> (8 * i)) : std::uint8_t{0});
        return *this;
    }
    NbtWriter& text(std::string_view s) {
        raw(s.size(), 2);
        bytes.insert(bytes.end(), s.begin(), s.end());
        return *this;
    }
    NbtWriter& field(int type, std::string_view name) {
        return raw(static_cast<std::uint64_t>(type), 1).text(name);
    }
    NbtWriter& end() { return raw(0, 1); }

    NbtWriter& number8(std::string_view name, std::int64_t v) {
        return field(1, name).raw(static_cast<std::uint64_t>(v), 1);
    }
    NbtWriter& number32(std::string_view name, std::int64_t v) {
        return field(3, name).raw(static_cast<std::uint64_t>(v), 4);
    }
    NbtWriter& number64(std::string_view name, std::int64_t v) {
        return field(4, name).raw(static_cast<std::uint64_t>(v), 8);
    }
    NbtWriter& string(std::string_view name, std::string_view v) { return field(8, name).text(v); }
    NbtWriter& compound(std::string_view name) { return field(10, name); }
    NbtWriter& list(std::string_view name, int type, std::uint32_t count) {
        return field(9, name).raw(static_cast<std::uint64_t>(type), 1).raw(count, 4);
    }
    /// The beginning of a chunk at 0, 0 whose sections stand in it itself.
    NbtWriter& chunk(std::int64_t data_version, std::uint32_t sections) {
        return compound("")
            .number32("DataVersion", data_version)
            .number32("xPos", 0)
            .number32("zPos", 0)
            .list("sections", 10, sections);
    }
    NbtWriter& byte_array(std::string_view name, const Bytes& v) {
        field(7, name).raw(v.size(), 4);
        bytes.insert(bytes.end(), v.begin(), v.end());
        return *this;
    }
    NbtWriter& long_array(std::string_view name, const std::vector<std::uint64_t>& v) {
        field(12, name).raw(v.size(), 4);
        for (const std::uint64_t word : v)
            raw(word, 8);
        return *this;
    }
};

}  // namespace terravox::test
