#pragma once

#include <atomic>
#include <bitset>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/util/cache.hpp"
#include "voxelserver/data/store/square.hpp"
#include "voxelserver/data/store/square_folder.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"
#include "voxelserver/make/voxelize/points/point_load.hpp"
#include "voxelserver/make/voxelize/points/sources.hpp"
#include "voxelserver/make/voxelize/points/square_info.hpp"

namespace terravox::voxelize {

/// How much memory the points of a world may take, bytes. The rest is for boxes, except for a sixth
/// of the world's memory, which is left for decoding a square.
struct PointMemory {
    std::size_t squares = 0;  ///< those of whole files
    std::size_t parts = 0;    ///< parts of files
    std::size_t columns = 0;
};

/// @param memory_bytes of the whole world
/// @param files determine how squares and parts share the memory: what whole squares do not need
/// goes to parts
[[nodiscard]] PointMemory share_memory(std::size_t memory_bytes,
                                       std::span<const SquareSource> files);

/// What the square of a file depends on in addition to the file.
struct SquareRecipe {
    const grid::Frame& frame;
    const ClassTable& classes;
    const Settings& settings;
};

/// How each file is to be kept, in the order of `files`. The plan points into `files`.
/// @param recipe names the squares in the cache folder; nullptr = there is none
[[nodiscard]] std::vector<PartedFile> plan_files(std::span<const SquareSource> files,
                                                 const PointMemory& memory,
                                                 const SquareRecipe* recipe);

/// Logs warnings about decoded points: stray points, and classes that the table does not name, once
/// for each file (util::warn_of_file). Thread-safe.
class LoadReport {
public:
    /// Both must outlive this.
    LoadReport(std::span<const SquareSource> files, const ClassTable& classes);

    /// A file was decoded whole, or scanned. Only the first call for a file counts.
    void add_whole(std::size_t file, const store::PointCounts& counts);

    /// A part of a file was decoded. Parts are decoded in the order of the requested boxes, some of
    /// them twice: so the log names what was met first, without a count, and counts() does not
    /// change.
    void add_part(std::size_t file, const store::PointCounts& counts);

    /// The sum over all files for which add_whole() was called.
    [[nodiscard]] store::PointCounts counts() const;

private:
    /// What was logged about a file. All members except the first are guarded by m_mutex.
    struct Logged {
        std::once_flag whole;
        bool stray = false;
        std::bitset<256> classes;
    };
    /// Warns of the classes of a file that the table does not name: each code is named once, with
    /// the first file that has it, and the files that share it are counted. With m_mutex locked.
    void warn_of_classes(std::size_t file, const store::PointCounts& counts);

    const std::span<const SquareSource> m_files;
    const ClassTable& m_classes;
    std::vector<Logged> m_logged;
    mutable std::mutex m_mutex;
    store::PointCounts m_counts;
    std::vector<std::bitset<256>> m_unknown;  ///< codes that were named together; disjoint
};

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

/// Decodes whole files. Thread-safe.
///
/// One lock is held from the start of a decoding until its square is kept, because each decoding
/// uses all threads, and as much memory again as its square. A damaged file is not tried again.
class WholeDecoder {
public:
    /// Decodes a file.
    /// @throws Error for a damaged one
    using Load = std::function<LoadedSquare(std::size_t file)>;
    /// Keeps a decoded square.
    /// @return the square to use instead of the given one
    using Keep =
        std::function<std::shared_ptr<const store::Square>(std::size_t file, LoadedSquare loaded)>;
    WholeDecoder(std::size_t files, Load load, Keep keep);

    /// Blocks while another file is being decoded.
    /// @throws Error for a damaged file, each time with the same message; whatever `load` and
    /// `keep` throw
    [[nodiscard]] std::shared_ptr<const store::Square> decode(std::size_t file);

private:
    [[nodiscard]] LoadedSquare load(std::size_t file);

    const Load m_load;
    const Keep m_keep;
    std::mutex m_mutex;
    std::vector<std::string> m_failures;  ///< by file: why it could not be decoded; "": it could
};

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
    [[nodiscard]] std::pair<SquareState, std::string> find_state(std::size_t file) const;

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
