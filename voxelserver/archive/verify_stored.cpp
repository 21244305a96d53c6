#include <algorithm>
#include <string>
#include <vector>

#include "common/thread/in_order.hpp"
#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/voxel/changed_error.hpp"
#include "voxelserver/archive/index_walk.hpp"
#include "voxelserver/archive/records.hpp"
#include "voxelserver/archive/verify.hpp"

namespace terravox::archive_tools {
namespace {

using voxel::archive::ArchiveIndex;
using voxel::archive::Entry;

/// Bytes of records that one thread checks before it takes others: several readings, which all use
/// the memory of the first.
constexpr std::uint64_t kBatch_bytes = 16 << 20;
/// In an archive of little more than that all threads have some.
constexpr std::uint64_t kLeastBatch_bytes = 2 << 20;

std::uint64_t batch_bytes(const std::vector<Entry>& entries, int threads) {
    std::uint64_t all = 0;
    for (const Entry& entry : entries)
        all += entry.bytes;
    constexpr std::uint64_t kOfEach = 4;
    return std::clamp(all / (kOfEach * static_cast<std::uint64_t>(threads)), kLeastBatch_bytes,
                      kBatch_bytes);
}

/// One after the last entry of each batch.
std::vector<std::size_t> batches_of(const std::vector<Entry>& entries, std::uint64_t batch) {
    std::vector<std::size_t> out;
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        bytes += entries[i].bytes;
        if (bytes < batch && i + 1 < entries.size())
            continue;
        out.push_back(i + 1);
        bytes = 0;
    }
    return out;
}

/// The problems of some records.
std::vector<std::string> problems_in(voxel::archive::ByteSource& source,
                                     std::span<const Entry> entries) {
    std::vector<std::string> out;
    try {
        visit_records(source, entries, [&](const Entry& entry, const auto& record, auto frame) {
            if (const auto problem = problem_of(record, entry, frame))
                out.push_back(*problem);
        });
    } catch (const voxel::ChangedError&) {
        throw;
    } catch (const util::Error& e) {
        out.emplace_back(e.what());
    }
    return out;
}

}  // namespace

Verification verify_stored(const ArchiveFiles& archive, int threads,
                           const VerifyProgress& progress) {
    const auto source = archive.open();
    return verify_open(*source, archive.bytes(), threads, progress);
}

Verification verify_open(voxel::archive::ByteSource& source, std::uint64_t bytes, int threads,
                         const VerifyProgress& progress) {
    const ArchiveIndex index(source, ArchiveIndex::Of::kAnyFile);
    Verification out;
    std::vector<Entry> entries;
    const WalkedIndex walked =
        walk_index(index, out, [&](std::size_t, const std::vector<Entry>& some) {
            entries.insert(entries.end(), some.begin(), some.end());
        });
    for (const Entry& entry : entries)
        ++(entry.kind == voxel::archive::Kind::kHole ? out.holes : out.boxes);
    // In the order of the file: a disk reads that fastest.
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.offset < b.offset; });
    const std::vector<std::size_t> ends =
        batches_of(entries, batch_bytes(entries, thread::thread_count(threads)));
    thread::in_order(
        ends.size(), threads,
        [&](std::size_t i) {
            const std::size_t begin = i == 0 ? 0 : ends[i - 1];
            return problems_in(source, std::span(entries).subspan(begin, ends[i] - begin));
        },
        [&](std::size_t i, const std::vector<std::string>& problems) {
            for (const std::string& problem : problems)
                out.note(problem);
            if (progress)
                progress(ends[i], walked.records);
        });
    check_size(source, index, walked, bytes, out);
    return out;
}

}  // namespace terravox::archive_tools
