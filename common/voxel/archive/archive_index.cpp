#include "common/voxel/archive/archive_reader.hpp"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "common/util/error.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel::archive {
namespace {

constexpr std::size_t kLeafCache_bytes = std::size_t{64} << 20;
constexpr std::uint64_t kMaxInfo_bytes = 4 << 20;
constexpr std::uint64_t kMaxRoot_bytes = std::uint64_t{256} << 20;
const std::uint64_t kMaxLeaf_bytes = ZSTD_compressBound(kLeafEntries * sizeof(Entry));

std::optional<FileKind> find_kind(const char (&magic)[sizeof kMagic]) {
    const auto is = [&](const char (&other)[sizeof kMagic]) {
        return std::memcmp(magic, other, sizeof kMagic) == 0;
    };
    if (is(kMagic))
        return FileKind::kArchive;
    if (is(kShardMagic))
        return FileKind::kShard;
    if (is(kChangeMagic))
        return FileKind::kChange;
    return std::nullopt;
}

}  // namespace

ArchiveIndex::ArchiveIndex(ByteSource& source, Of of) : m_source(source) {
    read_header(of);
    read_info();
    check_bounds();
    read_root();
}

void ArchiveIndex::fail(const std::string& what) const {
    throw util::Error("open the box archive {}: {}", m_source.name(), what);
}

void ArchiveIndex::read_header(Of of) {
    std::vector<std::byte> room;
    const auto bytes = m_source.read(0, sizeof m_header, room);
    std::memcpy(&m_header, bytes.data(), sizeof m_header);
    const std::optional<FileKind> kind = find_kind(m_header.magic);
    if (!kind)
        fail("not a box archive");
    m_kind = *kind;
    if (m_kind == FileKind::kShard && of == Of::kArchive)
        fail("it is a shard of one; terravox archive merge joins the shards");
    if (m_kind == FileKind::kChange && of == Of::kArchive)
        fail("it is a change of one; terravox archive patch puts it into the archive");
    if (m_header.version != kVersion)
        fail("version " + std::to_string(m_header.version) +
             "; allowed: " + std::to_string(kVersion));
    if (m_header.checksum != XXH64(&m_header, offsetof(Header, checksum), 0))
        fail("its header is damaged");
    if (m_header.root_offset == 0)
        fail("it was never finished; convert again to go on");
    const auto inside = [&](std::uint64_t offset, std::uint64_t count) {
        return offset <= m_header.file_bytes && count <= m_header.file_bytes - offset;
    };
    if (m_header.info_bytes > kMaxInfo_bytes || m_header.root_bytes > kMaxRoot_bytes ||
        m_header.root_bytes < sizeof(std::uint64_t) ||
        (m_header.root_bytes - sizeof(std::uint64_t)) % sizeof(Leaf) != 0 ||
        !inside(m_header.info_offset, m_header.info_bytes) ||
        !inside(m_header.root_offset, m_header.root_bytes))
        fail("its header leads outside");
}

void ArchiveIndex::read_info() {
    std::vector<std::byte> room;
    const auto text =
        m_source.read(m_header.info_offset, static_cast<std::size_t>(m_header.info_bytes), room);
    m_info = world_from_json(std::string(reinterpret_cast<const char*>(text.data()), text.size()),
                             m_source.name());
}

// The cost of a picture of air is proportional to the number of boxes of the coarsest level, so
// these must be large in relation to the world.
void ArchiveIndex::check_bounds() const {
    if (m_info.bounds.empty())
        return;
    const BoxRange range = boxes_over(m_info.bounds, 0);
    const BoxKey last{0, range.max.bx - 1, range.max.by - 1, range.max.bz - 1};
    if (!in_range(to_key(range.min)) || !in_range(to_key(last)))
        fail("its bounds reach beyond 2^20 boxes from the origin");
    if (const int needed = levels_for(m_info.bounds); m_info.levels < needed)
        fail("levels = " + std::to_string(m_info.levels) + "; bounds of this width need at least " +
             std::to_string(needed));
}

/// Whether the box lies in the world that the archive declares.
bool ArchiveIndex::has_room_for(const Key& key) const {
    return in_range(key) && key.level < m_info.levels && !m_info.bounds.empty() &&
           boxes_over(m_info.bounds, key.level).contains(to_key(key));
}

