#include "common/voxel/archive/archive_writer.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel {
namespace {

using namespace archive;

constexpr std::size_t kWaiting_bytes = 1 << 20;

template <class T>
std::span<const std::byte> to_bytes(const T& value) {
    return std::as_bytes(std::span(&value, 1));
}

std::filesystem::path make_part(std::filesystem::path file) {
    file += ".part";
    return file;
}

}  // namespace

ArchiveWriter::ArchiveWriter(const std::filesystem::path& file, const WorldInfo& info,
                             std::uint64_t keep)
    : m_file(util::follow_links(file)), m_part(make_part(m_file)), m_entries(m_file) {
    util::check_writable(file);
    bool is_begun_anew = false;
    try {
        open();
        if (keep == 0) {
            if (::ftruncate(m_fd, 0) != 0)
                fail(std::strerror(errno));
            is_begun_anew = true;
        }
        begin(world_to_json(info));
        if (keep != 0)
            take_over(keep);
    } catch (...) {
        // Without its head a file is of no use; it is removed while it is still locked.
        if (is_begun_anew)
            ::unlink(m_part.c_str());
        // No destructor runs, and the lock must end.
        if (m_fd >= 0)
            ::close(m_fd);
        throw;
    }
}

ArchiveWriter::~ArchiveWriter() {
    if (m_fd >= 0)
        ::close(m_fd);
}

void ArchiveWriter::fail(const char* what) const {
    throw util::Error("write the box archive {}: {}", m_file.string(), what);
}

// Two writers of one file would corrupt it, so each locks it. One that finishes while another opens
// the file renames it: the other one then has a lock on a finished archive, and opens again.
void ArchiveWriter::open() {
    do {
        if (m_fd >= 0)
            ::close(std::exchange(m_fd, -1));
        m_fd = util::open_to_write(m_part, O_RDWR | O_CREAT, 0644,
                                   "write the box archive " + m_file.string());
        struct flock lock{};
        lock.l_type = F_WRLCK;
        lock.l_whence = SEEK_SET;
        if (::fcntl(m_fd, F_OFD_SETLK, &lock) != 0 && (errno == EAGAIN || errno == EACCES))
            fail("another process writes it");
        // File systems without locks: the journal of a conversion has one of its own.
    } while (!util::is_named(m_fd, m_part));
}

// Must give the same bytes as those in the file when an archive is continued.
void ArchiveWriter::begin(const std::string& info) {
    std::copy(std::begin(kMagic), std::end(kMagic), m_header.magic);
    m_header.version = kVersion;
    m_header.info_offset = sizeof(Header);
    m_header.info_bytes = info.size();
    m_header.checksum = XXH64(&m_header, offsetof(Header, checksum), 0);
    write(to_bytes(m_header));
    write(std::as_bytes(std::span(info)));
    flush();
}

void ArchiveWriter::take_over(std::uint64_t keep) {
    while (m_at < keep) {
        Record record{};
        if (::pread(m_fd, &record, sizeof record, static_cast<off_t>(m_at)) !=
            static_cast<ssize_t>(sizeof record))
            fail("the records to keep are missing");
        Entry entry{record.key, m_at + sizeof record, record.bytes, record.kind};
        if (!in_range(record.key) || entry.offset + entry.bytes > keep)
            fail("the records to keep are damaged");
        const auto frame = make_frame(entry);
        if (XXH64(frame.data(), frame.size(), 0) != record.checksum)
            fail("the records to keep are damaged");
        note(entry);
        m_at = entry.offset + entry.bytes;
    }
    if (::ftruncate(m_fd, static_cast<off_t>(m_at)) != 0)
        fail(std::strerror(errno));
}

void ArchiveWriter::note(const Entry& entry) {
    m_entries.add(entry);
    if (entry.key.level >= kSubtreeLevel)
        m_coarse.push_back(entry);
    m_holes += entry.kind == Kind::kHole ? 1 : 0;
}

