#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/data/grid/frame.hpp"
#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/data/grid/square_names.hpp"
#include "voxelserver/data/imagery/pixel_map.hpp"
#include "voxelserver/data/imagery/raster.hpp"

namespace terravox::imagery {

/// Orthophotos of an area, in any format, CRS and resolution that GDAL reads. Thread-safe: files
/// are read one at a time, pixels are averaged in parallel.
///
/// Where images overlap, each column takes its colour from the first image that has data there, in
/// this order, which does not depend on the order of `paths` or of a folder: finer pixels first
/// (rounded to a millimetre), then the newer date (TIFFTAG_DATETIME, EXIF; no date counts as
/// oldest), then the file's name, then its path. Near infrared is taken in the same order from the
/// images that have it. For the assignment of bands see band_roles.hpp. Nodata values, alpha and
/// mask bands are respected.
///
/// Values that are no bytes become brightness as the file states (NBITS, or a scale and an offset
/// to about 1), else by the values that all such images have: one scale for all of them, whatever
/// is read. What was assumed is logged in one line, as a warning where other readings are about as
/// likely.
class Orthophotos {
public:
    /// @param paths image files or folders of them
    /// @param squares those of the world whose place their names state: an image that is not
    /// georeferenced and is named like one of them lies on it
    /// @param same  the same images in another frame, which have logged what is assumed of them,
    /// and outlive these: their files count instead of paths, which may be folders that have got
    /// more; nullptr: none
    /// @throws Error naming the file that is missing, not an image, not georeferenced, or has more
    /// than 4096 pixels per voxel edge; ChangedError where it is another than that of `same`
    Orthophotos(const std::vector<std::filesystem::path>& paths, const grid::Frame& frame,
                std::span<const grid::NamedSquare> squares = {}, const Orthophotos* same = nullptr);
    /// Warns of images of which all that was read is black, also by others that were made with
    /// these as `same`.
    ~Orthophotos();

    /// Logs one message for all images that lie outside the world, naming one of them, its
    /// location, and the assumption made when it has no CRS. It is a warning only when no image
    /// covers the world or the location of one is such an assumption: folders often cover a larger
    /// area.
    /// @param world the columns in which there may be points
    void warn_of_outside(const grid::ColumnRect& world) const;

    [[nodiscard]] std::size_t count() const noexcept;
    /// The paths of the images, in order of precedence.
    [[nodiscard]] std::vector<std::filesystem::path> order() const;

    /// The identity of an image, and the columns outside of which it has no influence. inputs()
    /// returns them in order of precedence.
    struct Input {
        grid::ColumnRect rect;
        voxel::Fingerprint identity{};  ///< image_files.hpp, and how its values are read
        /// Images of one series may be of one survey: their pixels differ by a tenth at most, and
        /// they are dated in the same year, or not at all.
        std::size_t series = 0;
    };
    [[nodiscard]] std::vector<Input> inputs() const;

    /// Step "orthophoto load": reads the images' values for each column; a column's value does not
    /// depend on the requested rectangle.
    /// @param x0, z0 absolute voxel of the first column
    /// @param width, height [1, 65536]; the result has width x height columns
    /// @throws Error naming the damaged file
    [[nodiscard]] Raster read(std::int32_t x0, std::int32_t z0, int width, int height) const;
    /// The same for one image alone.
    /// @param image its index in inputs()
    [[nodiscard]] Raster read_image(std::size_t image, const ColumnRect& rect) const;

private:
    struct Layer;
    struct OpenFiles;
    void find_series();
    void add_read(const Image& image) const;
    void judge_scales();
    void assume(bool whole_numbers);
    template <class Test>
    void warn_of_some(std::string_view what, const Test& is_such) const;
    void add_layer(std::size_t index, const ColumnRect& whole, Raster& raster) const;
    const grid::Frame m_frame;
    std::vector<std::unique_ptr<Layer>> m_layers;
    std::unique_ptr<OpenFiles> m_open;
    const Orthophotos* const m_same;
};

}  // namespace terravox::imagery
