#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/util/cache.hpp"
#include "common/voxel/archive/archive_format.hpp"
#include "common/voxel/archive/byte_source.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel::archive {

/// Which of the files that are laid out like an archive one is, by its magic.
enum class FileKind : std::uint8_t {
    kArchive,
    kShard,   ///< one of several that together become an archive (archive_parts.hpp)
    kChange,  ///< replaces columns of boxes of an archive (archive_parts.hpp)
};

/// What an archive holds besides its boxes: header, facts and index. Checksums, order and places
/// are verified when a part is read. The leaves are not kept. Thread-safe.
class ArchiveIndex {
public:
    enum class Of {
        kArchive,
        kAnyFile,  ///< or a shard (archive_parts.hpp), or a change (archive_parts.hpp)
    };
    /// Reads header, facts and the root of the index.
    /// @param source must outlive this
    /// @throws Error when it is not an archive, has another version, is unfinished or damaged, or
    /// when its bounds are inconsistent with its levels (levels_for())
    explicit ArchiveIndex(ByteSource& source, Of of = Of::kArchive);

    [[nodiscard]] const Header& header() const noexcept { return m_header; }
    [[nodiscard]] const WorldInfo& info() const noexcept { return m_info; }
    [[nodiscard]] FileKind kind() const noexcept { return m_kind; }
    /// Of the whole index, in the order of their first entries (before()).
    [[nodiscard]] std::span<const Leaf> leaves() const noexcept { return m_root; }
    /// The entries of a leaf, in order.
    /// @param index of the leaf
    /// @throws Error when the leaf is damaged, or names a box outside the bounds
    [[nodiscard]] std::vector<Entry> entries(std::size_t index) const;
    /// Calls back with each entry, in order.
    /// @throws Error when a leaf is damaged
    template <class Visit>
    void each_entry(const Visit& visit) const {
        for (std::size_t leaf = 0; leaf < m_root.size(); ++leaf)
            for (const Entry& entry : entries(leaf))
                visit(entry);
    }

private:
    void read_header(Of of);
    void read_info();
    void read_root();
    void check_bounds() const;
    [[nodiscard]] bool has_room_for(const Key& key) const;
    [[noreturn]] void fail(const std::string& what) const;

    ByteSource& m_source;
    Header m_header{};
    FileKind m_kind = FileKind::kArchive;
    WorldInfo m_info;
    std::vector<Leaf> m_root;
};

/// Looks entries of an index up. The leaves that were used last are kept, up to a limit of 64 MiB.
/// Thread-safe.
class EntryFinder {
public:
    using Entries = std::vector<Entry>;

    /// @param index must outlive this
    explicit EntryFinder(const ArchiveIndex& index);

    /// @return nullopt: there is no such box
    /// @throws Error as ArchiveIndex::entries()
    [[nodiscard]] std::optional<Entry> find(const BoxKey& key);
    /// The leaf that begins last of those that begin at the key or before: no other has an entry
    /// with it.
    /// @return nullptr: all begin after it
    /// @throws Error as ArchiveIndex::entries()
    [[nodiscard]] std::shared_ptr<const Entries> leaf_at(const Key& key);

private:
    const ArchiveIndex& m_index;
    util::Cache<std::size_t, Entries> m_leaves;
};

}  // namespace terravox::voxel::archive

namespace terravox::voxel {

/// Opens a box archive as a world. The checksum of a box, index leaf or header is verified whenever
/// it is read.
/// @throws Error when the file is not an archive, has another version, is unfinished or damaged, or
/// when its bounds are inconsistent with its levels (levels_for()) or its index
[[nodiscard]] std::unique_ptr<World> open_archive(std::unique_ptr<archive::ByteSource> source);

/// Whether a file begins like a box archive, or a shard or change of one; the rest is not
/// checked.
[[nodiscard]] bool is_archive(const std::filesystem::path& file);

}  // namespace terravox::voxel
