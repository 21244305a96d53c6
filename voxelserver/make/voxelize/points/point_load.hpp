#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "voxelserver/data/store/square.hpp"
#include "voxelserver/data/store/square_folder.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"
#include "voxelserver/make/voxelize/points/sources.hpp"

namespace terravox::voxelize {

/// What reading needs in addition to the file.
struct LoadContext {
    const grid::Frame& frame;
    const ClassTable& classes;
    const Settings& settings;
    util::StageTimes& times;
};

/// A file decoded whole.
struct LoadedSquare {
    std::shared_ptr<const store::Square> square;
    store::ChunkIndex index;
};

/// Steps "point load", "transformation", "quantization" and "binning" of a whole file, several
/// parts of it in parallel.
/// @throws Error for a damaged file, and for one that has changed since it was opened; so do the
/// next two
[[nodiscard]] LoadedSquare load_square(const SquareSource& source, const LoadContext& context,
                                       int threads);

/// The same for the points of some patches.
/// @param ranges hold all of them (from an index)
[[nodiscard]] std::shared_ptr<const store::Square> load_patches(
    const SquareSource& source, std::span<const pointcloud::PointRange> ranges,
    const grid::PatchRect& wanted, const LoadContext& context, int threads);

/// One range alone, on the calling thread.
[[nodiscard]] std::shared_ptr<const store::Square> load_range(const SquareSource& source,
                                                              const pointcloud::PointRange& range,
                                                              const LoadContext& context);

/// Decodes a file only to index which points lie where: for files too large to be kept whole.
/// @param counts receives the counts of the points
[[nodiscard]] store::ChunkIndex scan_chunks(const SquareSource& source, const LoadContext& context,
                                            int threads, store::PointCounts& counts);

/// Squares that together hold all points of some patches: one that holds a whole file, or parts of
/// it.
using Squares = std::vector<std::shared_ptr<const store::Square>>;

/// A file of a world, and how it is to be kept.
struct PartedFile {
    const SquareSource* source = nullptr;
    std::string name;        ///< in folders of squares and indices; empty without any
    bool kept_whole = true;  ///< small enough for that
    int block_patches = 1;   ///< edge of the blocks in which a file that is too large is read
};

/// Where chunk indices are kept; each may be null.
struct IndexFolders {
    store::SquareFolder* cache = nullptr;  ///< next to prepared squares
    store::SquareFolder* kept = nullptr;   ///< for later worlds
    bool reads_kept = false;               ///< whether those of earlier worlds are used
};

/// Parts of files: for the first boxes, which should not wait for the whole file, and for files too
/// large to be kept whole. Thread-safe.
///
/// Parts are chunks of the file, each decoded once while it is kept, where the file's own index or
/// this program's chunk index maps points to chunks. They are blocks of patches where a .lax file
/// is more exact, or where the chunks around a patch would fill the memory. A file whose scan
/// failed is not tried again.
class PointParts {
public:
    using Report = std::function<void(std::size_t file, const store::PointCounts& met, bool whole)>;
    /// @param report is called with the counts of each part, or of the whole file when it was
    /// scanned
    PointParts(std::vector<PartedFile> files, const LoadContext& context, IndexFolders folders,
               std::size_t memory_bytes, int threads, Report report);

    /// Whether reading parts pays off: an index maps the points, and with these less than half of
    /// the file will have been decoded.
    [[nodiscard]] bool are_enough(std::size_t file, const grid::PatchRect& wanted);
    /// @throws Error for a damaged file
    [[nodiscard]] Squares around(std::size_t file, const grid::PatchRect& wanted);
    /// Whether it is known which parts of the file hold which points, without a scan. Never blocks.
    [[nodiscard]] bool knows(std::size_t file) const noexcept {
        return m_files[file].source->spatial_index != nullptr || m_states[file]->learnt;
    }
    /// Stores the chunk index that decoding the whole file has produced.
    void learn(std::size_t file, store::ChunkIndex index);

private:
    struct State {
        std::atomic<std::uint64_t> decoded{0};  ///< points, in parts
        std::mutex index_mutex;                 ///< guards chunks, and that only one thread scans
        std::shared_ptr<const store::ChunkIndex> chunks;
        std::atomic<bool> learnt{false};  ///< chunks is set
        std::string failed;               ///< why the scan of the file failed
        std::mutex choosing;              ///< guards by_chunk
        std::optional<bool> by_chunk;     ///< nullopt: not chosen yet
    };
    /// A chunk by its first point, or a block by its place.
    struct PartKey {
        std::size_t file;
        grid::PatchKey part;
        friend bool operator==(const PartKey&, const PartKey&) = default;
    };
    struct PartKeyHash {
        std::size_t operator()(const PartKey& k) const noexcept {
            return grid::PatchKeyHash{}(k.part) * 1000003 + k.file;
        }
    };
    [[nodiscard]] static PartKey chunk_key(std::size_t file,
                                           const pointcloud::PointRange& chunk) noexcept {
        return {file,
                {static_cast<std::int32_t>(chunk.begin & 0xFFFFFFFF),
                 static_cast<std::int32_t>(chunk.begin >> 32)}};
    }

    [[nodiscard]] bool prefers_chunks(std::size_t file);
    [[nodiscard]] bool by_chunk(std::size_t file);
    [[nodiscard]] PartKey to_block(std::size_t file, const grid::PatchRect& wanted) const noexcept;
    [[nodiscard]] grid::PatchRect list_patches(const PartKey& block) const noexcept;
    [[nodiscard]] std::uint64_t points_to_decode(std::size_t file, const grid::PatchRect& wanted);
    [[nodiscard]] std::vector<pointcloud::PointRange> chunks_over(std::size_t file,
                                                                  const grid::PatchRect& wanted);
    [[nodiscard]] Squares load_chunks(std::size_t file, const grid::PatchRect& wanted);
    [[nodiscard]] std::shared_ptr<const store::Square> block(const PartKey& key);
    [[nodiscard]] std::vector<pointcloud::PointRange> ranges_over(std::size_t file,
                                                                  const grid::PatchRect& wanted);
    /// A rectangle in the frame's CRS.
    struct Extent {
        double min_x;
        double min_y;
        double max_x;
        double max_y;
    };
    [[nodiscard]] Extent measure_extent(const grid::PatchRect& rect) const noexcept;
    [[nodiscard]] std::shared_ptr<const store::ChunkIndex> chunk_index(std::size_t file, bool scan);
    [[nodiscard]] std::optional<store::ChunkIndex> find_index(const std::string& name) const;
    void put_index(const std::string& name, const store::ChunkIndex& index) const;

    const std::vector<PartedFile> m_files;
    const LoadContext m_context;
    const IndexFolders m_folders;
    const int m_threads;
    const Report m_report;
    std::vector<std::unique_ptr<State>> m_states;
    util::Cache<PartKey, store::Square, PartKeyHash> m_parts;
};

}  // namespace terravox::voxelize
