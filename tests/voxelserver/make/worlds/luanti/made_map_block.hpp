#pragma once

#include <libdeflate.h>
#include <zstd.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace terravox::test::luanti {

using Bytes = std::vector<std::uint8_t>;

/// A map block of known nodes.
struct MadeBlock {
    std::vector<std::string> names{"air"};
    std::array<std::uint16_t, 4096> ids{};  ///< indices into names; in the game's axes

    /// @param x, y, z in [0, 16), z northwards @param name index into names
    void set(int x, int y, int z, std::uint16_t name) {
        ids[static_cast<std::size_t>(x + 16 * y + 256 * z)] = name;
    }
    [[nodiscard]] std::uint16_t at(int x, int y, int z) const {
        return ids[static_cast<std::size_t>(x + 16 * y + 256 * z)];
    }
};

/// Numbers as the game writes them.
class BigEndian {
public:
    Bytes bytes;

    BigEndian& u8(unsigned v) {
        bytes.push_back(static_cast<std::uint8_t>(v));
        return *this;
    }
    BigEndian& u16(unsigned v) { return u8(v >> 8).u8(v & 0xFF); }
    BigEndian& u32(std::uint32_t v) { return u16(v >> 16).u16(v & 0xFFFF); }
    BigEndian& put(const Bytes& more) {
        bytes.insert(bytes.end(), more.begin(), more.end());
        return *this;
    }
    BigEndian& put(const std::string& text) { return put(Bytes(text.begin(), text.end())); }
};

inline Bytes deflated(const Bytes& raw) {
    libdeflate_compressor* const compressor = libdeflate_alloc_compressor(6);
    Bytes out(libdeflate_zlib_compress_bound(compressor, raw.size()));
    out.resize(
        libdeflate_zlib_compress(compressor, raw.data(), raw.size(), out.data(), out.size()));
    libdeflate_free_compressor(compressor);
    return out;
}

inline Bytes zstd_frame(const Bytes& raw) {
    Bytes out(ZSTD_compressBound(raw.size()));
    const std::size_t size = ZSTD_compress(out.data(), out.size(), raw.data(), raw.size(), 3);
    if (ZSTD_isError(size) != 0)
        throw std::runtime_error(ZSTD_getErrorName(size));
    out.resize(size);
    return out;
}

inline void put_names(const MadeBlock& block, BigEndian& out) {
    out.u8(0).u16(static_cast<unsigned>(block.names.size()));
    for (std::size_t i = 0; i < block.names.size(); ++i) {
        out.u16(static_cast<unsigned>(i));
        out.u16(static_cast<unsigned>(block.names[i].size())).put(block.names[i]);
    }
}

inline Bytes node_bytes(const MadeBlock& block) {
    BigEndian out;
    for (const std::uint16_t id : block.ids)
        out.u16(id);
    out.bytes.resize(4096 * 4, 0x0F);  // light and orientation
    return out.bytes;
}

/// What follows the nodes, of the metadata on: one node with two fields, one object, one timer.
inline Bytes metadata_bytes() {
    BigEndian out;
    out.u8(2).u16(1).u16(17).u32(1).u16(4).put("text").u32(5).put("hello").u8(0);
    return out.put("EndInventory\n").bytes;
}
inline Bytes object_bytes() {
    BigEndian out;
    return out.u8(0).u16(1).u8(7).u32(10000).u32(20000).u32(30000).u16(4).put("mese").bytes;
}
inline Bytes timer_bytes() {
    BigEndian out;
    return out.u8(10).u16(1).u16(5).u32(1000).u32(500).bytes;
}

/// All of a block since version 29, before it is compressed and without the version.
inline Bytes body_29(const MadeBlock& block) {
    BigEndian out;
    out.u8(0x08).u16(0xFFFF).u32(1234);
    put_names(block, out);
    return out.u8(2)
        .u8(2)
        .put(node_bytes(block))
        .put(metadata_bytes())
        .put(object_bytes())
        .put(timer_bytes())
        .bytes;
}

/// A block as the game stores it. @param version 25 to 29
inline Bytes map_block_blob(const MadeBlock& block, int version) {
    BigEndian out;
    out.u8(static_cast<unsigned>(version));
    if (version >= 29)
        return out.put(zstd_frame(body_29(block))).bytes;
    out.u8(0x08);
    if (version >= 27)
        out.u16(0xFFFF);
    out.u8(2).u8(2).put(deflated(node_bytes(block))).put(deflated(metadata_bytes()));
    out.put(object_bytes()).u32(1234);
    put_names(block, out);
    return out.put(timer_bytes()).bytes;
}

}  // namespace terravox::test::luanti
