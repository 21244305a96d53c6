#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "common/voxel/world.hpp"
#include "voxelserver/data/store/chunk_index.hpp"
#include "voxelserver/data/store/square.hpp"

namespace terravox::store {

/// The name of a prepared square, derived from its inputs: a change of the source file or of any
/// setting that affects its points changes the name.
/// @param source the point file
/// @param recipe everything else that the points depend on (frame, filters, class table), as text
[[nodiscard]] std::string square_name(const std::filesystem::path& source,
                                      const std::string& recipe);
/// @param identity of the point file (common/voxel/file_identity.hpp)
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
