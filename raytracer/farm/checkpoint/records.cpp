#include "raytracer/farm/checkpoint/records.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <optional>

#include "common/util/error.hpp"

namespace terravox::farm {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written as they lie in memory");

constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kMaxText_bytes = 16U << 20;
constexpr std::array<char, 8> kMagic = {'T', 'V', 'X', 'T', 'I', 'L', 'E', 'S'};
// Begins each record; it is not text, and is rare among compressed bytes.
constexpr std::uint32_t kMarker = 0x9e01c57a;

struct FileHead {
    std::array<char, 8> magic = kMagic;
    std::uint32_t version = kVersion;
    std::uint32_t text_bytes = 0;
    std::uint64_t text_checksum = 0;
};
static_assert(sizeof(FileHead) == 24);

struct RecordHead {
    std::uint32_t marker = kMarker;
    std::uint32_t kind = 0;
    std::uint32_t cell = 0;
    std::uint32_t bytes = 0;
    std::uint64_t payload_checksum = 0;
    /// Of all fields before it: a length is trusted only if it matches.
    std::uint64_t checksum = 0;
    [[nodiscard]] std::uint64_t own_checksum() const noexcept {
        return XXH3_64bits(this, offsetof(RecordHead, checksum));
    }
    [[nodiscard]] bool is_right() const noexcept {
        return marker == kMarker && checksum == own_checksum();
    }
};
static_assert(sizeof(RecordHead) == kRecordHead_bytes);

[[noreturn]] void fail(const OpenFile& file, const std::string& what) {
    throw util::Error("read the checkpoint " + file.path().string() + ": " + what);
}

template <class T>
T read_as(const OpenFile& file, std::uint64_t offset) {
    T out;
    file.read(offset, std::as_writable_bytes(std::span(&out, 1)));
    return out;
}

/// @return where the next record head may begin, at `from` or later; nullopt: nowhere
std::optional<std::uint64_t> find_head(const OpenFile& file, std::uint64_t from,
                                       std::uint64_t size) {
    constexpr std::uint64_t kWindow_bytes = std::uint64_t{1} << 20;
    std::vector<std::byte> window;
    for (std::uint64_t at = from; at + kRecordHead_bytes <= size;) {
        window.resize(std::min(kWindow_bytes, size - at));
        file.read(at, window);
        for (std::size_t i = 0; i + kRecordHead_bytes <= window.size(); ++i) {
            RecordHead head;
            if (std::memcmp(&window[i], &kMarker, sizeof kMarker) != 0)
                continue;
            std::memcpy(&head, &window[i], sizeof head);
            if (head.is_right())
                return at + i;
        }
        at += window.size() - kRecordHead_bytes + 1;
    }
    return std::nullopt;
}

}  // namespace

OpenFile::OpenFile(std::filesystem::path path, int flags, const std::string& attempt)
    : m_path(std::move(path)) {
    if ((flags & O_ACCMODE) != O_RDONLY) {
        m_file = util::Descriptor(
            util::open_to_write(m_path, flags, 0666, attempt + " " + m_path.string()));
        return;
    }
    m_file = util::Descriptor(::open(m_path.c_str(), flags | O_CLOEXEC));
    if (fd() < 0)
        throw util::Error(attempt + " " + m_path.string() + ": " + std::strerror(errno));
    struct stat facts{};
    if (::fstat(fd(), &facts) != 0 || !S_ISREG(facts.st_mode))
        throw util::Error(attempt + " " + m_path.string() + ": not a plain file");
}

std::uint64_t OpenFile::size() const {
    struct stat facts{};
    if (::fstat(fd(), &facts) != 0)
        fail(*this, std::strerror(errno));
    return static_cast<std::uint64_t>(facts.st_size);
}

void OpenFile::read(std::uint64_t offset, std::span<std::byte> to) const {
    while (!to.empty()) {
        const ssize_t count = ::pread(fd(), to.data(), to.size(), static_cast<off_t>(offset));
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            fail(*this, std::strerror(errno));
        if (count == 0)
            fail(*this, "cut short at byte " + std::to_string(offset));
        to = to.subspan(static_cast<std::size_t>(count));
        offset += static_cast<std::uint64_t>(count);
    }
}

std::vector<std::byte> file_head(const std::string& text) {
    if (text.size() > kMaxText_bytes)
        throw util::Error("write the head of a checkpoint: " + std::to_string(text.size()) +
                          " bytes; allowed: up to " + std::to_string(kMaxText_bytes));
    FileHead head;
    head.text_bytes = static_cast<std::uint32_t>(text.size());
    head.text_checksum = XXH3_64bits(text.data(), text.size());
    std::vector<std::byte> out(sizeof head + text.size());
    std::memcpy(out.data(), &head, sizeof head);
    std::memcpy(out.data() + sizeof head, text.data(), text.size());
    return out;
}

std::array<std::byte, kRecordHead_bytes> record_head(RecordKind kind, std::uint32_t cell,
                                                     std::span<const std::byte> payload) noexcept {
    RecordHead head;
    head.kind = static_cast<std::uint32_t>(kind);
    head.cell = cell;
    head.bytes = static_cast<std::uint32_t>(payload.size());
    head.payload_checksum = XXH3_64bits(payload.data(), payload.size());
    head.checksum = head.own_checksum();
    return std::bit_cast<std::array<std::byte, kRecordHead_bytes>>(head);
}

RecordScan scan_records(const OpenFile& file,
                        const std::function<bool(const std::string&, const Record&,
                                                 std::span<const std::byte>)>& record) {
    const std::uint64_t size = file.size();
    if (size < sizeof(FileHead))
        fail(file, "no checkpoint of a picture");
    const auto head = read_as<FileHead>(file, 0);
    if (head.magic != kMagic)
        fail(file, "no checkpoint of a picture");
    if (head.version != kVersion)
        fail(file,
             "version " + std::to_string(head.version) + "; allowed: " + std::to_string(kVersion));
    if (head.text_bytes > kMaxText_bytes || head.text_bytes > size - sizeof head)
        fail(file, "its head is damaged");
    RecordScan out;
    out.text.resize(head.text_bytes);
    file.read(sizeof head, std::as_writable_bytes(std::span(out.text)));
    if (XXH3_64bits(out.text.data(), out.text.size()) != head.text_checksum)
        fail(file, "its head is damaged");

    out.end = sizeof head + out.text.size();
    std::vector<std::byte> payload;
    for (std::uint64_t at = out.end; size - at >= kRecordHead_bytes;) {
        auto next = read_as<RecordHead>(file, at);
        if (!next.is_right()) {
            const auto found = find_head(file, at + 1, size);
            if (!found)
                break;
            out.lost_bytes += *found - at;
            at = *found;
            next = read_as<RecordHead>(file, at);
        }
        const Record found{static_cast<RecordKind>(next.kind), next.cell, at + sizeof next,
                           next.bytes};
        if (found.bytes > size - found.offset)
            break;  // begun, and cut short
        payload.resize(found.bytes);
        file.read(found.offset, payload);
        if (XXH3_64bits(payload.data(), payload.size()) != next.payload_checksum ||
            !record(out.text, found, payload))
            out.damaged.push_back(found);
        at = out.end = found.offset + found.bytes;
    }
    out.torn_bytes = size - out.end;
    return out;
}

}  // namespace terravox::farm
