#include <algorithm>
#include <string>
#include <vector>

#include "common/thread/in_order.hpp"
#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/out/archive/indexed_file.hpp"
#include "voxelserver/out/archive/verify.hpp"

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
std::vector<std::size_t> make_batches(const std::vector<Entry>& entries, std::uint64_t batch) {
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
            if (const auto problem = find_problem(record, entry, frame))
                out.push_back(*problem);
        });
    } catch (const voxel::ChangedError&) {
        throw;
    } catch (const util::Error& e) {
        out.emplace_back(e.what());
    }
    return out;
}

class StoredVerifier {
public:
    StoredVerifier(voxel::archive::ByteSource& source, const ArchiveIndex& index, int threads,
                   const VerifyProgress& progress)
        : m_source(source), m_index(index), m_threads(threads), m_progress(progress) {
        for (const voxel::archive::Leaf& leaf : index.leaves())
            m_total += leaf.entries;
    }

    /// @param stretch of the index that is in memory at a time, in entries
    Verification run(std::uint64_t file_bytes, std::size_t stretch) {
        std::vector<Entry> entries;
        const WalkedIndex walked =
            walk_index(m_index, m_out, [&](std::size_t, const std::vector<Entry>& some) {
                entries.insert(entries.end(), some.begin(), some.end());
                if (entries.size() >= stretch)
                    verify(entries);
            });
        verify(entries);
        check_size(m_source, m_index, walked, file_bytes, m_out);
        return std::move(m_out);
    }

private:
    /// Leaves no entries.
    void verify(std::vector<Entry>& entries) {
        for (const Entry& entry : entries)
            ++(entry.kind == voxel::archive::Kind::kHole ? m_out.holes : m_out.boxes);
        // In the order of the file: a disk reads that fastest.
        std::sort(entries.begin(), entries.end(),
                  [](const Entry& a, const Entry& b) { return a.offset < b.offset; });
        const std::vector<std::size_t> ends =
            make_batches(entries, batch_bytes(entries, thread::thread_count(m_threads)));
        thread::in_order(
            ends.size(), m_threads,
            [&](std::size_t i) {
                const std::size_t begin = i == 0 ? 0 : ends[i - 1];
                return problems_in(m_source, std::span(entries).subspan(begin, ends[i] - begin));
            },
            [&](std::size_t i, const std::vector<std::string>& problems) {
                for (const std::string& problem : problems)
                    m_out.note(problem);
                if (m_progress)
                    m_progress(m_done + ends[i], m_total);
            });
        m_done += entries.size();
        entries.clear();
    }

    voxel::archive::ByteSource& m_source;
    const ArchiveIndex& m_index;
    const int m_threads;
    const VerifyProgress& m_progress;
    Verification m_out;
    std::uint64_t m_total = 0;
    std::uint64_t m_done = 0;
};

}  // namespace

Verification verify_stored(const ArchiveFiles& archive, int threads,
                           const VerifyProgress& progress) {
    const auto source = archive.open();
    return verify_open(*source, archive.bytes(), threads, progress);
}

Verification verify_open(voxel::archive::ByteSource& source, std::uint64_t bytes, int threads,
                         const VerifyProgress& progress, std::size_t stretch) {
    const ArchiveIndex index(source, ArchiveIndex::Of::kAnyFile);
    return StoredVerifier(source, index, threads, progress).run(bytes, stretch);
}

}  // namespace terravox::archive_tools
