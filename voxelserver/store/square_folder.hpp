#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "voxelserver/store/chunk_index.hpp"
#include "voxelserver/store/square.hpp"

namespace terravox::store {

/// Names what a prepared square was made of: a change of the source file or of anything that shapes
/// its points changes the name.
/// @param source the file of points
/// @param recipe everything else that the points depend on (frame, filters, class table), as text
[[nodiscard]] std::string square_name(const std::filesystem::path& source,
                                      const std::string& recipe);

/// Prepared squares in a folder, so that a restart need not decode again. Files are mapped,
/// versioned and checksummed, appear whole or not at all, and go when the folder passes its limit:
/// those used longest ago first. Chunk indices are small and go only when no square is left to go.
/// A file that is mapped stays readable when it goes.
///
/// A damaged or foreign file counts as absent, with a warning; the folder never decides what a
/// voxel is. A folder that cannot be made or written to is reported once and then only read.
/// Thread-safe; several processes may share a folder.
class SquareFolder {
public:
    /// @param limit_bytes of all finished files together; holds after every put
    SquareFolder(std::filesystem::path folder, std::uint64_t limit_bytes);

    /// Whether a square of that name seems to be there; find() may still find it damaged.
    [[nodiscard]] bool holds(const std::string& name) const;
    /// @return nullptr when it is not there
    [[nodiscard]] std::shared_ptr<const Square> find(const std::string& name);
    /// Keeps a square. @return the mapped one, or the one given when it could not be written
    [[nodiscard]] std::shared_ptr<const Square> put(const std::string& name,
                                                    std::shared_ptr<const Square> square);

    [[nodiscard]] std::optional<ChunkIndex> find_index(const std::string& name);
    void put_index(const std::string& name, const ChunkIndex& index);

private:
    [[nodiscard]] std::filesystem::path square_file(const std::string& name) const;
    [[nodiscard]] std::filesystem::path index_file(const std::string& name) const;
    void evict(const std::filesystem::path& but_not);
    void complain(const std::string& what);

    std::filesystem::path m_folder;
    std::uint64_t m_limit_bytes;
    std::mutex m_mutex;  // guards what follows, and that only one thread evicts
    bool m_read_only = false;
};

}  // namespace terravox::store
