#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "raytracer/core/output/picture.hpp"

namespace terravox::output {

/// Properties of a picture of one pass that are known before it is rendered.
struct StreamShape {
    int width_px = 0;
    int height_px = 0;
    /// Edge of the plan's tiles; those at the right and lower border may be smaller.
    int tile_px = 0;
    bool with_layers = false;
};

/// Whether a film of this size would take more than `limit_bytes`, so that the picture must be
/// streamed.
[[nodiscard]] bool must_stream(const StreamShape& shape, std::uint64_t limit_bytes) noexcept;
/// The least processing.memory_mib with which the picture need not be streamed: its film takes half
/// of it.
[[nodiscard]] std::uint64_t memory_to_keep_mib(const StreamShape& shape) noexcept;
/// @throws UsageError for a file that only a film can be written to, neither .exr nor .tif, or a
/// .tif whose tiles are no multiple of 16
void check_can_stream(const std::filesystem::path& file, const StreamShape& shape);

/// A picture larger than memory: tiles are written to the file as they arrive, in any order, and
/// are not kept. EXR has the same channels as from write_image, in tiles in order of arrival; TIFF
/// is a BigTIFF in tiles (a GeoTIFF where `info` has a place), with samples by
/// PictureInfo::tiff_samples, without overviews. The file appears under its name when it is
/// complete. Not thread-safe.
class TileStream final : public TileSink {
public:
    /// @throws UsageError as check_can_stream or where the tile size is no multiple of what the
    /// format needs; Error when the file cannot be written
    TileStream(const std::filesystem::path& file, const StreamShape& shape, PictureInfo info);
    ~TileStream() override;

    /// @param result of a plan with a single pass (quality.coarse_step 1), each tile once
    void add(const tiles::TileResult& result) override;
    /// Completes the file; no tile may be added afterwards.
    /// @param holes known only now: stored as "terravox:holes" (EXR) or "terravox_holes" (TIFF)
    /// @throws Error when tiles are missing, or the file cannot be finished
    void finish(std::uint64_t holes);

    /// How one format takes tiles.
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

/// Edge of the tiles in the file: that of the plan's tiles or a divisor of it, so that each of
/// those fills whole tiles of the file.
[[nodiscard]] int file_tile_px(int tile_px, int multiple_of) noexcept;

}  // namespace terravox::output
