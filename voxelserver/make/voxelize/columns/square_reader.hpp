#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/util/cache.hpp"
#include "voxelserver/data/store/square_folder.hpp"
#include "voxelserver/make/voxelize/columns/file_plan.hpp"
#include "voxelserver/make/voxelize/columns/load_report.hpp"
#include "voxelserver/make/voxelize/columns/prepared_squares.hpp"
#include "voxelserver/make/voxelize/columns/whole_decoder.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/point_parts.hpp"
#include "voxelserver/make/voxelize/points/square_info.hpp"

namespace terravox::voxelize {

/// Reads the points of files in one of three ways, all of which give the same points: whole
/// (WholeDecoder), prepared (PreparedSquares), or in parts (PointParts). Thread-safe.
///
/// A file is decoded whole the first time, and kept in memory and in the cache folder. Where an
/// index maps points to places (COPC, .lax, or the chunk index of an earlier decoding), at first
/// only the part around the requested patches is decoded, so that the first boxes are not delayed;
/// once half a file has been decoded that way, the whole file is. A file too large to be kept whole
/// is always read in parts.
class SquareReader {
public:
    /// Files, context and report must outlive this.
    /// @param files of the world
    /// @param context with the frame of these files
    /// @param report receives the counts and problems of the decoded points
    SquareReader(const LidarWorldOptions& options, std::span<const SquareSource> files,
                 const PointMemory& memory, const LoadContext& context, LoadReport& report);

    /// @return squares that together hold all points of `wanted`
    /// @throws Error for a damaged file
    [[nodiscard]] Squares around(std::size_t file, const grid::PatchRect& wanted);

    /// The state of a file, and the error if it failed.
    [[nodiscard]] std::pair<SquareState, std::string> state_of(std::size_t file) const;

    /// Where facts that were found out are kept for later worlds: with the chunk indices that are
    /// to last, else in the cache folder; nullptr: nowhere.
    [[nodiscard]] store::SquareFolder* facts_folder() const noexcept {
        return m_indices ? m_indices.get() : m_folder.get();
    }

private:
    /// The progress of a file so far. Guarded by m_mutex.
    struct Progress {
        std::weak_ptr<const store::Square> in_memory;
        std::string last_error;  ///< of reading it whole or in parts
    };

    [[nodiscard]] Squares read(std::size_t file, const grid::PatchRect& wanted);
    [[nodiscard]] std::shared_ptr<const store::Square> whole(std::size_t file);
    [[nodiscard]] std::shared_ptr<const store::Square> find_or_decode(std::size_t file);
    [[nodiscard]] std::shared_ptr<const store::Square> keep(std::size_t file, LoadedSquare loaded);

    util::StageTimes& m_times;
    LoadReport& m_report;
    const std::unique_ptr<store::SquareFolder> m_folder;  ///< nullptr: there is no cache folder
    /// Of chunk indices for later worlds; nullptr: they are not kept.
    const std::unique_ptr<store::SquareFolder> m_indices;
    const std::vector<PartedFile> m_files;
    PreparedSquares m_prepared;
    PointParts m_parts;
    WholeDecoder m_decoder;
    util::Cache<std::size_t, store::Square> m_squares;  ///< those of whole files, decoded or mapped
    mutable std::mutex m_mutex;
    std::vector<Progress> m_progress;
};

}  // namespace terravox::voxelize
