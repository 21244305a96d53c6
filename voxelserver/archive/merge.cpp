#include "voxelserver/archive/merge.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <utility>
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
using voxel::archive::Kind;
using voxel::archive::kSubtreeLevel;
using voxel::archive::Record;
using voxel::archive::Shard;

/// Bytes of a shard that are read at once, and one record more.
constexpr std::size_t kRead_bytes = std::size_t{4} << 20;

struct OpenShard {
    std::unique_ptr<ByteSource> source;
    std::unique_ptr<ArchiveIndex> index;
    Shard facts;
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

/// The entries of a shard in the order of their records, which follow each other without gaps from
/// the facts on.
/// @throws Error where they do not
std::vector<Entry> entries_of(const OpenShard& shard) {
    std::vector<Entry> out;
    for (std::size_t leaf = 0; leaf < shard.index->leaves().size(); ++leaf) {
        const auto some = shard.index->entries(leaf);
        out.insert(out.end(), some.begin(), some.end());
    }
    std::sort(out.begin(), out.end(),
              [](const Entry& a, const Entry& b) { return a.offset < b.offset; });
    std::uint64_t at = shard.index->header().info_offset + shard.index->header().info_bytes;
    for (const Entry& entry : out) {
        if (entry.offset != at + sizeof(Record) || entry.key.level > kSubtreeLevel)
            throw util::Error("merge " + shard.source->name() + ": its index is damaged");
        at = entry.offset + entry.bytes;
    }
    return out;
}

/// Reads records that follow each other, many at a time.
class Records {
public:
    Records(const OpenShard& shard, const std::vector<Entry>& entries)
        : m_source(*shard.source), m_entries(entries) {}

    /// @return the frame of an entry, valid until the next call; entries are asked for in order
    /// @throws Error unless it is what the index says
    std::span<const std::byte> frame_of(std::size_t i) {
        const Entry& entry = m_entries[i];
        if (i >= m_read_end)
            read_from(i);
        const auto at = static_cast<std::size_t>(entry.offset - m_read_at);
        Record record{};
        std::memcpy(&record, m_read.data() + at - sizeof record, sizeof record);
        const auto frame = m_read.subspan(at, entry.bytes);
        if (voxel::archive::key_of(record.key) != voxel::archive::key_of(entry.key) ||
            record.bytes != entry.bytes || record.kind != entry.kind ||
            record.checksum != XXH64(frame.data(), frame.size(), 0))
            throw util::Error("merge " + m_source.name() + ": box " +
                              voxel::to_string(voxel::archive::key_of(entry.key)) + " is damaged");
        return frame;
    }

private:
    void read_from(std::size_t i) {
        m_read_at = m_entries[i].offset - sizeof(Record);
        std::uint64_t end = m_read_at;
        for (m_read_end = i; m_read_end < m_entries.size() && end - m_read_at < kRead_bytes;
             ++m_read_end)
            end = m_entries[m_read_end].offset + m_entries[m_read_end].bytes;
        m_read = m_source.read(m_read_at, static_cast<std::size_t>(end - m_read_at), m_room);
    }

    ByteSource& m_source;
    const std::vector<Entry>& m_entries;
    std::vector<std::byte> m_room;
    std::span<const std::byte> m_read;
    std::uint64_t m_read_at = 0;
    std::size_t m_read_end = 0;  ///< one after the last entry that was read
};

/// Removes what a merge that failed has written.
class Unfinished {
public:
    explicit Unfinished(std::filesystem::path file) : m_file(std::move(file)) {}
    ~Unfinished() {
        std::error_code ignored;
        std::filesystem::remove(m_file, ignored);
    }
    Unfinished(const Unfinished&) = delete;
    Unfinished& operator=(const Unfinished&) = delete;

private:
    const std::filesystem::path m_file;
};

}  // namespace

MergeReport merge(std::span<const std::filesystem::path> files, const std::filesystem::path& out,
                  int threads, const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    std::vector<OpenShard> shards;
    for (const auto& file : files) {
        std::error_code ignored;
        if (std::filesystem::equivalent(file, out, ignored))
            throw util::UsageError("merge to " + out.string() +
                                   ": it is one of the shards; allowed: another name");
        shards.push_back(open_shard(file));
    }
    if (shards.empty())
        throw util::UsageError("merge: no shard; allowed: all of one conversion");
    check_complete(shards);
    std::uint64_t total = 0;
    for (const OpenShard& shard : shards)
        total += shard.index->header().root_offset;
    const voxel::WorldInfo& info = shards.front().index->info();
    // Under the name that the writer gives to an unfinished file.
    const Unfinished unfinished(out.string() + ".part");
    voxel::ArchiveWriter writer(out, info, 0);
    std::set<std::string> damage;
    std::uint64_t done = 0;
    for (const OpenShard& shard : shards) {
        damage.insert(shard.facts.damage.begin(), shard.facts.damage.end());
        const std::vector<Entry> entries = entries_of(shard);
        Records records(shard, entries);
        for (std::size_t i = 0; i < entries.size(); ++i) {
            const auto frame = records.frame_of(i);
            writer.add(voxel::archive::key_of(entries[i].key), entries[i].kind, frame);
            if (progress)
                progress(done + entries[i].offset, total);
        }
        done += shard.index->header().root_offset;
    }
    const int below = std::min(kSubtreeLevel, info.levels - 1);
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
