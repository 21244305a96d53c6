#pragma once

#include <libdeflate.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::test {

inline std::string read_all_bytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// A PMTiles archive as a reader sees it, by the specification alone. Ref: PMTiles, version 3.
class ArchiveReader {
public:
    explicit ArchiveReader(std::string bytes) : m_bytes(std::move(bytes)) {
        if (m_bytes.substr(0, 8) != "PMTiles\3")
            throw std::runtime_error("no PMTiles archive, version 3");
        read_directory(section(8));
    }
    [[nodiscard]] std::string metadata() const { return unpacked(section(24)); }
    /// The bytes of each tile, by its number.
    [[nodiscard]] const std::map<std::uint64_t, std::string>& tiles() const { return m_tiles; }
    template <class T>
    [[nodiscard]] T number(std::size_t at) const {
        T out;
        std::memcpy(&out, m_bytes.data() + at, sizeof out);
        return out;
    }
    [[nodiscard]] std::uint64_t root_bytes() const { return number<std::uint64_t>(16); }
    [[nodiscard]] std::uint64_t leaf_bytes() const { return number<std::uint64_t>(48); }

private:
    [[nodiscard]] std::string section(std::size_t at) const {
        return m_bytes.substr(number<std::uint64_t>(at), number<std::uint64_t>(at + 8));
    }
    [[nodiscard]] static std::string unpacked(const std::string& gzip) {
        std::string out(std::size_t{1} << 24, '\0');
        std::size_t bytes = 0;
        libdeflate_decompressor* const all = libdeflate_alloc_decompressor();
        const auto result = libdeflate_gzip_decompress(all, gzip.data(), gzip.size(), out.data(),
                                                       out.size(), &bytes);
        libdeflate_free_decompressor(all);
        if (result != LIBDEFLATE_SUCCESS)
            throw std::runtime_error("no gzip file");
        out.resize(bytes);
        return out;
    }
    static std::uint64_t varint(std::string_view& from) {
        std::uint64_t out = 0;
        for (int shift = 0;; shift += 7) {
            const auto byte = static_cast<std::uint8_t>(from.at(0));
            from.remove_prefix(1);
            out |= static_cast<std::uint64_t>(byte & 127) << shift;
            if (byte < 128)
                return out;
        }
    }
    void read_directory(const std::string& packed) {
        const std::string bytes = unpacked(packed);
        std::string_view from = bytes;
        struct Entry {
            std::uint64_t id, run, length, offset;
        };
        std::vector<Entry> entries(varint(from));
        std::uint64_t id = 0;
        for (Entry& entry : entries)
            entry.id = id += varint(from);
        for (Entry& entry : entries)
            entry.run = varint(from);
        for (Entry& entry : entries)
            entry.length = varint(from);
        std::uint64_t end = 0;
        for (Entry& entry : entries) {
            const std::uint64_t offset = varint(from);
            if (offset == 0 && &entry == entries.data())
                throw std::runtime_error("the first entry follows none");
            entry.offset = offset == 0 ? end : offset - 1;
            end = entry.offset + entry.length;
        }
        const std::string leaves = section(40);
        const std::string tiles = section(56);
        for (const Entry& entry : entries) {
            if (entry.run == 0)
                read_directory(leaves.substr(entry.offset, entry.length));
            for (std::uint64_t i = 0; i < entry.run; ++i)
                m_tiles[entry.id + i] = tiles.substr(entry.offset, entry.length);
        }
    }

    std::string m_bytes;
    std::map<std::uint64_t, std::string> m_tiles;
};

}  // namespace terravox::test
