#include "common/voxel/archive/archive_world.hpp"

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <optional>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/box_codec.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "common/voxel/world_json.hpp"

namespace terravox::voxel {
namespace {

using namespace archive;

constexpr std::uint64_t kMaxInfo_bytes = 4 << 20;
constexpr std::uint64_t kMaxRoot_bytes = std::uint64_t{256} << 20;
const std::uint64_t kMaxLeaf_bytes = ZSTD_compressBound(kLeafEntries * sizeof(Entry));
constexpr std::size_t kLeafCache_bytes = std::size_t{64} << 20;
// A box in which every voxel has attributes is 9 MiB uncompressed.
constexpr std::uint32_t kMaxFrame_bytes = 16 << 20;

class ArchiveWorld final : public World {
public:
    explicit ArchiveWorld(std::unique_ptr<ByteSource> source)
        : m_source(std::move(source)), m_leaves(kLeafCache_bytes) {
        const Header header = read_header();
        std::vector<std::byte> room;
        const auto text =
            m_source->read(header.info_offset, static_cast<std::size_t>(header.info_bytes), room);
        m_info = world_from_json(
            std::string(reinterpret_cast<const char*>(text.data()), text.size()), m_source->name());
        check_bounds();
        m_root = read_root(header);
    }

    [[nodiscard]] const WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        if (key.level < 0 || key.level >= m_info.levels)
            throw util::UsageError("read a box of " + m_source->name() + ": level " +
                                   std::to_string(key.level) + "; allowed: 0 to " +
                                   std::to_string(m_info.levels - 1));
        const auto entry = find(key);
        if (!entry)
            return nullptr;
        const std::string name = m_source->name() + " box " + to_string(key);
        std::vector<std::byte> room;
        const auto frame = m_source->read(entry->offset, entry->bytes, room);
        if (entry->kind == Kind::kHole)
            throw util::Error(
                "read " + name + ": it could not be read when the archive was made: " +
                std::string(reinterpret_cast<const char*>(frame.data()), frame.size()));
        auto box = decompress_box(frame, name);
        if (box->key() != key)
            throw util::Error("read " + name + ": the archive holds box " + to_string(box->key()) +
                              " there");
        return box;
    }

    [[nodiscard]] ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        if (m_info.bounds.empty() || level < 0 || level >= m_info.levels)
            return {};
        const BoxRange range = boxes_over(m_info.bounds, level);
        if (!range.contains({level, bx, range.min.by, bz}))
            return {};
        return {range.min.by, range.max.by};
    }

    [[nodiscard]] bool may_hold(const BoxRange& boxes) override {
        if (boxes.min.level < 0 || boxes.min.level >= m_info.levels)
            return false;
        constexpr std::int32_t kHalf = 1 << (kMaxUp - 1);
        for (const std::int32_t bx : {-kHalf, 0})
            for (const std::int32_t by : {-kHalf, 0})
                for (const std::int32_t bz : {-kHalf, 0})
                    if (names_any({{boxes.min.level, bx, by, bz}, kMaxUp - 1}, boxes))
                        return true;
        return false;
    }

    [[nodiscard]] std::vector<std::string> damage() const override {
        if (m_damage == 0)
            return {};
        return {m_source->name() + ": the data that it was made from were damaged in " +
                std::to_string(m_damage) + (m_damage == 1 ? " place" : " places")};
    }
    [[nodiscard]] std::string edition() const override { return m_source->edition(); }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        return m_source->useful_concurrency(threads);
    }
    void stop() noexcept override { m_source->stop(); }