void ArchiveWriter::write(std::span<const std::byte> bytes) {
    m_waiting.insert(m_waiting.end(), bytes.begin(), bytes.end());
    m_at += bytes.size();
    if (m_waiting.size() >= kWaiting_bytes)
        flush();
}

void ArchiveWriter::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::pwrite(m_fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            fail(n == 0 ? "disk full" : std::strerror(errno));
        offset += static_cast<std::uint64_t>(n);
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
}

std::uint64_t ArchiveWriter::flush() {
    write_at(m_at - m_waiting.size(), m_waiting);
    m_waiting.clear();
    return m_at;
}

void ArchiveWriter::add(const BoxKey& key, Kind kind, std::span<const std::byte> frame) {
    if (!in_range(to_key(key)))
        throw util::Error(
            "write the box archive {}: box {}; allowed: up to 2^20 boxes from the origin",
            m_file.string(), to_string(key));
    const Record record{to_key(key), static_cast<std::uint32_t>(frame.size()), kind,
                        XXH64(frame.data(), frame.size(), 0)};
    write(to_bytes(record));
    note({record.key, m_at, record.bytes, kind});
    write(frame);
}

std::vector<std::byte> ArchiveWriter::make_frame(const Entry& entry) const {
    std::vector<std::byte> frame(entry.bytes);
    if (::pread(m_fd, frame.data(), frame.size(), static_cast<off_t>(entry.offset)) !=
        static_cast<ssize_t>(frame.size()))
        fail("what was written cannot be read back");
    return frame;
}

void ArchiveWriter::finish(std::size_t damage) {
    write_index();
    close(damage);
}

void ArchiveWriter::finish_shard(const std::string& facts) {
    finish_with_end(kShardMagic, facts);
}

void ArchiveWriter::finish_change(const std::string& facts) {
    finish_with_end(kChangeMagic, facts);
}

void ArchiveWriter::finish_with_end(const char (&magic)[8], const std::string& facts) {
    write_index();
    write(std::as_bytes(std::span(facts)));
    write(to_bytes(XXH64(facts.data(), facts.size(), 0)));
    std::copy(std::begin(magic), std::end(magic), m_header.magic);
    close(0);
}

void ArchiveWriter::write_index() {
    std::vector<Leaf> root;
    std::vector<std::byte> frame(ZSTD_compressBound(kLeafEntries * sizeof(Entry)));
    std::vector<Entry> leaf;
    const auto write_leaf = [&] {
        constexpr int kLeafLevel = 9;
        const std::size_t size = ZSTD_compress(frame.data(), frame.size(), leaf.data(),
                                               leaf.size() * sizeof(Entry), kLeafLevel);
        if (ZSTD_isError(size) != 0)
            fail(ZSTD_getErrorName(size));
        root.push_back({leaf.front().key, m_at, static_cast<std::uint32_t>(size),
                        static_cast<std::uint32_t>(leaf.size()), XXH64(frame.data(), size, 0)});
        write(std::span(frame).first(size));
        leaf.clear();
    };
    m_entries.each_sorted([&](const Entry& entry) {
        leaf.push_back(entry);
        if (leaf.size() == kLeafEntries)
            write_leaf();
    });
    if (!leaf.empty())
        write_leaf();
    m_header.root_offset = m_at;
    const auto root_bytes = std::as_bytes(std::span(root));
    write(root_bytes);
    const std::uint64_t checksum = XXH64(root_bytes.data(), root_bytes.size(), 0);
    write(to_bytes(checksum));
    m_header.root_bytes = root_bytes.size() + sizeof checksum;
}

void ArchiveWriter::close(std::size_t damage) {
    m_header.damage = static_cast<std::uint32_t>(damage);
    m_header.file_bytes = flush();
    m_header.checksum = XXH64(&m_header, offsetof(Header, checksum), 0);
    write_at(0, to_bytes(m_header));
    if (::fsync(m_fd) != 0 || ::close(std::exchange(m_fd, -1)) != 0)
        fail(std::strerror(errno));
    util::rename_durably(m_part, m_file);
}

}  // namespace terravox::voxel
