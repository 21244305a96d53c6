#include "voxelserver/out/export/anvil/region_writer.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <fstream>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::exports::anvil {
namespace {

constexpr std::size_t kSector_bytes = 4096;
constexpr std::size_t kMaxSectors = 255;
constexpr std::size_t kChunkHeader_bytes = 5;
constexpr int kChunksAlong = 32;
constexpr char kZlib = 2;
constexpr char kExternal = static_cast<char>(0x80);

std::size_t sectors_of(std::size_t bytes) noexcept {
    return (bytes + kSector_bytes - 1) / kSector_bytes;
}

void put_big_endian(std::string& out, std::size_t at, std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
        out[at + static_cast<std::size_t>(i)] = static_cast<char>(value >> (24 - 8 * i) & 0xff);
}

/// Place of a chunk in the table of its region.
std::size_t slot_of(const PackedChunk& chunk) noexcept {
    return static_cast<std::size_t>((chunk.z & (kChunksAlong - 1)) * kChunksAlong +
                                    (chunk.x & (kChunksAlong - 1)));
}

}  // namespace

struct Compressor::Impl {
    libdeflate_compressor* deflate = libdeflate_alloc_compressor(6);
    ~Impl() { libdeflate_free_compressor(deflate); }
};

Compressor::Compressor() : m_impl(std::make_unique<Impl>()) {
    if (m_impl->deflate == nullptr)
        throw util::Error("compress chunks: out of memory");
}
Compressor::~Compressor() = default;

std::string Compressor::zlib(std::string_view bytes) {
    std::string out(libdeflate_zlib_compress_bound(m_impl->deflate, bytes.size()), '\0');
    out.resize(libdeflate_zlib_compress(m_impl->deflate, bytes.data(), bytes.size(), out.data(),
                                        out.size()));
    return out;
}

std::string Compressor::gzip(std::string_view bytes) {
    std::string out(libdeflate_gzip_compress_bound(m_impl->deflate, bytes.size()), '\0');
    out.resize(libdeflate_gzip_compress(m_impl->deflate, bytes.data(), bytes.size(), out.data(),
                                        out.size()));
    return out;
}

std::uint64_t write_region(const std::filesystem::path& folder, std::int32_t rx, std::int32_t rz,
                           std::vector<PackedChunk> chunks) {
    std::sort(chunks.begin(), chunks.end(),
              [](const PackedChunk& a, const PackedChunk& b) { return slot_of(a) < slot_of(b); });
    std::uint64_t written = 0;
    // Two sectors of tables: the places of the chunks, and their times of writing (none, so that
    // the same world gives the same bytes).
    std::string out(2 * kSector_bytes, '\0');
    for (const PackedChunk& chunk : chunks) {
        const bool external = sectors_of(chunk.zlib.size() + kChunkHeader_bytes) > kMaxSectors;
        if (external) {
            util::write_file_atomically(
                folder / ("c." + std::to_string(chunk.x) + "." + std::to_string(chunk.z) + ".mcc"),
                chunk.zlib, util::Links::kReplace);
            written += chunk.zlib.size();
        }
        const std::string_view inside =
            external ? std::string_view() : std::string_view(chunk.zlib);
        const std::size_t at = out.size();
        const std::size_t sectors = sectors_of(inside.size() + kChunkHeader_bytes);
        put_big_endian(out, slot_of(chunk) * 4,
                       static_cast<std::uint32_t>(at / kSector_bytes << 8 | sectors));
        out.resize(at + kChunkHeader_bytes);
        put_big_endian(out, at, static_cast<std::uint32_t>(inside.size() + 1));
        out[at + 4] = static_cast<char>(external ? kZlib | kExternal : kZlib);
        out += inside;
        out.resize(at + sectors * kSector_bytes);
    }
    util::write_file_atomically(
        folder / ("r." + std::to_string(rx) + "." + std::to_string(rz) + ".mca"), out,
        util::Links::kReplace);
    return written + out.size();
}

}  // namespace terravox::exports::anvil
