#pragma once

#include <string>

#include "common/voxel/world.hpp"
#include "raytracer/farm/net/farm.pb.h"
#include "raytracer/shade/view.hpp"

namespace terravox::farm {

/// All that a worker must know of a picture, but for boxes: three texts, each sent once and known
/// by its hash from then on.
struct PictureSpec {
    std::string scene;  ///< TOML: what shows, with the camera in voxels and the sun by its angles,
                        ///< so that no table of the worker's machine has a say
    std::string materials;  ///< TOML: the material file
    std::string world;  ///< JSON: what is known of the world, without the definition of its CRS:
                        ///< places are in voxels
};

/// @param scene that the view was made of @throws Error when the material file cannot be read
[[nodiscard]] PictureSpec pack(const scene::Scene& scene, const voxel::WorldInfo& world);

/// A world as a parcel has it: the short name of its CRS stays, for it is only compared with
/// others; no worker asks PROJ.
[[nodiscard]] std::string pack_world(const voxel::WorldInfo& world);
/// @return a world without the definition of a CRS, whatever the text says @throws Error for a text
/// that is no world
[[nodiscard]] voxel::WorldInfo unpack_world(const std::string& text);

/// The view that the coordinator has, bit by bit, but for names and paths. @throws Error,
/// UsageError for texts from anywhere
[[nodiscard]] shade::View unpack(const PictureSpec& parcel, const voxel::WorldInfo& world);
/// The scene of a parcel. @throws UsageError, also for one that names a file of this machine or one
/// of its limits
[[nodiscard]] scene::Scene unpack_scene(const std::string& text);

/// A text's name: 16 bytes.
[[nodiscard]] std::string state_hash(const std::string& content);

}  // namespace terravox::farm
