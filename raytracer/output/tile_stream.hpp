#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "raytracer/output/picture_info.hpp"
#include "raytracer/output/tile_sink.hpp"

namespace terravox::output {

/// What a picture of one pass is like before it is rendered.
struct StreamShape {
    int width_px = 0, height_px = 0;
    int tile_px =
        0;  ///< edge of the plan's tiles; those at the right and lower border may be smaller
    bool with_layers = false;
};

/// Whether a film of this size would take more than `limit_bytes`, so that the picture must be
/// streamed.
[[nodiscard]] bool must_stream(const StreamShape& shape, std::uint64_t limit_bytes) noexcept;
/// The least processing.memory_mib with which the picture need not be streamed: its film takes half
/// of it.
[[nodiscard]] std::uint64_t memory_to_keep_mib(const StreamShape& shape) noexcept;
/// @throws UsageError for a file that only a film can be written to, neither .exr nor .tif, or a
/// .tif whose tiles would be no multiple of 16
void check_can_stream(const std::filesystem::path& file, const StreamShape& shape);

/// A picture larger than memory: tiles go to the file as they come, in any order, and are
/// forgotten. EXR has the channels that write_image gives it, in tiles that stand in the file as
/// they came; TIFF is a BigTIFF in tiles (a GeoTIFF where `info` has a place), with samples as
/// PictureInfo::tiff_samples says, without overviews. The file appears under its name when all is
/// done. Not thread-safe.
class TileStream final : public TileSink {
public:
    /// @throws UsageError as check_can_stream or where tiles are no multiple of what the format
    /// needs; Error when it cannot be written
    TileStream(const std::filesystem::path& file, const StreamShape& shape, PictureInfo info);
    ~TileStream() override;
    TileStream(const TileStream&) = delete;
    TileStream& operator=(const TileStream&) = delete;

    /// @param result of a plan with a single pass (quality.coarse_step 1), each tile once
    void add(const tiles::TileResult& result) override;
    /// What is known only now: stored as "terravox:holes" (EXR) or "terravox_holes" (TIFF). Nothing
    /// may be added any more.
    /// @throws Error when tiles are missing, or the file cannot be finished
    void finish(std::uint64_t holes);

    /// One format's way to take tiles.
    class Format {
    public:
        virtual ~Format() = default;
        virtual void write(const tiles::TileResult& result) = 0;
        virtual void finish(std::uint64_t holes) = 0;
    };

private:
    void check_tile(const tiles::RenderTile& tile);
    StreamShape m_shape;
    std::vector<bool> m_done;  ///< by column and row of the tile
    std::uint64_t m_left;
    std::unique_ptr<Format> m_format;
};

}  // namespace terravox::output
