#include "common/voxel/archive/archive_reader.hpp"

#include <algorithm>
#include <array>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/pyramid_world.hpp"

namespace terravox::voxel {
namespace {

using namespace archive;

class ArchiveWorld final : public World {
public:
    explicit ArchiveWorld(std::unique_ptr<ByteSource> source)
        : m_source(std::move(source)),
          m_index(*m_source),
          m_info(m_index.info()),
          m_root(m_index.leaves()),
          m_finder(m_index) {}

    [[nodiscard]] const WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        if (key.level < 0 || key.level >= m_info.levels)
            throw util::UsageError("read a box of {}: level {}; allowed: 0 to {}", m_source->name(),
                                   key.level, m_info.levels - 1);
        const auto entry = m_finder.find(key);
        if (!entry)
            return nullptr;
        const std::string name = m_source->name() + " box " + to_string(key);
        std::vector<std::byte> room;
        const auto frame = m_source->read(entry->offset, entry->bytes, room);
        if (entry->kind == Kind::kHole)
            throw util::Error(
                "read {}: it could not be read when the archive was made: {}", name,
                std::string(reinterpret_cast<const char*>(frame.data()), frame.size()));
        auto box = decompress_box(frame, name);
        if (box->key() != key)
            throw util::Error("read {}: the archive holds box {} there", name,
                              to_string(box->key()));
        return box;
    }

    [[nodiscard]] ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        if (level < 0 || level >= m_info.levels)
            return {};
        return column_of_bounds(m_info.bounds, level, bx, bz);
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
        const std::uint32_t count = m_index.header().damage;
        if (count == 0)
            return {};
        return {m_source->name() + ": the data that it was made from were damaged in " +
                std::to_string(count) + (count == 1 ? " place" : " places")};
    }
    [[nodiscard]] std::string edition() const override { return m_source->edition(); }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        return m_source->useful_concurrency(threads);
    }
    void stop() noexcept override { m_source->stop(); }

private:
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
        const auto entries = m_finder.leaf_at(cube.low);
        if (!entries)
            return false;
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
    const ArchiveIndex m_index;
    const WorldInfo& m_info;
    const std::span<const Leaf> m_root;
    EntryFinder m_finder;
};

}  // namespace

std::unique_ptr<World> open_archive(std::unique_ptr<ByteSource> source) {
    return std::make_unique<ArchiveWorld>(std::move(source));
}

bool is_archive(const std::filesystem::path& file) {
    const std::string magic = util::read_start(file, sizeof kMagic);
    const auto is = [&](const char (&known)[sizeof kMagic]) {
        return magic == std::string_view(known, sizeof known);
    };
    return is(kMagic) || is(kShardMagic) || is(kChangeMagic);
}

}  // namespace terravox::voxel
