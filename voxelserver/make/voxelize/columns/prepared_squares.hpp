#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "voxelserver/data/store/square_folder.hpp"

namespace terravox::voxelize {

/// Squares that an earlier decoding stored in the cache folder, mapped into memory. Thread-safe.
class PreparedSquares {
public:
    /// @param folder must outlive this; nullptr: nothing is found or kept
    /// @param names of the squares of all files, in the folder
    PreparedSquares(store::SquareFolder* folder, std::vector<std::string> names);

    /// Whether a square of that file seems to exist; find() may still find it damaged.
    [[nodiscard]] bool holds(std::size_t file) const;

    /// The first time that the square of a file is found, the checksums of all its patches are
    /// verified, so that a square damaged by a crash or a bad disk is rebuilt before it is used.
    /// @return nullptr when it does not exist or is damaged; a damaged one is logged as a warning
    [[nodiscard]] std::shared_ptr<const store::Square> find(std::size_t file);

    /// @return the mapped square, or the one given when it could not be written
    [[nodiscard]] std::shared_ptr<const store::Square> keep(
        std::size_t file, std::shared_ptr<const store::Square> square);

private:
    store::SquareFolder* const m_folder;
    const std::vector<std::string> m_names;
    std::vector<std::atomic<bool>> m_verified;  ///< by file: its square was verified in this run
};

}  // namespace terravox::voxelize
