#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"
#include "voxelserver/data/sunlight/exposure.hpp"
#include "voxelserver/data/sunlight/flight_light.hpp"
#include "voxelserver/data/sunlight/sun.hpp"
#include "voxelserver/make/voxelize/points/sources.hpp"

namespace terravox::voxelize {

/// The part of an image from which its light is found.
struct PhotoSample {
    std::vector<grid::PatchRect> blocks;
    /// Files whose points count: they lie in or near a block. Indices into Sources::files, rising.
    std::vector<std::size_t> files;
};

/// Chooses up to nine blocks of about 128 m, spread evenly over one part of the image, about 1 km
/// wide: the one that files cover most of. So few files are decoded, however large the image is.
/// Reads nothing, and does not depend on how a survey was cut into files.
/// @param image the columns outside of which the image has no influence
/// @return no blocks where no file lies beneath
[[nodiscard]] PhotoSample photo_sample(const grid::ColumnRect& image, const Sources& sources);

/// An image and all that its light is found from, but for what columns of points depend on besides
/// their files.
/// @param sample of the image
/// @param identity of the image
[[nodiscard]] voxel::Fingerprint to_fingerprint(const PhotoSample& sample,
                                                const voxel::Fingerprint& identity,
                                                const Sources& sources);

/// The images from which exposure is found, by series (Orthophotos::Input), indices rising: all of
/// a series, of more than kExposureImages as many that lie anywhere in it. Mostly still the same
/// when images are added to a series or leave it.
using ExposureImages = std::map<std::size_t, std::vector<std::size_t>>;
[[nodiscard]] ExposureImages exposure_images(std::span<const imagery::Orthophotos::Input> images);
inline constexpr std::size_t kExposureImages = 9;

/// Within how many patches what casts a shadow on a patch is searched for: about 60 m, and at most
/// four.
[[nodiscard]] int shadow_patches(double voxel_m) noexcept;

/// The light of one image, and how it was found.
struct PhotoLight {
    sunlight::FlightLight light;
    sunlight::SunEstimate estimate;  ///< the best one, whether or not it is certain
    sunlight::Evidence evidence;     ///< by `light`, before exposure is corrected
};

/// For storage.
[[nodiscard]] std::string to_bytes(const PhotoLight& light);
/// @param bytes from any source
/// @return nullopt for bytes of another version, and for values that no search finds
[[nodiscard]] std::optional<PhotoLight> parse_photo_light(std::string_view bytes);

}  // namespace terravox::voxelize
