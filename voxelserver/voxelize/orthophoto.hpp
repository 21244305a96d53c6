#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "voxelserver/voxelize/frame.hpp"
#include "voxelserver/voxelize/serialize.hpp"
#include "voxelserver/voxelize/square.hpp"

namespace terravox::voxelize {

/// Orthophotos of an area, any format, CRS and resolution that GDAL reads. Thread-safe (one reader at a time).
class Orthophotos {
public:
    /// @param paths image files or folders of them
    /// @throws Error for a missing file, one that is no image, or one without a place on Earth
    Orthophotos(const std::vector<std::filesystem::path>& paths, const Frame& frame);
    ~Orthophotos();

    [[nodiscard]] std::size_t count() const noexcept;

    /// Step "orthophoto load": the mean colour over each column of a patch. Where images overlap, the first named wins.
    /// @param x0, z0 absolute voxel of the patch's first column
    [[nodiscard]] PatchColours colours(std::int32_t x0, std::int32_t z0) const;

private:
    class Image;
    const Frame m_frame;
    std::vector<std::unique_ptr<Image>> m_images;
};

}  // namespace terravox::voxelize
