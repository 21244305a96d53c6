#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/grid/frame.hpp"
#include "voxelserver/grid/patch.hpp"
#include "voxelserver/imagery/raster.hpp"

namespace terravox::imagery {

/// Orthophotos of an area, any format, CRS and resolution that GDAL reads. Thread-safe: files are
/// read one at a time, pixels are averaged side by side.
///
/// Where images overlap, each column takes its colour from the first image that has data there, in
/// this order, which does not depend on the order of `paths` or of a folder: finer pixels first
/// (rounded to a millimetre), then the newer date (TIFFTAG_DATETIME, EXIF; none is oldest), then
/// the file's name, then its path. Near infrared is taken in the same order from the images that
/// have it. Which band is what: bands.hpp. Nodata values, alpha and mask bands are respected.
class Orthophotos {
public:
    /// @param paths image files or folders of them
    /// @throws Error naming the file that is missing, no image, without a place on Earth, or has
    /// more than 4096 pixels to a voxel's edge
    Orthophotos(const std::vector<std::filesystem::path>& paths, const grid::Frame& frame);
    ~Orthophotos();

    /// Warns, in one line for all of them, of images that lie beside the world, naming the first,
    /// where it lies, and what was assumed of it. No more than a remark when others do cover it,
    /// and those beside it say themselves where they lie: folders reach farther.
    /// @param world the columns in which there may be points
    void warn_of_outside(const grid::ColumnRect& world) const;

    [[nodiscard]] std::size_t count() const noexcept;
    /// The images' paths, the one that wins first.
    [[nodiscard]] std::vector<std::filesystem::path> order() const;

    /// What each image is, and the columns outside which nothing depends on it; the one that wins
    /// first.
    struct Input {
        grid::ColumnRect rect;
        voxel::Fingerprint identity{};  ///< image_identity.hpp
    };
    [[nodiscard]] std::vector<Input> inputs() const;

    /// Step "orthophoto load": what the images show in each column; the same for a column in
    /// whatever rectangle it is asked.
    /// @param x0, z0 absolute voxel of the first column  @param width, height [1, 65536]; the
    /// result has width x height columns
    /// @throws Error naming the damaged file
    [[nodiscard]] Raster read(std::int32_t x0, std::int32_t z0, int width, int height) const;

private:
    struct Layer;
    struct OpenFiles;
    const grid::Frame m_frame;
    std::vector<std::unique_ptr<Layer>> m_layers;
    std::unique_ptr<OpenFiles> m_open;
};

}  // namespace terravox::imagery
