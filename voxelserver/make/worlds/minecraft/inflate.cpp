#include "voxelserver/make/worlds/minecraft/inflate.hpp"

#include <libdeflate.h>
#include <lz4.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

namespace terravox::minecraft {
namespace {

// Ref: LZ4BlockOutputStream of lz4-java: blocks of magic, token (method, size), packed and unpacked
// length, XXH32, data; the numbers little-endian.
constexpr std::string_view kLz4Magic = "LZ4Block";
constexpr std::size_t kLz4HeadBytes = 8 + 1 + 3 * 4;
constexpr std::uint32_t kLz4Seed = 0x9747B28C;
constexpr std::uint32_t kLz4HashMask = 0x0FFFFFFF;
constexpr unsigned kLz4Raw = 0x10;
constexpr unsigned kLz4Packed = 0x20;
constexpr std::size_t kMaxLz4Block_bytes = std::size_t{1} << 25;  // lz4-java's largest

bool is_lz4(std::span<const std::uint8_t> packed) noexcept {
    return packed.size() >= kLz4Magic.size() &&
           std::memcmp(packed.data(), kLz4Magic.data(), kLz4Magic.size()) == 0;
}

std::uint32_t little_endian(const std::uint8_t* bytes) noexcept {
    return bytes[0] | std::uint32_t{bytes[1]} << 8 | std::uint32_t{bytes[2]} << 16 |
           std::uint32_t{bytes[3]} << 24;
}

[[noreturn]] void too_large() {
    throw InflateError("unpacks to more than " + std::to_string(Inflater::kLimitBytes >> 20) +
                       " MiB, the most that is allowed");
}

}  // namespace

const char* compression_name(Compression compression) noexcept {
    switch (compression) {
        case Compression::kGzip: return "gzip";
        case Compression::kZlib: return "zlib";
        case Compression::kNone: return "none";
        case Compression::kLz4: return "lz4";
    }
    return "unknown";
}

Compression guess_compression(std::span<const std::uint8_t> packed) noexcept {
    if (packed.size() >= 2 && packed[0] == 0x1F && packed[1] == 0x8B)
        return Compression::kGzip;
    if (packed.size() >= 2 && (packed[0] & 0x0F) == 8 && (packed[0] * 256 + packed[1]) % 31 == 0)
        return Compression::kZlib;
    return is_lz4(packed) ? Compression::kLz4 : Compression::kNone;
}

struct Inflater::Deflate {
    libdeflate_decompressor* handle = libdeflate_alloc_decompressor();
    Deflate() {
        if (handle == nullptr)
            throw InflateError("libdeflate has no memory");
    }
    ~Deflate() { libdeflate_free_decompressor(handle); }
    Deflate(const Deflate&) = delete;
    Deflate& operator=(const Deflate&) = delete;
};

Inflater::Inflater() : m_deflate(std::make_unique<Deflate>()) {}
Inflater::~Inflater() = default;

// Grows the buffer to at least `bytes`; the first `keep` bytes stay.
void Inflater::reserve(std::size_t bytes, std::size_t keep) {
    if (bytes <= m_capacity)
        return;
    auto grown = std::make_unique_for_overwrite<std::uint8_t[]>(bytes);
    if (keep != 0)
        std::memcpy(grown.get(), m_buffer.get(), keep);
    m_buffer = std::move(grown);
    m_capacity = bytes;
}

std::span<const std::uint8_t> Inflater::unpack(Compression compression,
                                               std::span<const std::uint8_t> packed) {
    // The memory of one huge chunk is not kept for good.
    constexpr std::size_t kKeptBytes = std::size_t{4} << 20;
    if (m_capacity > kKeptBytes) {
        m_buffer.reset();
        m_capacity = 0;
    }
    switch (compression) {
        case Compression::kGzip:
        case Compression::kZlib: return unpack_deflate(compression, packed);
        case Compression::kLz4: return unpack_lz4(packed);
        case Compression::kNone: break;
    }
    if (packed.size() > kLimitBytes)
        too_large();
    return packed;
}

std::span<const std::uint8_t> Inflater::unpack_deflate(Compression compression,
                                                       std::span<const std::uint8_t> packed) {
    constexpr std::size_t kFirstBytes = std::size_t{512} << 10;
    const auto call =
        compression == Compression::kGzip ? libdeflate_gzip_decompress : libdeflate_zlib_decompress;
    for (std::size_t want = std::max(kFirstBytes, m_capacity);; want *= 4) {
        reserve(std::min(want, kLimitBytes), 0);
        std::size_t size = 0;
        const libdeflate_result result = call(m_deflate->handle, packed.data(), packed.size(),
                                              m_buffer.get(), m_capacity, &size);
        if (result == LIBDEFLATE_SUCCESS)
            return {m_buffer.get(), size};
        if (result != LIBDEFLATE_INSUFFICIENT_SPACE)
            throw InflateError(std::string("broken ") + compression_name(compression) + " data");
        if (m_capacity >= kLimitBytes)
            too_large();
    }
}

std::span<const std::uint8_t> Inflater::unpack_lz4(std::span<const std::uint8_t> packed) {
    std::size_t size = 0;
    while (!packed.empty()) {
        if (packed.size() < kLz4HeadBytes || !is_lz4(packed))
            throw InflateError("broken lz4 data: a block without its head");
        const unsigned method = packed[8] & 0xF0;
        const std::uint32_t packed_size = little_endian(&packed[9]);
        const std::uint32_t raw_size = little_endian(&packed[13]);
        const std::uint32_t hash = little_endian(&packed[17]);
        packed = packed.subspan(kLz4HeadBytes);
        if (packed_size == 0 && raw_size == 0)
            return {m_buffer.get(), size};  // the end mark
        if (packed_size > packed.size() || raw_size > kMaxLz4Block_bytes || raw_size == 0 ||
            (method != kLz4Raw && method != kLz4Packed) ||
            (method == kLz4Raw && packed_size != raw_size))
            throw InflateError("broken lz4 data: an impossible block");
        if (size + raw_size > kLimitBytes)
            too_large();
        if (size + raw_size > m_capacity)
            reserve(std::min(kLimitBytes, std::max(size + raw_size, 2 * m_capacity)), size);
        std::uint8_t* const out = m_buffer.get() + size;
        if (method == kLz4Raw)
            std::memcpy(out, packed.data(), raw_size);
        else if (LZ4_decompress_safe(reinterpret_cast<const char*>(packed.data()),
                                     reinterpret_cast<char*>(out), static_cast<int>(packed_size),
                                     static_cast<int>(raw_size)) != static_cast<int>(raw_size))
            throw InflateError("broken lz4 data");
        if ((XXH32(out, raw_size, kLz4Seed) & kLz4HashMask) != hash)
            throw InflateError("lz4 data that do not match their checksum");
        packed = packed.subspan(packed_size);
        size += raw_size;
    }
    return {m_buffer.get(), size};
}

}  // namespace terravox::minecraft
