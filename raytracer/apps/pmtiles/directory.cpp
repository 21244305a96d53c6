#include "raytracer/apps/pmtiles/directory.hpp"

#include <algorithm>
#include <utility>

#include "common/gzip/gzip.hpp"

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

}  // namespace

DirectoryTree directory_tree(std::span<const DirectoryEntry> entries) {
    constexpr std::size_t kSmallestLeaf = 4096;
    DirectoryTree out{packed(entries), {}};
    for (std::size_t leaf = kSmallestLeaf; out.root.size() > DirectoryTree::kMaxRoot_bytes;
         leaf *= 2)
        out = in_leaves(entries, leaf);
    return out;
}

}  // namespace terravox::pmtiles
