#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "raytracer/apps/pmtiles/map_tiles.hpp"
#include "raytracer/core/output/tile_stream.hpp"

namespace terravox::commands {

/// How the file of a map is written.
struct MapFileOptions {
    std::filesystem::path file;  ///< .tif, .tiff or .pmtiles
    pmtiles::TileFormat tiles = pmtiles::TileFormat::kWebp;
    int threads = 1;
    bool quiet = false;                ///< shows no progress
    pmtiles::WebArea area;             ///< of .pmtiles
    std::function<bool()> is_stopped;  ///< asked now and then, in any thread

    [[nodiscard]] bool in_tiles() const;
};

/// @throws UsageError for another ending; Error where the file cannot be written, or its tiles
/// cannot be made here
void check_map_target(const MapFileOptions& options);

/// Writes the file of a map: collects finished tiles of the picture in a temporary file next to it,
/// which is removed in the end. Not thread-safe.
class MapFile {
public:
    /// @param shape whose tiles have a multiple of 16 pixels
    /// @throws Error when the temporary file cannot be written
    MapFile(MapFileOptions options, const output::StreamShape& shape,
            const output::PictureInfo& info);
    [[nodiscard]] output::TileSink& sink() noexcept { return *m_stream; }
    /// Writes the target from the finished picture.
    /// @param texts of a PMTiles archive, and holes
    /// @return how many tiles a PMTiles archive has; 0 for a GeoTIFF
    /// @throws Error, also "interrupted"
    std::uint64_t write(const pmtiles::MapTexts& texts);

private:
    /// Writes the picture with overviews, and removes it.
    void write_overviews(const std::filesystem::path& to);

    MapFileOptions m_options;
    std::optional<util::AtomicFile> m_picture;  ///< never committed: its destructor removes it
    std::unique_ptr<output::TileStream> m_stream;
};

}  // namespace terravox::commands

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `map` to the program's commands: a world from above, as a GeoTIFF or as tiles for the web.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_map_command(CLI::App& app);

}  // namespace terravox::commands
