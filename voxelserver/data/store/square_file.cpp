#include "voxelserver/data/store/square_folder.hpp"

#include <xxhash.h>

#include <array>
#include <cstring>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::store {
namespace {

using grid::PatchKey;

/// Header of all kinds of file. `count` and `more`: patches and points; chunks and patches of
/// chunks; bytes of facts and nothing.
struct Header {
    std::array<char, 8> magic{};
    std::uint32_t version = kSquareFileVersion;
    std::uint32_t header_bytes = sizeof(Header);
    std::uint64_t count = 0;
    std::uint64_t more = 0;
    /// XXH64 of the header with this field 0, then of the tables after it (not of the points).
    std::uint64_t checksum = 0;
    std::uint64_t reserved = 0;
    PointCounts counts;
};
static_assert(std::is_trivially_copyable_v<Header> && sizeof(Header) % 8 == 0);

/// One chunk in a chunk index file; the patches of all chunks follow after the last chunk.
struct ChunkRecord {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
    std::uint64_t patches = 0;
};

constexpr std::array<char, 8> kSquareMagic = {'T', 'V', 'S', 'Q', 'U', 'A', 'R', 'E'};
constexpr std::array<char, 8> kChunksMagic = {'T', 'V', 'C', 'H', 'U', 'N', 'K', 'S'};
constexpr std::array<char, 8> kFactsMagic = {'T', 'V', 'S', 'F', 'A', 'C', 'T', 'S'};

std::uint64_t checksum(Header header, std::span<const std::byte> tables) {
    header.checksum = 0;
    return XXH64(tables.data(), tables.size(), XXH64(&header, sizeof header, 0));
}

void write(const std::filesystem::path& path, Header header, std::span<const std::byte> tables,
           std::span<const std::byte> points) {
    header.checksum = checksum(header, tables);
    util::AtomicFile file(path, util::Links::kReplace);
    file.append(std::as_bytes(std::span(&header, 1)));
    file.append(tables);
    file.append(points);
    // Checksums detect a file that was truncated by a crash, so there is no need to wait for the
    // disk.
    file.commit(util::AtomicFile::Flush::kNo);
}

struct Opened {
    std::shared_ptr<const util::MappedFile> file;
    Header header;
};

/// The memory and objects that a mapped square keeps alive.
struct Mapped {
    std::shared_ptr<const util::MappedFile> file;
    std::vector<PatchEntry> patches;
};

/// Sizes that result from the counts of a header, bytes.
struct Layout {
    std::size_t tables = 0;
    std::size_t points = 0;
};

/// @param make_layout std::optional<Layout>(Header, available bytes): nullopt when the counts do
/// not fit
template <class MakeLayout>
Opened open(const std::filesystem::path& path, const std::array<char, 8>& magic,
            const MakeLayout& make_layout) {
    const auto fail = [&](const std::string& what) {
        return util::Error("read the prepared square {}: {}", path.string(), what);
    };
    Opened out{util::MappedFile::open(path), {}};
    if (!out.file)
        return out;
    const auto bytes = out.file->bytes();
    if (bytes.size() < sizeof(Header))
        throw fail("cut short");
    std::memcpy(static_cast<void*>(&out.header), bytes.data(), sizeof(Header));
    if (out.header.magic != magic)
        throw fail("not a prepared square");
    if (out.header.version != kSquareFileVersion || out.header.header_bytes != sizeof(Header))
        throw fail("version " + std::to_string(out.header.version) +
                   "; allowed: " + std::to_string(kSquareFileVersion));
    const auto room = bytes.size() - sizeof(Header);
    const std::optional<Layout> layout = make_layout(out.header, room);
    if (!layout || layout->tables + layout->points != room)
        throw fail("damaged (" + std::to_string(bytes.size()) +
                   " bytes do not fit the counts in its header)");
    if (!util::readable(bytes.first(sizeof(Header) + layout->tables)))
        throw fail("cut short while it was read");
    if (checksum(out.header, bytes.subspan(sizeof(Header), layout->tables)) != out.header.checksum)
        throw fail("damaged (checksum)");
    return out;
}

}  // namespace

void write_square(const std::filesystem::path& file, const Square& square) {
    Header header;
    header.magic = kSquareMagic;
    header.count = square.patches().size();
    header.more = square.all().size();
    header.counts = square.counts();
    std::vector<PatchEntry> patches(square.patches().begin(), square.patches().end());
    for (PatchEntry& p : patches)
        p.checksum =
            compute_checksum(square.points(p.key));  // throws when a mapped square is damaged
    write(file, header, std::as_bytes(std::span(patches)), std::as_bytes(square.all()));
}

