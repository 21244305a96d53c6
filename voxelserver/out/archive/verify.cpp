#include "voxelserver/out/archive/verify.hpp"

#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/thread/in_order.hpp"
#include "common/util/error.hpp"
#include "common/voxel/archive/archive_parts.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/out/archive/indexed_file.hpp"

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

namespace {

using voxel::Box;
using voxel::BoxKey;
using voxel::archive::Kind;
using voxel::archive::Record;

/// A chunk ends with the children of a parent once it has this many entries.
constexpr std::size_t kChunkEntries = 256;

enum class State { kBox, kHole, kUnknown };

/// What a record holds, or what its children say that it must hold. Nothing for air.
struct Content {
    BoxKey key;
    State state = State::kBox;
    std::uint64_t checksum = 0;  ///< of the box
};

/// Entries that lie in one level: from one place of the index to another.
struct Place {
    std::size_t leaf = 0;
    std::size_t entry = 0;
};
struct Chunk {
    Place begin;
    Place end;
};

struct ChunkResult {
    std::vector<Content> found;     ///< in the order of the index
    std::vector<Content> expected;  ///< of the level above, in the order of the index
    std::vector<std::string> problems;
};

bool before(const BoxKey& a, const BoxKey& b) {
    return voxel::archive::before(voxel::archive::to_key(a), voxel::archive::to_key(b));
}

/// The children of one box, as they come.
class Siblings {
public:
    void add(const Content& content, std::shared_ptr<const Box> box) {
        const BoxKey& key = content.key;
        m_parent = voxel::Pyramid::parent(key);
        m_hole = m_hole || content.state == State::kHole;
        m_unknown = m_unknown || content.state == State::kUnknown;
        m_children[voxel::Pyramid::place(key)] = std::move(box);
    }
    [[nodiscard]] bool take(const BoxKey& key) const {
        return !m_parent || *m_parent == voxel::Pyramid::parent(key);
    }
    /// What their parent must hold; nullopt: air. Forgets them.
    [[nodiscard]] std::optional<Content> parent() {
        const auto children = std::exchange(m_children, {});
        const bool hole = std::exchange(m_hole, false);
        const bool unknown = std::exchange(m_unknown, false);
        const std::optional<BoxKey> key = std::exchange(m_parent, std::nullopt);
        if (!key)
            return std::nullopt;
        if (hole)
            return Content{*key, State::kHole, 0};
        if (unknown)
            return Content{*key, State::kUnknown, 0};
        const auto box = voxel::downsample(*key, children);
        if (!box)
            return std::nullopt;
        return Content{*key, State::kBox, box->checksum()};
    }

private:
    std::optional<BoxKey> m_parent;
    voxel::Pyramid::Children<std::shared_ptr<const Box>> m_children;
    bool m_hole = false;
    bool m_unknown = false;
};

class Verifier {
public:
    Verifier(ByteSource& source, int threads, const VerifyProgress& progress)
        : m_source(source),
          m_index(source, ArchiveIndex::Of::kAnyFile),
          m_threads(threads),
          m_progress(progress) {}

    Verification run(std::uint64_t file_bytes) {
        read_index();
        for (const auto& level : m_chunks)
            verify_level(level);
        check_size(m_source, m_index, m_walked, file_bytes, m_out);
        return std::move(m_out);
    }

private:
    /// Cuts the index into chunks, level by level.
    void read_index() {
        m_chunks.resize(static_cast<std::size_t>(m_index.info().levels));
        std::optional<Entry> last;
        std::size_t count = 0;
        m_walked =
            walk_index(m_index, m_out, [&](std::size_t leaf, const std::vector<Entry>& entries) {
                for (std::size_t i = 0; i < entries.size(); ++i) {
                    const Entry& entry = entries[i];
                    auto& level = m_chunks[static_cast<std::size_t>(entry.key.level)];
                    if (level.empty() ||
                        (count >= kChunkEntries && last &&
                         voxel::Pyramid::parent(voxel::archive::to_key(last->key)) !=
                             voxel::Pyramid::parent(voxel::archive::to_key(entry.key)))) {
                        level.push_back({{leaf, i}, {}});
                        count = 0;
                    }
                    level.back().end = {leaf, i + 1};
                    ++count;
                    last = entry;
                }
            });
    }

    void verify_level(const std::vector<Chunk>& chunks) {
        std::vector<Content> expected = std::exchange(m_expected, {});
        auto next = expected.cbegin();
        thread::in_order(
            chunks.size(), m_threads, [&](std::size_t i) { return verify_chunk(chunks[i]); },
            [&](std::size_t, ChunkResult result) {
                for (const std::string& problem : result.problems)
                    m_out.note(problem);
                for (const Content& content : result.found) {
                    while (next != expected.cend() && before(next->key, content.key))
                        note_missing(*next++);
                    if (next != expected.cend() && next->key == content.key)
                        compare(content, &*next++);
                    else
                        compare(content, nullptr);
                }
                m_expected.insert(m_expected.end(), result.expected.begin(), result.expected.end());
                m_done += result.found.size();
                if (m_progress)
                    m_progress(m_done, m_walked.records);
            });
        while (next != expected.cend())
            note_missing(*next++);
        ++m_level;
        if (m_level > coarsest_level())
            m_expected.clear();
    }

