#include "voxelserver/out/archive/index_walk.hpp"

#include <string>

#include "common/util/error.hpp"
#include "common/voxel/archive/change.hpp"
#include "common/voxel/archive/shard.hpp"
#include "common/voxel/changed_error.hpp"

namespace terravox::archive_tools {
namespace {

using voxel::archive::ArchiveIndex;
using voxel::archive::ByteSource;
using voxel::archive::Entry;
using voxel::archive::FileKind;

/// Reads the end of a shard or a change. @return its bytes
std::uint64_t read_end(ByteSource& source, const ArchiveIndex& index, Verification& out) {
    try {
        if (index.kind() == FileKind::kShard)
            (void)voxel::archive::read_shard(source, index);
        else
            (void)voxel::archive::read_change(source, index);
    } catch (const voxel::ChangedError&) {
        throw;
    } catch (const util::Error& e) {
        out.note(e.what());
    }
    const auto& header = index.header();
    return header.file_bytes - header.root_offset - header.root_bytes;
}

}  // namespace

WalkedIndex walk_index(
    const ArchiveIndex& index, Verification& out,
    const std::function<void(std::size_t leaf, const std::vector<Entry>&)>& visit) {
    WalkedIndex walked;
    for (std::size_t leaf = 0; leaf < index.leaves().size(); ++leaf) {
        std::vector<Entry> entries;
        try {
            entries = index.entries(leaf);
        } catch (const voxel::ChangedError&) {
            throw;
        } catch (const util::Error& e) {
            out.note(e.what());
            walked.is_readable = false;
            continue;
        }
        walked.records += entries.size();
        walked.bytes += index.leaves()[leaf].bytes;
        for (const Entry& entry : entries)
            walked.bytes += sizeof(voxel::archive::Record) + entry.bytes;
        visit(leaf, entries);
    }
    return walked;
}

void check_size(ByteSource& source, const ArchiveIndex& index, const WalkedIndex& walked,
                std::uint64_t file_bytes, Verification& out) {
    const auto& header = index.header();
    if (file_bytes != header.file_bytes)
        out.note("the file has " + std::to_string(file_bytes) + " bytes; its header says " +
                 std::to_string(header.file_bytes));
    std::uint64_t named = sizeof header + header.info_bytes + walked.bytes + header.root_bytes;
    if (index.kind() != FileKind::kArchive)
        named += read_end(source, index, out);
    if (walked.is_readable && named != header.file_bytes)
        out.note("its parts have " + std::to_string(named) + " bytes in all; its header says " +
                 std::to_string(header.file_bytes));
}

}  // namespace terravox::archive_tools