std::shared_ptr<const Square> map_square(const std::filesystem::path& path) {
    const auto opened =
        open(path, kSquareMagic, [](const Header& h, std::size_t room) -> std::optional<Layout> {
            if (h.count > room / sizeof(PatchEntry))
                return std::nullopt;
            const std::size_t tables = h.count * sizeof(PatchEntry);
            if (h.more > (room - tables) / sizeof(VoxelPoint))
                return std::nullopt;
            return Layout{tables, h.more * sizeof(VoxelPoint)};
        });
    if (!opened.file)
        return nullptr;
    const std::byte* tables = opened.file->bytes().data() + sizeof(Header);
    // The directory is used for every patch: it is copied, so that it stays valid whatever happens
    // to the file.
    const auto holder =
        std::make_shared<Mapped>(Mapped{opened.file, std::vector<PatchEntry>(opened.header.count)});
    const std::span patches(holder->patches);
    if (!patches.empty())
        std::memcpy(patches.data(), tables, patches.size_bytes());
    const std::span points(reinterpret_cast<const VoxelPoint*>(tables + patches.size_bytes()),
                           opened.header.more);
    std::uint64_t at = 0;
    for (const PatchEntry& p : patches) {
        if (p.begin != at || p.count > points.size() - at)
            throw util::Error("read the prepared square {}: damaged (directory)", path.string());
        at += p.count;
    }
    if (at != points.size())
        throw util::Error("read the prepared square {}: damaged (directory)", path.string());
    return std::make_shared<Square>(holder, patches, points, opened.header.counts,
                                    opened.file->bytes().size() + patches.size_bytes(), false);
}

void write_chunks(const std::filesystem::path& file, const ChunkIndex& index) {
    std::vector<ChunkRecord> records;
    std::vector<grid::PatchKey> patches;
    for (const auto& chunk : index.chunks()) {
        records.push_back({chunk.points.begin, chunk.points.end, chunk.patches.size()});
        patches.insert(patches.end(), chunk.patches.begin(), chunk.patches.end());
    }
    Header header;
    header.magic = kChunksMagic;
    header.count = records.size();
    header.more = patches.size();
    std::vector<std::byte> tables(std::as_bytes(std::span(records)).begin(),
                                  std::as_bytes(std::span(records)).end());
    tables.insert(tables.end(), std::as_bytes(std::span(patches)).begin(),
                  std::as_bytes(std::span(patches)).end());
    write(file, header, tables, {});
}

std::optional<ChunkIndex> read_chunks(const std::filesystem::path& path) {
    const auto opened =
        open(path, kChunksMagic, [](const Header& h, std::size_t room) -> std::optional<Layout> {
            if (h.count > room / sizeof(ChunkRecord) || h.more > room / sizeof(grid::PatchKey))
                return std::nullopt;
            return Layout{h.count * sizeof(ChunkRecord) + h.more * sizeof(grid::PatchKey), 0};
        });
    if (!opened.file)
        return std::nullopt;
    const auto damaged = [&] {
        return util::Error("read the chunk index {}: damaged", path.string());
    };
    const std::byte* at = opened.file->bytes().data() + sizeof(Header);
    const std::byte* patches_at = at + opened.header.count * sizeof(ChunkRecord);
    std::uint64_t left = opened.header.more;
    std::vector<ChunkIndex::Chunk> chunks(opened.header.count);
    for (ChunkIndex::Chunk& chunk : chunks) {
        ChunkRecord record;
        std::memcpy(&record, at, sizeof record);
        at += sizeof record;
        if (record.patches > left || record.begin > record.end)
            throw damaged();
        left -= record.patches;
        chunk.points = {record.begin, record.end};
        chunk.patches.resize(record.patches);
        if (record.patches > 0)
            std::memcpy(chunk.patches.data(), patches_at, record.patches * sizeof(grid::PatchKey));
        patches_at += record.patches * sizeof(grid::PatchKey);
    }
    if (left != 0)
        throw damaged();
    return ChunkIndex(std::move(chunks));
}

void write_facts(const std::filesystem::path& file, std::string_view facts) {
    Header header;
    header.magic = kFactsMagic;
    header.count = facts.size();
    write(file, header, std::as_bytes(std::span(facts)), {});
}

std::optional<std::string> read_facts(const std::filesystem::path& path) {
    const auto opened =
        open(path, kFactsMagic, [](const Header& h, std::size_t room) -> std::optional<Layout> {
            const bool fits = h.count == room && room <= kMaxFactsBytes && h.more == 0;
            return fits ? std::optional(Layout{room, 0}) : std::nullopt;
        });
    if (!opened.file)
        return std::nullopt;
    const auto bytes = opened.file->bytes().subspan(sizeof(Header));
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

}  // namespace terravox::store