private:
    using Entries = std::vector<Entry>;

    [[noreturn]] void fail(const std::string& what) const {
        throw util::Error("open the box archive " + m_source->name() + ": " + what);
    }

    [[nodiscard]] Header read_header() {
        Header header{};
        std::vector<std::byte> room;
        const auto bytes = m_source->read(0, sizeof header, room);
        std::memcpy(&header, bytes.data(), sizeof header);
        if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0)
            fail("not a box archive");
        if (header.version != kVersion)
            fail("version " + std::to_string(header.version) +
                 "; allowed: " + std::to_string(kVersion));
        if (header.checksum != XXH64(&header, offsetof(Header, checksum), 0))
            fail("its header is damaged");
        if (header.root_offset == 0)
            fail("it was never finished; convert again to go on");
        const auto inside = [&](std::uint64_t offset, std::uint64_t count) {
            return offset <= header.file_bytes && count <= header.file_bytes - offset;
        };
        if (header.info_bytes > kMaxInfo_bytes || header.root_bytes > kMaxRoot_bytes ||
            header.root_bytes < sizeof(std::uint64_t) ||
            (header.root_bytes - sizeof(std::uint64_t)) % sizeof(Leaf) != 0 ||
            !inside(header.info_offset, header.info_bytes) ||
            !inside(header.root_offset, header.root_bytes))
            fail("its header leads outside");
        m_file_bytes = header.file_bytes;
        m_damage = header.damage;
        return header;
    }

    // The cost of a picture of air is proportional to the number of boxes of the coarsest level, so
    // these must be large in relation to the world.
    void check_bounds() {
        if (m_info.bounds.empty())
            return;
        const BoxRange range = boxes_over(m_info.bounds, 0);
        const BoxKey last{0, range.max.bx - 1, range.max.by - 1, range.max.bz - 1};
        if (!in_range(key_of(range.min)) || !in_range(key_of(last)))
            fail("its bounds reach beyond 2^20 boxes from the origin");
        if (const int needed = levels_for(m_info.bounds); m_info.levels < needed)
            fail("levels = " + std::to_string(m_info.levels) +
                 "; bounds of this width need at least " + std::to_string(needed));
    }

    /// Whether the box lies in the world that the archive declares.
    [[nodiscard]] bool has_room_for(const Key& key) const {
        return in_range(key) && key.level < m_info.levels && !m_info.bounds.empty() &&
               boxes_over(m_info.bounds, key.level).contains(key_of(key));
    }

    [[nodiscard]] std::vector<Leaf> read_root(const Header& header) {
        std::vector<std::byte> room;
        const auto bytes =
            m_source->read(header.root_offset, static_cast<std::size_t>(header.root_bytes), room);
        const std::size_t payload = bytes.size() - sizeof(std::uint64_t);
        std::uint64_t checksum = 0;
        std::memcpy(&checksum, bytes.data() + payload, sizeof checksum);
        if (checksum != XXH64(bytes.data(), payload, 0))
            fail("its index is damaged");
        std::vector<Leaf> root(payload / sizeof(Leaf));
        if (payload != 0)
            std::memcpy(root.data(), bytes.data(), payload);
        for (std::size_t i = 0; i < root.size(); ++i) {
            const Leaf& leaf = root[i];
            if (leaf.entries == 0 || leaf.entries > kLeafEntries || leaf.offset > m_file_bytes ||
                leaf.bytes > m_file_bytes - leaf.offset || leaf.bytes > kMaxLeaf_bytes ||
                !in_range(leaf.first) || (i > 0 && !before(root[i - 1].first, leaf.first)))
                fail("its index is damaged");
            if (!has_room_for(leaf.first))
                fail("its index names box " + to_string(key_of(leaf.first)) +
                     ", which lies outside of its bounds");
        }
        return root;
    }

    [[nodiscard]] std::shared_ptr<const Entries> entries_of(std::size_t index) {
        return m_leaves.get(
            index,
            [&] {
                const Leaf& leaf = m_root[index];
                std::vector<std::byte> room;
                const auto frame = m_source->read(leaf.offset, leaf.bytes, room);
                const auto wrong = [&](const std::string& what) {
                    return util::Error("read the index of the box archive " + m_source->name() +
                                       ": leaf " + std::to_string(index) + what);
                };
                const auto damaged = [&] { return wrong(" is damaged"); };
                if (XXH64(frame.data(), frame.size(), 0) != leaf.checksum)
                    throw damaged();
                auto entries = std::make_shared<Entries>(leaf.entries);
                const std::size_t size = ZSTD_decompress(
                    entries->data(), entries->size() * sizeof(Entry), frame.data(), frame.size());
                if (size != entries->size() * sizeof(Entry))
                    throw damaged();
                if (!std::is_sorted(
                        entries->begin(), entries->end(),
                        [](const Entry& a, const Entry& b) { return before(a.key, b.key); }))
                    throw damaged();
                for (const Entry& e : *entries) {
                    if (e.offset > m_file_bytes ||
                        e.bytes > std::min<std::uint64_t>(kMaxFrame_bytes, m_file_bytes - e.offset))
                        throw damaged();
                    if (!has_room_for(e.key))
                        throw wrong(" names box " + to_string(key_of(e.key)) +
                                    ", which lies outside of its bounds");
                }
                return std::shared_ptr<const Entries>(std::move(entries));
            },
            [](const auto& made) { return made->size() * sizeof(Entry); });
    }

    [[nodiscard]] std::optional<Entry> find(const BoxKey& box) {
        const Key key = key_of(box);
        if (!in_range(key))
            return std::nullopt;
        const auto after =
            std::upper_bound(m_root.begin(), m_root.end(), key,
                             [](const Key& k, const Leaf& leaf) { return before(k, leaf.first); });
        if (after == m_root.begin())
            return std::nullopt;
        const auto entries = entries_of(static_cast<std::size_t>(after - m_root.begin()) - 1);
        const auto found =
            std::lower_bound(entries->begin(), entries->end(), key,
                             [](const Entry& e, const Key& k) { return before(e.key, k); });
        if (found == entries->end() || key_of(found->key) != box)
            return std::nullopt;
        return *found;
    }

    static constexpr int kMaxUp = 21;  ///< 2^21 boxes: the range of the index

    /// 2^up boxes along each axis, from a box whose coordinates are multiples of that: a contiguous
    /// range of the Morton curve.
    struct Cube {
        Key low;
        int up;
    };

    /// Whether the index contains a box of the cube.
    [[nodiscard]] bool names_any(const Cube& cube) {
        const std::uint64_t first = morton_encode(cube.low.bx, cube.low.by, cube.low.bz);
        const std::uint64_t count = std::uint64_t{1} << 3 * cube.up;
        const auto within = [&](const Key& k) {
            return k.level == cube.low.level && morton_encode(k.bx, k.by, k.bz) - first < count;
        };
        const auto after =
            std::upper_bound(m_root.begin(), m_root.end(), cube.low,
                             [](const Key& k, const Leaf& leaf) { return before(k, leaf.first); });
        if (after != m_root.end() && within(after->first))
            return true;
        if (after == m_root.begin())
            return false;
        const auto entries = entries_of(static_cast<std::size_t>(after - m_root.begin()) - 1);
        const auto found =
            std::lower_bound(entries->begin(), entries->end(), cube.low,
                             [](const Entry& e, const Key& k) { return before(e.key, k); });
        return found != entries->end() && within(found->key);
    }

    /// Whether the index contains a box that lies both in the cube and in the range. Descends only
    /// into cubes of which it contains boxes.
    [[nodiscard]] bool names_any(const Cube& cube, const BoxRange& range) {
        const std::int32_t size = std::int32_t{1} << cube.up;
        bool inside = true;
        for (const auto [low, min, max] : {std::array{cube.low.bx, range.min.bx, range.max.bx},
                                           std::array{cube.low.by, range.min.by, range.max.by},
                                           std::array{cube.low.bz, range.min.bz, range.max.bz}}) {
            if (low >= max || low + size <= min)
                return false;
            inside = inside && low >= min && low + size <= max;
        }
        if (!names_any(cube))
            return false;
        if (inside)
            return true;
        for (int i = 0; i < 8; ++i) {
            const Key& low = cube.low;
            const Cube child{{low.level, low.bx + (i & 1) * size / 2,
                              low.by + (i >> 1 & 1) * size / 2, low.bz + (i >> 2) * size / 2},
                             cube.up - 1};
            if (names_any(child, range))
                return true;
        }
        return false;
    }

    const std::unique_ptr<ByteSource> m_source;
    std::uint64_t m_file_bytes = 0;
    std::uint32_t m_damage = 0;
    WorldInfo m_info;
    std::vector<Leaf> m_root;
    util::Cache<std::size_t, Entries> m_leaves;
};

}  // namespace

std::unique_ptr<World> open_archive(std::unique_ptr<ByteSource> source) {
    return std::make_unique<ArchiveWorld>(std::move(source));
}

bool is_archive(const std::filesystem::path& file) {
    std::array<char, sizeof kMagic> magic{};
    std::ifstream in(file, std::ios::binary);
    return in.read(magic.data(), magic.size()) && std::equal(magic.begin(), magic.end(), kMagic);
}

}  // namespace terravox::voxel