void ArchiveIndex::read_root() {
    std::vector<std::byte> room;
    const auto bytes =
        m_source.read(m_header.root_offset, static_cast<std::size_t>(m_header.root_bytes), room);
    const std::size_t payload = bytes.size() - sizeof(std::uint64_t);
    std::uint64_t checksum = 0;
    std::memcpy(&checksum, bytes.data() + payload, sizeof checksum);
    if (checksum != XXH64(bytes.data(), payload, 0))
        fail("its index is damaged");
    m_root.resize(payload / sizeof(Leaf));
    if (payload != 0)
        std::memcpy(m_root.data(), bytes.data(), payload);
    for (std::size_t i = 0; i < m_root.size(); ++i) {
        const Leaf& leaf = m_root[i];
        if (leaf.entries == 0 || leaf.entries > kLeafEntries || leaf.offset > m_header.file_bytes ||
            leaf.bytes > m_header.file_bytes - leaf.offset || leaf.bytes > kMaxLeaf_bytes ||
            !in_range(leaf.first) || (i > 0 && !before(m_root[i - 1].first, leaf.first)))
            fail("its index is damaged");
        if (!has_room_for(leaf.first))
            fail("its index names box " + to_string(to_key(leaf.first)) +
                 ", which lies outside of its bounds");
    }
}

std::vector<Entry> ArchiveIndex::entries(std::size_t index) const {
    const Leaf& leaf = m_root[index];
    std::vector<std::byte> room;
    const auto frame = m_source.read(leaf.offset, leaf.bytes, room);
    const auto wrong = [&](const std::string& what) {
        return util::Error("read the index of the box archive {}: leaf {}{}", m_source.name(),
                           index, what);
    };
    const auto damaged = [&] { return wrong(" is damaged"); };
    if (XXH64(frame.data(), frame.size(), 0) != leaf.checksum)
        throw damaged();
    std::vector<Entry> entries(leaf.entries);
    const std::size_t size =
        ZSTD_decompress(entries.data(), entries.size() * sizeof(Entry), frame.data(), frame.size());
    if (size != entries.size() * sizeof(Entry))
        throw damaged();
    // Each key once, from the first that the root names to below that of the next leaf.
    const auto not_before = [](const Entry& a, const Entry& b) { return !before(a.key, b.key); };
    if (std::adjacent_find(entries.begin(), entries.end(), not_before) != entries.end() ||
        to_key(entries.front().key) != to_key(leaf.first) ||
        (index + 1 < m_root.size() && !before(entries.back().key, m_root[index + 1].first)))
        throw damaged();
    for (const Entry& e : entries) {
        if (e.offset > m_header.file_bytes ||
            e.bytes > std::min<std::uint64_t>(kMaxFrame_bytes, m_header.file_bytes - e.offset) ||
            (e.kind != Kind::kBox && e.kind != Kind::kHole))
            throw damaged();
        if (!has_room_for(e.key))
            throw wrong(" names box " + to_string(to_key(e.key)) +
                        ", which lies outside of its bounds");
    }
    return entries;
}

EntryFinder::EntryFinder(const ArchiveIndex& index) : m_index(index), m_leaves(kLeafCache_bytes) {}

std::shared_ptr<const EntryFinder::Entries> EntryFinder::leaf_at(const Key& key) {
    const std::span<const Leaf> root = m_index.leaves();
    const auto after =
        std::upper_bound(root.begin(), root.end(), key,
                         [](const Key& k, const Leaf& leaf) { return before(k, leaf.first); });
    if (after == root.begin())
        return nullptr;
    const auto leaf = static_cast<std::size_t>(after - root.begin()) - 1;
    return m_leaves.get(
        leaf, [&] { return std::make_shared<const Entries>(m_index.entries(leaf)); },
        [](const auto& made) { return made->size() * sizeof(Entry); });
}

std::optional<Entry> EntryFinder::find(const BoxKey& box) {
    const Key key = to_key(box);
    if (!in_range(key))
        return std::nullopt;
    const auto entries = leaf_at(key);
    if (!entries)
        return std::nullopt;
    const auto found =
        std::lower_bound(entries->begin(), entries->end(), key,
                         [](const Entry& e, const Key& k) { return before(e.key, k); });
    if (found == entries->end() || to_key(found->key) != box)
        return std::nullopt;
    return *found;
}

}  // namespace terravox::voxel::archive