    /// Boxes of this level have no parents in the file.
    [[nodiscard]] int coarsest_level() const noexcept {
        switch (m_index.kind()) {
            case FileKind::kShard: return voxel::archive::kSubtreeLevel;
            case FileKind::kChange: return 0;
            case FileKind::kArchive: break;
        }
        return m_index.info().levels - 1;
    }

    void note_missing(const Content& expected) {
        // What could not be read may be there.
        if (expected.state == State::kUnknown || !m_walked.is_readable)
            return;
        m_out.note("box " + voxel::to_string(expected.key) +
                   " is missing above boxes that are there");
    }

    void compare(const Content& found, const Content* expected) {
        if (found.state == State::kHole)
            ++m_out.holes;
        else
            ++m_out.boxes;
        if (m_level == 0 || found.state == State::kUnknown || !m_walked.is_readable ||
            (expected != nullptr && expected->state == State::kUnknown))
            return;
        const std::string name = "box " + voxel::to_string(found.key);
        if (expected == nullptr)
            m_out.note(name + " has nothing below it");
        else if (found.state != expected->state)
            m_out.note(name + (found.state == State::kHole
                                   ? " is a hole, but none of its children is"
                                   : " is there, but a child of it is a hole"));
        else if (found.state == State::kBox && found.checksum != expected->checksum)
            m_out.note(name + " is not what its children give");
    }

    [[nodiscard]] ChunkResult verify_chunk(const Chunk& chunk) const {
        ChunkResult out;
        Siblings siblings;
        const auto end_group = [&] {
            if (const auto parent = siblings.parent())
                out.expected.push_back(*parent);
        };
        for (std::size_t leaf = chunk.begin.leaf; leaf <= chunk.end.leaf; ++leaf) {
            const auto entries = readable_entries(leaf);
            const std::size_t first = leaf == chunk.begin.leaf ? chunk.begin.entry : 0;
            const std::size_t end = leaf == chunk.end.leaf ? chunk.end.entry : entries.size();
            for (std::size_t i = first; i < end; ++i) {
                const auto key = voxel::archive::to_key(entries[i].key);
                std::shared_ptr<const Box> box;
                const Content content{key, read(entries[i], box, out.problems),
                                      box ? box->checksum() : 0};
                if (!siblings.take(key))
                    end_group();
                siblings.add(content, std::move(box));
                out.found.push_back(content);
            }
        }
        end_group();
        return out;
    }

    /// None of a leaf that is damaged, which read_index() has noted.
    [[nodiscard]] std::vector<Entry> readable_entries(std::size_t leaf) const {
        try {
            return m_index.entries(leaf);
        } catch (const voxel::ChangedError&) {
            throw;
        } catch (const util::Error&) {
            return {};
        }
    }

    /// Reads a record and its frame.
    /// @param box set for a box that is whole
    [[nodiscard]] State read(const Entry& entry, std::shared_ptr<const Box>& box,
                             std::vector<std::string>& problems) const {
        const std::string name = to_name(entry);
        if (entry.offset < sizeof(Record)) {
            problems.push_back("box " + name + " lies before the first record");
            return State::kUnknown;
        }
        std::vector<std::byte> room;
        std::span<const std::byte> bytes;
        try {
            bytes =
                m_source.read(entry.offset - sizeof(Record), sizeof(Record) + entry.bytes, room);
        } catch (const voxel::ChangedError&) {
            throw;
        } catch (const util::Error& e) {
            problems.emplace_back("box " + name + ": " + e.what());
            return State::kUnknown;
        }
        Record record{};
        std::memcpy(&record, bytes.data(), sizeof record);
        const auto frame = bytes.subspan(sizeof record);
        if (const auto problem = find_problem(record, entry, frame)) {
            problems.push_back(*problem);
            return State::kUnknown;
        }
        if (entry.kind == Kind::kHole)
            return State::kHole;
        try {
            box = voxel::decompress_box(frame, name);
        } catch (const util::Error& e) {
            problems.emplace_back(e.what());
            return State::kUnknown;
        }
        if (box->key() == voxel::archive::to_key(entry.key))
            return State::kBox;
        problems.push_back("box " + name + ": its frame is that of box " +
                           voxel::to_string(box->key()));
        box.reset();
        return State::kUnknown;
    }

    [[nodiscard]] static std::string to_name(const Entry& entry) {
        return voxel::to_string(voxel::archive::to_key(entry.key));
    }

    ByteSource& m_source;
    const ArchiveIndex m_index;
    const int m_threads;
    const VerifyProgress& m_progress;
    std::vector<std::vector<Chunk>> m_chunks;  ///< of each level
    std::vector<Content> m_expected;           ///< of the next level, in the order of the index
    Verification m_out;
    int m_level = 0;
    WalkedIndex m_walked;
    std::uint64_t m_done = 0;
};

}  // namespace

void Verification::note(const std::string& problem) {
    ++problems;
    if (first_problems.size() < kShownProblems)
        first_problems.push_back(problem);
}

Verification verify(const ArchiveFiles& archive, int threads, const VerifyProgress& progress) {
    const auto source = archive.open();
    return Verifier(*source, threads, progress).run(archive.bytes());
}

}  // namespace terravox::archive_tools
