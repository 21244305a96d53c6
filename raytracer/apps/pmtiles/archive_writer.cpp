#include "raytracer/apps/pmtiles/archive_writer.hpp"

#include <xxhash.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/gzip/gzip.hpp"
#include "common/util/error.hpp"

namespace terravox::pmtiles {
namespace {

void put_varint(std::string& to, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7)
        to.push_back(static_cast<char>(value | 0x80));
    to.push_back(static_cast<char>(value));
}

// Ref: PMTiles specification, version 3, chapter 4: all numbers of one kind, then those of the
// next, which packs well.
std::string packed(std::span<const DirectoryEntry> entries) {
    std::string out;
    put_varint(out, entries.size());
    std::uint64_t last = 0;
    for (const DirectoryEntry& entry : entries)
        put_varint(out, entry.id - std::exchange(last, entry.id));
    for (const DirectoryEntry& entry : entries)
        put_varint(out, entry.tiles);
    for (const DirectoryEntry& entry : entries)
        put_varint(out, entry.bytes);
    std::uint64_t end = 0;
    for (const DirectoryEntry& entry : entries) {
        // 0: behind the entry before.
        const bool follows = &entry != entries.data() && entry.offset == end;
        put_varint(out, follows ? 0 : entry.offset + 1);
        end = entry.offset + entry.bytes;
    }
    return gzip::pack(out);
}

/// The entries in leaves of a given number of them.
DirectoryTree in_leaves(std::span<const DirectoryEntry> entries, std::size_t leaf) {
    DirectoryTree out;
    std::vector<DirectoryEntry> root;
    for (std::size_t i = 0; i < entries.size(); i += leaf) {
        const std::string bytes = packed(entries.subspan(i, std::min(leaf, entries.size() - i)));
        root.push_back(
            {entries[i].id, out.leaves.size(), static_cast<std::uint32_t>(bytes.size()), 0});
        out.leaves += bytes;
    }
    out.root = packed(root);
    return out;
}

/// @param entries by ascending `id`
DirectoryTree directory_tree(std::span<const DirectoryEntry> entries) {
    constexpr std::size_t kSmallestLeaf = 4096;
    DirectoryTree out{packed(entries), {}};
    for (std::size_t leaf = kSmallestLeaf; out.root.size() > DirectoryTree::kMaxRoot_bytes;
         leaf *= 2)
        out = in_leaves(entries, leaf);
    return out;
}

constexpr std::uint8_t kGzip = 2;
constexpr std::uint8_t kNoCompression = 1;

/// Degrees times 10^7, as the header has them.
std::int32_t e7(double degrees) noexcept {
    return static_cast<std::int32_t>(std::llround(degrees * 1e7));
}

template <class T>
void put(std::string& to, T value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

ArchiveWriter::ArchiveWriter(const std::filesystem::path& file)
    : m_attempt("write the map tiles " + file.string()),
      m_target(file),
      m_spool(exports::ByteFile::spool_for(file)) {}

ArchiveWriter::Place ArchiveWriter::store(std::string_view tile) {
    const XXH128_hash_t hash = XXH3_128bits(tile.data(), tile.size());
    const auto [it, is_new] =
        m_stored.try_emplace(Hash{{hash.low64, hash.high64}},
                             Place{m_spool.bytes(), static_cast<std::uint32_t>(tile.size())});
    if (is_new)
        m_spool.put(tile);
    return it->second;
}

void ArchiveWriter::add(std::uint64_t id, std::string_view tile) {
    const bool follows =
        m_entries.empty() || id >= m_entries.back().id + std::uint64_t{m_entries.back().tiles};
    if (!follows || tile.empty() || tile.size() > std::numeric_limits<std::uint32_t>::max())
        throw util::Error(m_attempt + ": tile " + std::to_string(id) + " of " +
                          std::to_string(tile.size()) +
                          " bytes; allowed: ascending IDs, 1 byte to 4 GiB");
    const Place at = store(tile);
    ++m_tiles;
    if (!m_entries.empty()) {
        DirectoryEntry& before = m_entries.back();
        if (before.id + before.tiles == id && before.offset == at.offset) {
            ++before.tiles;
            return;
        }
    }
    m_entries.push_back({id, at.offset, at.bytes, 1});
}

// Ref: PMTiles specification, version 3, chapter 3.
void ArchiveWriter::finish(const ArchiveFacts& facts) {
    if (m_entries.empty())
        throw util::Error(m_attempt + ": there is nothing to be seen; allowed: one tile or more");
    const DirectoryTree directories = directory_tree(m_entries);
    const std::string metadata = gzip::pack(facts.metadata);
    std::string header = "PMTiles\3";
    std::uint64_t offset = 127;
    const auto put_section = [&](std::uint64_t bytes) {
        put(header, offset);
        put(header, bytes);
        offset += bytes;
    };
    put_section(directories.root.size());
    put_section(metadata.size());
    put_section(directories.leaves.size());
    put_section(m_spool.bytes());
    put(header, m_tiles);
    put(header, static_cast<std::uint64_t>(m_entries.size()));
    put(header, static_cast<std::uint64_t>(m_stored.size()));
    put(header, std::uint8_t{1});  // tiles lie in the order of their IDs
    put(header, kGzip);
    put(header, kNoCompression);
    put(header, facts.format);
    put(header, static_cast<std::uint8_t>(facts.min_zoom));
    put(header, static_cast<std::uint8_t>(facts.max_zoom));
    const auto& [west, south, east, north] = facts.bounds_deg;
    for (const double degrees : {west, south, east, north})
        put(header, e7(degrees));
    // Where a page begins: the whole map, from afar.
    put(header, static_cast<std::uint8_t>(facts.min_zoom));
    put(header, e7((west + east) / 2));
    put(header, e7((south + north) / 2));

    exports::ByteFile file(m_target.temporary_path(), m_target.target().string());
    file.put(header);
    file.put(directories.root);
    file.put(metadata);
    file.put(directories.leaves);
    m_spool.copy_to(file);
    file.close();
    m_target.commit();
}

}  // namespace terravox::pmtiles
