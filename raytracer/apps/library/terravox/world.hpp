#pragma once

#include <terravox/api.hpp>
#include <terravox/control.hpp>
#include <terravox/grids.hpp>
#include <terravox/picture.hpp>
#include <terravox/place.hpp>
#include <terravox/rays.hpp>
#include <terravox/sources.hpp>

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace terravox {

struct WorldState;

struct OpenOptions {
    std::string crs;                ///< instead of that of the files; empty: theirs
    std::string classes;            ///< table of LiDAR classes: its name, or a path; empty: auto
    std::optional<double> voxel_m;  ///< edge of a voxel of LiDAR data and heights; nullopt: 1
    std::vector<std::string> orthophotos;  ///< images, or folders of them
    /// Planned objects that are put into the world, as `--add` of the command line takes them.
    std::vector<std::string> additions;
    /// Folder that keeps prepared LiDAR squares for the next time; empty: the user's own;
    /// "none": nothing is kept.
    std::string cache;
    /// Further fields of the sections world, generated and processing of a scene, as on the command
    /// line: {"processing.memory_mib", "512"}.
    std::vector<std::pair<std::string, std::string>> fields;
};

/// What `terravox analyse KIND` measures.
struct AnalysisOptions {
    /// As the command has them; sun with analysis.from and analysis.to: of a period. Also
    /// sun-months (of a period) and shadow (at sun.time_h).
    std::string kind;
    std::optional<MapBounds> area;       ///< its heights are ignored; nullopt: all
    std::optional<double> resolution_m;  ///< edge of a cell; nullopt: that of a voxel
    std::optional<int> level;  ///< nullopt: the coarsest whose voxels are no larger than a cell
    /// Of kind sight: easting, northing, height of the observers, map coordinates.
    std::vector<std::array<double, 3>> observers;
    std::string weather;  ///< of kind energy: an EPW file; empty: a clear sky
    /// Of kinds sky, sun and energy: a raster of heights around the data, whose hills hide sun and
    /// sky up to 60 km away; empty: the horizon is free there.
    std::string horizon;
    /// Fields of a scene: {"sun.date", "2026-06-21"}, {"analysis.from", ...}, ...
    SceneText scene;
    int threads = 0;  ///< 0: one for each core
};

struct ConvertOptions {
    std::string format;  ///< name of a format of `terravox convert`; empty: by the file's ending
    int level = 0;
    std::optional<MapBounds> area;
    bool overwrite = false;
    int threads = 0;  ///< 0: one for each core
};

struct ConvertReport {
    std::vector<std::string> files;
    std::uint64_t voxels = 0;
    std::size_t holes = 0;  ///< boxes that could not be read, and are missing
};

/// A world of voxels: LiDAR data, rasters of heights, Minecraft and Luanti worlds, archives of
/// boxes, addresses of voxel servers, or a source of one's own. Boxes are read when they are
/// needed, and kept in memory up to a limit (field processing.memory_mib). Copies share one world.
/// All functions may be called from several threads at once. They throw terravox::Error, and
/// std::bad_alloc where memory is missing. Numbers of threads are 0 (one for each core) to 1024.
class TERRAVOX_API World {
public:
    /// @param inputs paths or addresses of one kind; several only of LiDAR data and heights
    /// @param control only `stop` is used
    /// @throws UsageError, Error
    [[nodiscard]] static World open(const std::vector<std::string>& inputs,
                                    const OpenOptions& options = {}, const Control& control = {});
    /// A world of one's own.
    [[nodiscard]] static World of(std::shared_ptr<VoxelSource> source,
                                  const OpenOptions& options = {});
    /// Voxelizes points of one's own. They are kept in a temporary file until the world is closed,
    /// since voxelization reads them in an order of its own.
    [[nodiscard]] static World voxelize(PointSource& points, const OpenOptions& options = {},
                                        const Control& control = {});

    [[nodiscard]] const WorldInfo& info() const noexcept;
    /// The data's faults met so far, one line each. What they concern is missing in every result.
    [[nodiscard]] std::vector<std::string> damage() const;

    /// The smallest block of voxels that covers bounds, cut to where anything is.
    /// @throws UsageError for a level that the world does not have, and where nothing is left
    [[nodiscard]] VoxelBlock block_of(const std::optional<MapBounds>& bounds, int level = 0) const;
    /// Materials of all voxels of a block, at most 2^32 of them.
    [[nodiscard]] VoxelGrid voxels(const VoxelBlock& block, int threads = 0,
                                   const Control& control = {}) const;
    /// Heights of the upper faces of the highest voxels, one band `height`: what rays from above
    /// meet.
    [[nodiscard]] Raster surface(const std::optional<MapBounds>& area = std::nullopt, int level = 0,
                                 int threads = 0, const Control& control = {}) const;

    /// The first voxel that each ray meets. Distances are exact, whatever the number of threads.
    /// @param origins, directions easting, northing and height of each ray, one after the other;
    /// directions need not be of unit length
    [[nodiscard]] RayHits cast(std::span<const double> origins, std::span<const double> directions,
                               const CastOptions& options = {}, const Control& control = {}) const;
    /// Whether each ray meets anything within its range.
    [[nodiscard]] Occlusion occluded(std::span<const double> origins,
                                     std::span<const double> directions,
                                     const CastOptions& options = {},
                                     const Control& control = {}) const;

    /// Renders a picture. It does not depend on the number of threads.
    /// @param threads 0: one for each core
    [[nodiscard]] Picture render(const SceneText& scene, int threads = 0,
                                 const Control& control = {}) const;
    [[nodiscard]] Raster analyse(const AnalysisOptions& options, const Control& control = {}) const;
    /// Writes the world, or a part of it, in another format.
    /// @throws UsageError when something is there that is not to be replaced
    ConvertReport convert(const std::string& out, const ConvertOptions& options = {},
                          const Control& control = {}) const;

private:
    friend class Server;
    explicit World(std::shared_ptr<WorldState> state) : m_state(std::move(state)) {}
    std::shared_ptr<WorldState> m_state;
};

}  // namespace terravox
