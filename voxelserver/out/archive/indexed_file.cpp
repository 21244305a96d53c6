#include "voxelserver/out/archive/indexed_file.hpp"

#include <xxhash.h>
#include <cstring>
#include <span>
#include <string>

#include "common/util/error.hpp"
#include "common/voxel/box.hpp"

namespace terravox::archive_tools {
namespace {

using voxel::archive::ByteSource;
using voxel::archive::Entry;
using voxel::archive::Record;

/// Bytes that are read at once, and one record more: so few stay in a processor's cache until they
/// are used.
constexpr std::size_t kRead_bytes = std::size_t{1} << 20;

std::uint64_t find_begin(const Entry& entry) {
    return entry.offset - sizeof(Record);
}

std::uint64_t find_end(const Entry& entry) {
    return entry.offset + entry.bytes;
}

/// One after the last of the entries that follow the first in the file, without gaps.
std::size_t end_of_run(std::span<const Entry> entries, std::size_t first) {
    std::size_t end = first + 1;
    while (end < entries.size() && find_begin(entries[end]) == find_end(entries[end - 1]) &&
           find_end(entries[end - 1]) - find_begin(entries[first]) < kRead_bytes)
        ++end;
    return end;
}

}  // namespace

std::optional<std::string> find_problem(const Record& record, const Entry& entry,
                                        std::span<const std::byte> frame) {
    const voxel::BoxKey key = voxel::archive::to_key(entry.key);
    if (voxel::archive::to_key(record.key) != key || record.bytes != entry.bytes ||
        record.kind != entry.kind)
        return "box " + voxel::to_string(key) + ": its record is that of another box";
    if (record.checksum != XXH64(frame.data(), frame.size(), 0))
        return "box " + voxel::to_string(key) + " is damaged";
    return std::nullopt;
}

void visit_records(ByteSource& source, std::span<const Entry> entries, const VisitRecord& visit) {
    std::vector<std::byte> room;
    for (std::size_t first = 0; first < entries.size();) {
        if (entries[first].offset < sizeof(Record))
            throw util::Error("read " + source.name() + ": box " +
                              voxel::to_string(voxel::archive::to_key(entries[first].key)) +
                              " lies before the first record");
        const std::size_t end = end_of_run(entries, first);
        const std::uint64_t at = find_begin(entries[first]);
        const auto bytes =
            source.read(at, static_cast<std::size_t>(find_end(entries[end - 1]) - at), room);
        for (; first < end; ++first) {
            const auto offset = static_cast<std::size_t>(entries[first].offset - at);
            Record record{};
            std::memcpy(&record, bytes.data() + offset - sizeof record, sizeof record);
            visit(entries[first], record, bytes.subspan(offset, entries[first].bytes));
        }
    }
}

void read_records(ByteSource& source, std::span<const Entry> entries, const char* attempt,
                  const UseRecord& use) {
    visit_records(
        source, entries,
        [&](const Entry& entry, const Record& record, std::span<const std::byte> frame) {
            if (const auto problem = find_problem(record, entry, frame))
                throw util::Error(std::string(attempt) + " " + source.name() + ": " + *problem);
            use(entry, frame);
        });
}

std::vector<Entry> all_entries(const voxel::archive::ArchiveIndex& index) {
    std::vector<Entry> out;
    index.each_entry([&](const Entry& entry) { out.push_back(entry); });
    return out;
}

using voxel::archive::MadeBox;
using voxel::archive::MadeRecord;

IndexedFile::IndexedFile(const std::filesystem::path& file, voxel::archive::ArchiveIndex::Of of)
    : m_source(voxel::archive::file_source(file)),
      m_index(std::make_unique<voxel::archive::ArchiveIndex>(*m_source, of)),
      m_finder(std::make_unique<voxel::archive::EntryFinder>(*m_index)) {}

MadeRecord IndexedFile::record(const voxel::archive::Entry& entry) const {
    MadeRecord out{voxel::archive::to_key(entry.key), entry.kind, {}};
    read_records(*m_source, std::span(&entry, 1), "read",
                 [&](const voxel::archive::Entry&, std::span<const std::byte> frame) {
                     out.frame.assign(frame.begin(), frame.end());
                 });
    return out;
}

MadeBox IndexedFile::box(const voxel::archive::Entry& entry) const {
    const MadeRecord made = record(entry);
    const std::string name = m_source->name() + " box " + voxel::to_string(made.key);
    if (made.kind == voxel::archive::Kind::kHole)
        return {nullptr,
                std::string(reinterpret_cast<const char*>(made.frame.data()), made.frame.size())};
    return {voxel::decompress_box(made.frame, name), std::nullopt};
}

}  // namespace terravox::archive_tools
