#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "common/voxel/world.hpp"
#include "voxelserver/data/store/square.hpp"

namespace terravox::store {

/// Version of all layouts. A file of another version is treated as absent: prepared squares are
/// remade, never converted.
inline constexpr std::uint32_t kSquareFileVersion = 1;

/// Writes a prepared square: header, patch directory, points.
/// @throws Error
void write_square(const std::filesystem::path& file, const Square& square);
/// Maps a prepared square. The header and the directory are checked at once, the points of a patch
/// when they are first requested.
/// @return nullptr when there is no such file
/// @throws Error for a damaged file or another version
[[nodiscard]] std::shared_ptr<const Square> map_square(const std::filesystem::path& file);

/// Writes a chunk index.
/// @throws Error
void write_chunks(const std::filesystem::path& file, const ChunkIndex& index);
/// Reads a chunk index.
/// @return nullopt when there is no such file
/// @throws Error as map_square()
[[nodiscard]] std::optional<ChunkIndex> read_chunks(const std::filesystem::path& file);

inline constexpr std::size_t kMaxFactsBytes = std::size_t{64} << 10;
/// Writes facts that were found out about squares, as bytes of any meaning.
/// @param facts up to kMaxFactsBytes: more is refused when it is read
/// @throws Error
void write_facts(const std::filesystem::path& file, std::string_view facts);
/// Reads facts.
/// @return nullopt when there is no such file
/// @throws Error as map_square()
[[nodiscard]] std::optional<std::string> read_facts(const std::filesystem::path& file);

/// The name of a prepared square, derived from its inputs: a change of the source file or of any
/// setting that affects its points changes the name.
/// @param source the point file
/// @param recipe everything else that the points depend on (frame, filters, class table), as text
[[nodiscard]] std::string square_name(const std::filesystem::path& source,
                                      const std::string& recipe);
/// @param identity of the point file (common/voxel/fingerprint.hpp)
[[nodiscard]] std::string square_name(const std::filesystem::path& source,
                                      const voxel::Fingerprint& identity,
                                      const std::string& recipe);

/// Limit of a folder from which nothing is removed.
constexpr std::uint64_t kUnlimited_bytes = std::numeric_limits<std::uint64_t>::max();

/// A folder of prepared squares, so that they need not be decoded again after a restart. Files are
/// mapped, versioned and checksummed, appear atomically, and are evicted when the folder exceeds
/// its limit, least recently used first. Chunk indices and facts are small and are evicted only
/// when no square is left to evict. A mapped file stays readable after its eviction.
///
/// A damaged or foreign file is treated as absent, with a warning; the folder never affects the
/// content of a voxel. A folder that cannot be created or written to is reported once and then only
/// read. Thread-safe; several processes may share a folder.
class SquareFolder {
public:
    /// @param limit_bytes limit for all finished files together; enforced after every put of a
    /// square or an index
    SquareFolder(std::filesystem::path folder, std::uint64_t limit_bytes);

    /// Whether a square of that name seems to be present; find() may still find it damaged.
    [[nodiscard]] bool holds(const std::string& name) const;
    /// @return nullptr when it is not present
    [[nodiscard]] std::shared_ptr<const Square> find(const std::string& name);
    /// Stores a square.
    /// @return the mapped square, or the given one when it could not be written
    [[nodiscard]] std::shared_ptr<const Square> put(const std::string& name,
                                                    std::shared_ptr<const Square> square);

    [[nodiscard]] bool holds_index(const std::string& name) const;  ///< as holds()
    [[nodiscard]] std::optional<ChunkIndex> find_index(const std::string& name);
    void put_index(const std::string& name, const ChunkIndex& index);

    /// Facts that were found out about squares, as bytes, up to kMaxFactsBytes.
    [[nodiscard]] std::optional<std::string> find_facts(const std::string& name);
    void put_facts(const std::string& name, const std::string& facts);

private:
    /// @param write to a path; throws Error
    template <class Write>
    void put_small(const std::filesystem::path& file, const Write& write);
    [[nodiscard]] std::filesystem::path square_file(const std::string& name) const;
    [[nodiscard]] std::filesystem::path index_file(const std::string& name) const;
    [[nodiscard]] std::filesystem::path facts_file(const std::string& name) const;
    void evict(const std::filesystem::path& but_not);
    void complain(const std::string& what);

    std::filesystem::path m_folder;
    std::uint64_t m_limit_bytes;
    std::mutex m_mutex;  // guards the following members, and ensures that only one thread evicts
    bool m_read_only = false;
};

}  // namespace terravox::store
