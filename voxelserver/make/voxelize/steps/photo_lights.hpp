#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"
#include "voxelserver/data/store/square_folder.hpp"
#include "voxelserver/data/sunlight/flight_light.hpp"
#include "voxelserver/data/sunlight/light_removal.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"
#include "voxelserver/make/voxelize/steps/photo_light.hpp"
#include "voxelserver/make/voxelize/steps/photo_mosaic.hpp"

namespace terravox::voxelize {

/// What is highest in each column, as a surface that casts shadows. Thread-safe.
class PhotoSurface {
public:
    /// Points must outlive this.
    explicit PhotoSurface(PointSet& points);

    /// Patches and a margin of patches around them, without gaps. In the patches and
    /// `kFilledTogether` cells around them, which are photographed, gaps are filled from all
    /// sides. Farther away, where the surface only casts shadows, small gaps are filled within
    /// each patch, once for all patches around, and wide ones cast no shadow.
    /// @param margin in patches, at least 1
    /// @throws Error naming a damaged file
    [[nodiscard]] sunlight::Surface around(const grid::PatchRect& patches, int margin);
    static constexpr int kFilledTogether = sunlight::kEdgeReach;

private:
    struct PatchTops {
        sunlight::Surface seen;   ///< with gaps
        sunlight::Surface casts;  ///< small gaps are filled, wide ones very low
    };
    using Part = sunlight::Surface PatchTops::*;
    [[nodiscard]] sunlight::Surface assembled(const grid::PatchRect& patches, int margin,
                                              Part part);
    [[nodiscard]] std::shared_ptr<const PatchTops> find_tops(grid::PatchKey key);
    [[nodiscard]] static PatchTops casting(sunlight::Surface seen);

    PointSet& m_points;
    double m_voxel_m;
    std::shared_ptr<const PatchTops> m_nothing;  ///< of a patch in which nothing was seen
    util::Cache<grid::PatchKey, PatchTops, grid::PatchKeyHash> m_tops;
};

/// Where lights that were found are kept for later worlds.
struct KeptLights {
    store::SquareFolder* folder = nullptr;  ///< nullptr: nowhere
    /// Of all that columns of points depend on besides their files.
    voxel::Fingerprint everywhere{};
};

/// Step "photo light": takes sun, shadow and sky out of the colours of images. The light of an
/// image is found when a column first needs it (step "photo light search"), from a sample
/// (photo_sample) of the image and of the points beneath: a function of these inputs, whatever is
/// asked for first. Exposure is that of all photographs of its flight among exposure_images().
/// Between the middles of images that may be of one flight it is blended
/// (PhotoMosaic), so that they join without a seam. Thread-safe.
class PhotoLights {
public:
    /// Images, points, times and a folder must outlive this.
    PhotoLights(const imagery::Orthophotos& images, PointSet& points, util::StageTimes& times,
                const KeptLights& kept = {});

    /// The images' values for a patch, with albedo as colours; `nir` and `red` are as in the image,
    /// since their ratio counts. Depends on the points within shadow_patches() around.
    /// @throws Error naming a damaged file
    [[nodiscard]] imagery::Raster albedo(grid::PatchKey key);

    /// By the exposure of its flight. Logged once.
    /// @param image its index in Orthophotos::inputs()
    /// @throws Error naming a damaged file
    [[nodiscard]] PhotoLight make_light(std::size_t image);

    /// What the colours of an image in a patch are divided by: its light and that of images of the
    /// same flight around it.
    /// @param image one whose sun is known
    /// @throws Error naming a damaged file
    [[nodiscard]] sunlight::LightField light_over(std::size_t image, grid::PatchKey key);

private:
    [[nodiscard]] sunlight::FlightLight light_at(std::size_t image, std::int32_t x, std::int32_t z);
    /// Of an image alone, before exposure is corrected.
    [[nodiscard]] std::shared_ptr<const PhotoLight> own_light(std::size_t image);
    [[nodiscard]] sunlight::Exposure flight_exposure(std::size_t image);
    [[nodiscard]] PhotoLight known_or_found(std::size_t image);
    void mark_covers(const grid::PatchRect& block, sunlight::Scene& scene);
    [[nodiscard]] PhotoLight find_light(std::size_t image, const PhotoSample& sample);

    const imagery::Orthophotos& m_images;
    const std::vector<imagery::Orthophotos::Input> m_inputs;
    const std::vector<std::filesystem::path> m_paths;
    PointSet& m_points;
    util::StageTimes& m_times;
    KeptLights m_kept;
    int m_around;
    PhotoMosaic m_mosaic;
    ExposureImages m_exposure_images;
    PhotoSurface m_surface;
    util::Cache<std::size_t, PhotoLight> m_own_lights;
    util::Cache<std::size_t, PhotoLight> m_lights;
};

}  // namespace terravox::voxelize
