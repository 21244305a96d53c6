#include "voxelserver/archive/merge.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/voxel/archive/coarse_levels.hpp"
#include "common/voxel/archive/shard.hpp"
#include "common/voxel/world_json.hpp"

namespace terravox::archive_tools {
namespace {

using voxel::archive::ArchiveIndex;
using voxel::archive::ByteSource;
using voxel::archive::Entry;
using voxel::archive::Header;
using voxel::archive::Kind;
using voxel::archive::Record;
using voxel::archive::Shard;

/// Bytes of a shard that are read at once. A record may be larger.
constexpr std::size_t kRead_bytes = std::size_t{4} << 20;

struct OpenShard {
    std::unique_ptr<ByteSource> source;
    std::unique_ptr<ArchiveIndex> index;
    Shard facts;

    /// Where its records end, and its index begins.
    [[nodiscard]] std::uint64_t records_end() const {
        std::uint64_t end = index->header().root_offset;
        for (const auto& leaf : index->leaves())
            end = std::min(end, leaf.offset);
        return end;
    }
    [[nodiscard]] std::uint64_t records_begin() const {
        return index->header().info_offset + index->header().info_bytes;
    }
};

OpenShard open_shard(const std::filesystem::path& file) {
    OpenShard out;
    out.source = voxel::archive::file_source(file);
    out.index = std::make_unique<ArchiveIndex>(*out.source, ArchiveIndex::Of::kArchiveOrShard);
    if (!out.index->is_shard())
        throw util::UsageError("merge " + file.string() +
                               ": a whole archive; allowed: shards, of convert --shard I/N");
    out.facts = voxel::archive::read_shard(*out.source, *out.index);
    return out;
}

std::string name_of(const OpenShard& shard) {
    return "shard " + std::to_string(shard.facts.number) + " of " + std::to_string(shard.facts.of);
}

/// Sorts them, and checks that they are all shards of one conversion.
void check_complete(std::vector<OpenShard>& shards) {
    std::sort(shards.begin(), shards.end(), [](const OpenShard& a, const OpenShard& b) {
        return a.facts.number < b.facts.number;
    });
    const OpenShard& first = shards.front();
    for (const OpenShard& shard : shards) {
        if (shard.facts.job != first.facts.job || shard.facts.of != first.facts.of ||
            voxel::world_to_json(shard.index->info()) != voxel::world_to_json(first.index->info()))
            throw util::UsageError("merge " + shard.source->name() + ": " + name_of(shard) +
                                   " is of another conversion than " + first.source->name() +
                                   "; allowed: the same data, options and version");
    }
    for (std::size_t i = 0; i < shards.size(); ++i) {
        const int wanted = static_cast<int>(i) + 1;
        if (shards[i].facts.number < wanted)
            throw util::UsageError("merge " + shards[i].source->name() + ": " + name_of(shards[i]) +
                                   " is there twice; allowed: each once");
        if (shards[i].facts.number > wanted)
            throw util::UsageError("merge: shard " + std::to_string(wanted) + " of " +
                                   std::to_string(first.facts.of) + " is missing");
    }
    if (const int have = static_cast<int>(shards.size()); have < first.facts.of)
        throw util::UsageError("merge: shard " + std::to_string(have + 1) + " of " +
                               std::to_string(first.facts.of) + " is missing");
}

/// The records of a shard, one after the other.
class Records {
public:
    Records(const OpenShard& shard)
        : m_shard(shard), m_at(shard.records_begin()), m_end(shard.records_end()) {}
    [[nodiscard]] bool at_end() const noexcept { return m_at == m_end; }
    [[nodiscard]] std::uint64_t at() const noexcept { return m_at; }
    /// @param frame valid until the next call
    Record next(std::span<const std::byte>& frame) {
        Record record{};
        const auto head = take(sizeof record);
        std::memcpy(&record, head.data(), sizeof record);
        if (!voxel::archive::in_range(record.key) ||
            record.key.level > voxel::archive::kSubtreeLevel)
            throw damaged();
        frame = take(record.bytes);
        if (record.checksum != XXH64(frame.data(), frame.size(), 0))
            throw damaged();
        return record;
    }

private:
    [[nodiscard]] util::Error damaged() const {
        return util::Error("merge " + m_shard.source->name() + ": it is damaged at byte " +
                           std::to_string(m_at));
    }
    std::span<const std::byte> take(std::size_t bytes) {
        if (bytes > m_end - m_at)
            throw damaged();
        if (m_at < m_read_at || m_at + bytes > m_read_at + m_read.size()) {
            const std::size_t wanted =
                std::min<std::uint64_t>(std::max(bytes, kRead_bytes), m_end - m_at);
            m_read = m_shard.source->read(m_at, wanted, m_room);
            m_read_at = m_at;
        }
        const auto out = m_read.subspan(static_cast<std::size_t>(m_at - m_read_at), bytes);
        m_at += bytes;
        return out;
    }

    const OpenShard& m_shard;
    std::uint64_t m_at;
    const std::uint64_t m_end;
    std::vector<std::byte> m_room;
    std::span<const std::byte> m_read;
    std::uint64_t m_read_at = 0;
};

}  // namespace

MergeReport merge(std::span<const std::filesystem::path> files, const std::filesystem::path& out,
                  int threads, const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    std::vector<OpenShard> shards;
    std::uint64_t total = 0;
    for (const auto& file : files) {
        shards.push_back(open_shard(file));
        total += shards.back().records_end() - shards.back().records_begin();
    }
    if (shards.empty())
        throw util::UsageError("merge: no shard; allowed: all of one conversion");
    check_complete(shards);
    const voxel::WorldInfo& info = shards.front().index->info();
    voxel::ArchiveWriter writer(out, info, 0);
    std::set<std::string> damage;
    std::uint64_t done = 0;
    for (const OpenShard& shard : shards) {
        damage.insert(shard.facts.damage.begin(), shard.facts.damage.end());
        Records records(shard);
        while (!records.at_end()) {
            std::span<const std::byte> frame;
            const Record record = records.next(frame);
            writer.add(voxel::archive::key_of(record.key), record.kind, frame);
            done += sizeof record + frame.size();
            if (progress)
                progress(done, total);
        }
    }
    const int below = std::min(voxel::archive::kSubtreeLevel, info.levels - 1);
    voxel::archive::add_levels_above(writer, below, info.levels, threads);
    MergeReport report;
    for (const Entry& entry : writer.entries()) {
        ++report.records;
        report.holes += entry.kind == Kind::kHole ? 1 : 0;
    }
    writer.finish(damage.size());
    return report;
}

}  // namespace terravox::archive_tools
