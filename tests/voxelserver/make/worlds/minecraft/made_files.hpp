#pragma once

#include <libdeflate.h>
#include <lz4.h>
#include <xxhash.h>
#include <zip.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

#include "tests/voxelserver/make/worlds/minecraft/nbt_writer.hpp"

namespace terravox::test {

inline Bytes deflated(const Bytes& raw, bool gzip) {
    libdeflate_compressor* compressor = libdeflate_alloc_compressor(6);
    Bytes out(libdeflate_gzip_compress_bound(compressor, raw.size()));
    out.resize((gzip ? libdeflate_gzip_compress : libdeflate_zlib_compress)(
        compressor, raw.data(), raw.size(), out.data(), out.size()));
    libdeflate_free_compressor(compressor);
    return out;
}

/// As lz4-java's LZ4BlockOutputStream writes it. @param block_bytes unpacked, of each block
inline Bytes lz4_blocks(const Bytes& raw, std::size_t block_bytes = 65536) {
    Bytes out;
    const auto put = [&](std::uint32_t v) {
        for (int i = 0; i < 4; ++i)
            out.push_back(static_cast<std::uint8_t>(v >> (8 * i)));
    };
    const auto head = [&](int method, std::size_t packed, std::size_t size, std::uint32_t hash) {
        for (const char c : std::string("LZ4Block"))
            out.push_back(static_cast<std::uint8_t>(c));
        out.push_back(static_cast<std::uint8_t>(method | 6));
        put(static_cast<std::uint32_t>(packed));
        put(static_cast<std::uint32_t>(size));
        put(hash);
    };
    for (std::size_t at = 0; at < raw.size(); at += block_bytes) {
        const std::size_t size = std::min(block_bytes, raw.size() - at);
        Bytes packed(static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(size))));
        const auto* const from = reinterpret_cast<const char*>(&raw[at]);
        const int length =
            LZ4_compress_default(from, reinterpret_cast<char*>(packed.data()),
                                 static_cast<int>(size), static_cast<int>(packed.size()));
        packed.resize(static_cast<std::size_t>(length));
        const bool smaller = packed.size() < size;
        if (!smaller)
            packed.assign(&raw[at], &raw[at] + size);
        head(smaller ? 0x20 : 0x10, packed.size(), size,
             XXH32(&raw[at], size, 0x9747B28C) & 0x0FFFFFFF);
        out.insert(out.end(), packed.begin(), packed.end());
    }
    head(0x10, 0, 0, 0);
    return out;
}

/// A region file, chunk by chunk. Fields are open, so that tests can spoil them.
struct MadeRegion {
    Bytes bytes = Bytes(8192, 0);

    void set_location(int slot, std::uint32_t sector, std::uint32_t count) {
        const std::uint32_t location = sector << 8 | count;
        for (std::size_t i = 0; i < 4; ++i)
            bytes[static_cast<std::size_t>(slot) * 4 + i] =
                static_cast<std::uint8_t>(location >> (24 - 8 * i));
    }
    /// @param kind as in the file: 1 gzip, 2 zlib, 3 none, 4 lz4, | 128 external @return first byte
    /// of the chunk in the file
    std::size_t put_packed(int slot, int kind, const Bytes& packed) {
        const std::size_t begin = bytes.size();
        const std::size_t length = packed.size() + 1;
        NbtWriter head;
        head.raw(length, 4).raw(static_cast<std::uint64_t>(kind), 1);
        bytes.insert(bytes.end(), head.bytes.begin(), head.bytes.end());
        bytes.insert(bytes.end(), packed.begin(), packed.end());
        bytes.resize((bytes.size() + 4095) / 4096 * 4096, 0);
        set_location(slot, static_cast<std::uint32_t>(begin / 4096),
                     static_cast<std::uint32_t>((bytes.size() - begin) / 4096));
        return begin;
    }
    std::size_t put(int slot, const Bytes& nbt, int kind = 2) {
        return put_packed(slot, kind,
                          kind == 1   ? deflated(nbt, true)
                          : kind == 2 ? deflated(nbt, false)
                          : kind == 4 ? lz4_blocks(nbt)
                                      : nbt);
    }
};

inline void write_bytes(const std::filesystem::path& file, const Bytes& bytes) {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
}

inline Bytes read_bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Names are taken as they are, however wrong.
inline void write_zip(const std::filesystem::path& file,
                      const std::map<std::string, Bytes>& files) {
    int error = 0;
    zip_t* zip = zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
    if (zip == nullptr)
        throw std::runtime_error("make " + file.string());
    for (const auto& [name, bytes] : files)
        zip_file_add(zip, name.c_str(), zip_source_buffer(zip, bytes.data(), bytes.size(), 0),
                     ZIP_FL_ENC_UTF_8);
    if (zip_close(zip) != 0)
        throw std::runtime_error("write " + file.string());
}

/// @param data_version 0: none, as before 1.9
inline Bytes level_dat_nbt(const std::string& name, int data_version = 2975) {
    NbtWriter out;
    out.compound("")
        .compound("Data")
        .string("LevelName", name)
        .number32("SpawnX", 8)
        .number32("SpawnY", 64)
        .number32("SpawnZ", -8);
    out.number64("RandomSeed", -5);
    if (data_version != 0)
        out.number32("DataVersion", data_version)
            .compound("Version")
            .number32("Id", 2975)
            .string("Name", "1.18.2")
            .end();
    return deflated(out.end().end().bytes, true);
}

}  // namespace terravox::test
