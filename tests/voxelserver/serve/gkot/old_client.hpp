#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace terravox::test {

/// A reply of /gkot/box as a client of the first system reads it: written from the description of
/// the protocol alone.
struct OldReply {
    std::int32_t chunk_x = 0;
    std::int32_t chunk_y = 0;
    std::int32_t chunk_z = 0;
    std::int32_t max_height = 0;
    std::vector<std::uint32_t> blocks;  ///< index bx + bz * sx + by * sx * sz
    std::vector<std::int32_t> tops;     ///< index bx + bz * sx
};

inline OldReply read_old_reply(const std::string& bytes) {
    std::size_t at = 0;
    const auto word = [&] {
        if (bytes.size() - at < 4)
            throw std::runtime_error("the reply is cut short at byte " + std::to_string(at));
        std::uint32_t out = 0;
        for (int i = 0; i < 4; ++i)
            out = out * 256 + static_cast<unsigned char>(bytes[at++]);
        return out;
    };
    const auto number = [&] { return static_cast<std::int32_t>(word()); };
    OldReply out;
    out.chunk_x = number();
    out.chunk_y = number();
    out.chunk_z = number();
    out.max_height = number();
    const std::uint32_t block_count = word();
    if (block_count > bytes.size() / 4)
        throw std::runtime_error("more blocks than bytes");
    for (std::uint32_t i = 0; i < block_count; ++i)
        out.blocks.push_back(word());
    const std::uint32_t column_count = word();
    if (column_count > bytes.size() / 4)
        throw std::runtime_error("more columns than bytes");
    for (std::uint32_t i = 0; i < column_count; ++i)
        out.tops.push_back(number());
    if (at != bytes.size())
        throw std::runtime_error("bytes after the end");
    return out;
}

}  // namespace terravox::test
