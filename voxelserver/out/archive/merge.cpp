#include "voxelserver/out/archive/merge.hpp"

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_parts.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/archive/coarse_levels.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/out/archive/indexed_file.hpp"

namespace terravox::archive_tools {
namespace {

using voxel::archive::ArchiveIndex;
using voxel::archive::ByteSource;
using voxel::archive::Entry;
using voxel::archive::Kind;
using voxel::archive::kSubtreeLevel;
using voxel::archive::Record;
using voxel::archive::Shard;

struct OpenShard {
    std::unique_ptr<ByteSource> source;
    std::unique_ptr<ArchiveIndex> index;
    Shard facts;
};

OpenShard open_shard(const std::filesystem::path& file) {
    OpenShard out;
    out.source = voxel::archive::file_source(file);
    out.index = std::make_unique<ArchiveIndex>(*out.source, ArchiveIndex::Of::kAnyFile);
    if (out.index->kind() != voxel::archive::FileKind::kShard)
        throw util::UsageError("merge " + file.string() +
                               ": not a shard; allowed: shards, of convert --shard I/N");
    out.facts = voxel::archive::read_shard(*out.source, *out.index);
    return out;
}

/// What is known of a shard while it is not open: thousands of them may be merged, and a process
/// has fewer descriptors.
struct ClosedShard {
    std::filesystem::path file;
    Shard facts;
    std::string world;  ///< JSON
    std::uint64_t end_of_records = 0;
};

ClosedShard look_at(const std::filesystem::path& file) {
    const OpenShard shard = open_shard(file);
    return {file, shard.facts, voxel::world_to_json(shard.index->info()),
            shard.index->header().root_offset};
}

std::string to_name(const ClosedShard& shard) {
    return "shard " + std::to_string(shard.facts.number) + " of " + std::to_string(shard.facts.of);
}

/// @throws Error when the file is no longer the one that was looked at
OpenShard open_again(const ClosedShard& shard) {
    OpenShard out = open_shard(shard.file);
    if (out.facts.job != shard.facts.job || out.facts.number != shard.facts.number ||
        out.facts.of != shard.facts.of || voxel::world_to_json(out.index->info()) != shard.world)
        throw util::Error("merge " + shard.file.string() + ": it was changed meanwhile");
    return out;
}

/// Sorts them, and checks that they are all shards of one conversion.
void check_complete(std::vector<ClosedShard>& shards) {
    std::sort(shards.begin(), shards.end(), [](const ClosedShard& a, const ClosedShard& b) {
        return a.facts.number < b.facts.number;
    });
    const ClosedShard& first = shards.front();
    for (const ClosedShard& shard : shards) {
        if (shard.facts.job != first.facts.job || shard.facts.of != first.facts.of ||
            shard.world != first.world)
            throw util::UsageError("merge " + shard.file.string() + ": " + to_name(shard) +
                                   " is of another conversion than " + first.file.string() +
                                   "; allowed: the same data, options and version");
    }
    for (std::size_t i = 0; i < shards.size(); ++i) {
        const int wanted = static_cast<int>(i) + 1;
        if (shards[i].facts.number < wanted)
            throw util::UsageError("merge " + shards[i].file.string() + ": " + to_name(shards[i]) +
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
std::vector<Entry> collect_entries(const OpenShard& shard) {
    std::vector<Entry> out = all_entries(*shard.index);
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

}  // namespace

MergeReport merge(std::span<const std::filesystem::path> files, const std::filesystem::path& out,
                  int threads, const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    std::vector<ClosedShard> shards;
    for (const auto& file : files) {
        std::error_code ignored;
        if (std::filesystem::equivalent(file, out, ignored))
            throw util::UsageError("merge to " + out.string() +
                                   ": it is one of the shards; allowed: another name");
        shards.push_back(look_at(file));
    }
    if (shards.empty())
        throw util::UsageError("merge: no shard; allowed: all of one conversion");
    check_complete(shards);
    std::uint64_t total = 0;
    for (const ClosedShard& shard : shards)
        total += shard.end_of_records;
    const voxel::WorldInfo info = open_again(shards.front()).index->info();
    voxel::ArchiveWriter writer(out, info, 0);
    voxel::archive::Unfinished unfinished(writer);
    std::set<std::string> damage;
    std::uint64_t done = 0;
    for (const ClosedShard& closed : shards) {
        const OpenShard shard = open_again(closed);
        damage.insert(shard.facts.damage.begin(), shard.facts.damage.end());
        read_records(*shard.source, collect_entries(shard), "merge",
                     [&](const Entry& entry, std::span<const std::byte> frame) {
                         writer.add(voxel::archive::to_key(entry.key), entry.kind, frame);
                         if (progress)
                             progress(done + entry.offset, total);
                     });
        done += shard.index->header().root_offset;
    }
    const int below = std::min(kSubtreeLevel, info.levels - 1);
    voxel::archive::add_levels_above(writer, below, info.levels, threads);
    MergeReport report;
    report.records = writer.entries();
    report.holes = writer.holes();
    writer.finish(damage.size());
    unfinished.release();
    return report;
}

}  // namespace terravox::archive_tools
