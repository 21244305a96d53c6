#pragma once

// A reading of exported worlds of its own, by the format's description and nothing of the writer:
// what a test compares with.

#include <libdeflate.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "tests/common/content.hpp"

namespace terravox::test {

namespace fs = std::filesystem;

struct Nbt;
using NbtList = std::vector<Nbt>;
using NbtTable = std::map<std::string, Nbt>;
struct Nbt {
    std::variant<std::int64_t, double, std::string, std::vector<std::int64_t>, NbtList, NbtTable>
        value;
    [[nodiscard]] const Nbt& at(const std::string& name) const {
        const auto& table = std::get<NbtTable>(value);
        const auto found = table.find(name);
        if (found == table.end())
            throw std::runtime_error("no tag " + name);
        return found->second;
    }
    [[nodiscard]] bool has(const std::string& name) const {
        return std::get<NbtTable>(value).contains(name);
    }
    [[nodiscard]] std::int64_t number() const { return std::get<std::int64_t>(value); }
    [[nodiscard]] const std::string& text() const { return std::get<std::string>(value); }
    [[nodiscard]] const NbtList& list() const { return std::get<NbtList>(value); }
    [[nodiscard]] const std::vector<std::int64_t>& longs() const {
        return std::get<std::vector<std::int64_t>>(value);
    }
};

class NbtParser {
public:
    explicit NbtParser(std::string bytes) : m_bytes(std::move(bytes)) {}
    Nbt root() {
        if (number(1) != 10)
            throw std::runtime_error("the root is no compound");
        (void)text();
        Nbt out = payload(10);
        if (m_at != m_bytes.size())
            throw std::runtime_error("bytes behind the root");
        return out;
    }

private:
    std::int64_t number(int size) {
        std::uint64_t out = 0;
        for (int i = 0; i < size; ++i)
            out = out << 8 | static_cast<unsigned char>(m_bytes.at(m_at++));
        return static_cast<std::int64_t>(out << (64 - 8 * size)) >> (64 - 8 * size);
    }
    std::string text() {
        const auto length = static_cast<std::size_t>(number(2) & 0xffff);
        if (m_at + length > m_bytes.size())
            throw std::runtime_error("a text reaches past the end");
        m_at += length;
        return m_bytes.substr(m_at - length, length);
    }
    Nbt payload(int type) {
        switch (type) {
            case 1: return {number(1)};
            case 2: return {number(2)};
            case 3: return {number(4)};
            case 4: return {number(8)};
            case 5:
                return {static_cast<double>(
                    std::bit_cast<float>(static_cast<std::int32_t>(number(4))))};
            case 6: return {std::bit_cast<double>(number(8))};
            case 8: return {text()};
            case 9: {
                const int of = static_cast<int>(number(1));
                NbtList list;
                for (auto n = number(4); n > 0; --n)
                    list.push_back(payload(of));
                return {list};
            }
            case 10: {
                NbtTable table;
                while (const int of = static_cast<int>(number(1))) {
                    std::string name = text();
                    if (!table.emplace(name, payload(of)).second)
                        throw std::runtime_error("twice " + name);
                }
                return {table};
            }
            case 12: {
                std::vector<std::int64_t> longs;
                for (auto n = number(4); n > 0; --n)
                    longs.push_back(number(8));
                return {longs};
            }
            default: throw std::runtime_error("tag " + std::to_string(type));
        }
    }
    std::string m_bytes;
    std::size_t m_at = 0;
};

inline std::string inflate(const std::string& packed, bool gzip) {
    std::string out(std::size_t{1} << 24, '\0');
    auto* const decompressor = libdeflate_alloc_decompressor();
    std::size_t size = 0;
    const auto unpack = gzip ? libdeflate_gzip_decompress : libdeflate_zlib_decompress;
    const auto result =
        unpack(decompressor, packed.data(), packed.size(), out.data(), out.size(), &size);
    libdeflate_free_decompressor(decompressor);
    if (result != LIBDEFLATE_SUCCESS)
        throw std::runtime_error("does not inflate");
    out.resize(size);
    return out;
}

/// The chunks of a region file by place in its table, still packed.
inline std::map<int, std::string> packed_chunks(const fs::path& file) {
    const std::string bytes = read_content(file);
    const auto u32 = [&](std::size_t at) {
        std::uint32_t v = 0;
        for (std::size_t i = 0; i < 4; ++i)
            v = v << 8 | static_cast<unsigned char>(bytes.at(at + i));
        return v;
    };
    std::map<int, std::string> out;
    if (bytes.size() % 4096 != 0)
        throw std::runtime_error("no whole sectors");
    std::vector<bool> used(bytes.size() / 4096);
    int rx = 0;
    int rz = 0;
    if (std::sscanf(file.filename().c_str(), "r.%d.%d.mca", &rx, &rz) != 2)
        throw std::runtime_error("name");
    for (int slot = 0; slot < 1024; ++slot) {
        const std::uint32_t entry = u32(static_cast<std::size_t>(slot) * 4);
        if (entry == 0)
            continue;
        const std::size_t sector = entry >> 8;
        const std::size_t count = entry & 255;
        const std::size_t length = u32(sector * 4096);
        for (std::size_t s = sector; s < sector + count; ++s) {
            if (s < 2 || used.at(s))
                throw std::runtime_error("sectors overlap");
            used[s] = true;
        }
        if (length + 4 > count * 4096)
            throw std::runtime_error("longer than its sectors");
        const int kind = static_cast<unsigned char>(bytes.at(sector * 4096 + 4));
        if (kind == 2)
            out[slot] = bytes.substr(sector * 4096 + 5, length - 1);
        else if (kind == 130)
            out[slot] = read_content(file.parent_path() /
                                     ("c." + std::to_string(rx * 32 + slot % 32) + "." +
                                      std::to_string(rz * 32 + slot / 32) + ".mcc"));
        else
            throw std::runtime_error("kind " + std::to_string(kind));
    }
    return out;
}

/// All blocks of a world, by place; air is left out.
struct ReadWorld {
    struct Block {
        std::string name;
        std::map<std::string, std::string> properties;
    };
    std::map<std::array<int, 3>, Block> blocks;
    std::map<std::array<int, 3>, std::string> biomes;  ///< by 4 x 4 x 4 cell
    std::vector<Nbt> chunks;
};

inline int bits_for(std::size_t palette, int least) {
    int bits = least;
    while ((std::size_t{1} << bits) < palette)
        ++bits;
    return bits;
}
/// Entry `i` of packed values, of which none lies across two longs.
inline std::size_t packed_at(const std::vector<std::int64_t>& longs, int bits, std::size_t i) {
    const std::size_t in_one = 64 / static_cast<std::size_t>(bits);
    return static_cast<std::uint64_t>(longs.at(i / in_one)) >>
               (i % in_one * static_cast<std::size_t>(bits)) &
           ((std::uint64_t{1} << bits) - 1);
}

inline void read_section(const Nbt& section, int x0, int z0, ReadWorld& out) {
    const int y0 = static_cast<int>(section.at("Y").number()) * 16;
    const Nbt& states = section.at("block_states");
    const NbtList& palette = states.at("palette").list();
    std::vector<ReadWorld::Block> blocks;
    for (const Nbt& entry : palette) {
        ReadWorld::Block block{entry.at("Name").text(), {}};
        if (entry.has("Properties"))
            for (const auto& [name, value] : std::get<NbtTable>(entry.at("Properties").value))
                block.properties[name] = value.text();
        blocks.push_back(std::move(block));
    }
    for (std::size_t i = 0; i < 4096; ++i) {
        const std::size_t which = palette.size() == 1 ? 0
                                                      : packed_at(states.at("data").longs(),
                                                                  bits_for(palette.size(), 4), i);
        const std::array<int, 3> place{x0 + static_cast<int>(i & 15), y0 + static_cast<int>(i >> 8),
                                       z0 + static_cast<int>(i >> 4 & 15)};
        if (blocks.at(which).name != "minecraft:air")
            out.blocks[place] = blocks[which];
    }
    const Nbt& biomes = section.at("biomes");
    const NbtList& names = biomes.at("palette").list();
    for (std::size_t i = 0; i < 64; ++i) {
        const std::size_t which =
            names.size() == 1 ? 0
                              : packed_at(biomes.at("data").longs(), bits_for(names.size(), 1), i);
        out.biomes[{x0 / 4 + static_cast<int>(i & 3), y0 / 4 + static_cast<int>(i >> 4),
                    z0 / 4 + static_cast<int>(i >> 2 & 3)}] = names.at(which).text();
    }
}

inline ReadWorld read_world(const fs::path& folder) {
    ReadWorld out;
    for (const auto& file : fs::directory_iterator(folder / "region")) {
        if (file.path().extension() != ".mca")
            continue;
        int rx = 0;
        int rz = 0;
        if (std::sscanf(file.path().filename().c_str(), "r.%d.%d.mca", &rx, &rz) != 2)
            throw std::runtime_error("name");
        for (const auto& [slot, packed] : packed_chunks(file.path())) {
            const Nbt chunk = NbtParser(inflate(packed, false)).root();
            const auto x = static_cast<int>(chunk.at("xPos").number());
            const auto z = static_cast<int>(chunk.at("zPos").number());
            if (x != rx * 32 + slot % 32 || z != rz * 32 + slot / 32)
                throw std::runtime_error("a chunk in the wrong place");
            for (const Nbt& section : chunk.at("sections").list())
                read_section(section, x * 16, z * 16, out);
            out.chunks.push_back(chunk);
        }
    }
    return out;
}

}  // namespace terravox::test
