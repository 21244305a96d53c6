#pragma once

#include <string>

#include "common/voxel/world.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/farm/net/farm.pb.h"

namespace terravox::farm {

/// Everything that a worker needs for a picture except boxes: three texts, each sent once and
/// identified by its hash from then on.
struct PictureSpec {
    /// TOML: the fields that affect pixels, with the camera in voxels and the sun by its angles, so
    /// that no table on the worker's machine has an influence.
    std::string scene;
    std::string materials;  ///< TOML: the material file
    /// JSON: the world's metadata, without the definition of its CRS: positions are in voxels.
    std::string world;
};

/// @param scene that the view was made from
/// @throws Error when the material file cannot be read
[[nodiscard]] PictureSpec pack(const scene::Scene& scene, const voxel::WorldInfo& world);

/// A world as it is sent: the short name of its CRS is kept, for it is only compared with others;
/// no worker uses PROJ.
[[nodiscard]] std::string pack_world(const voxel::WorldInfo& world);
/// @return a world without the definition of a CRS, whatever the text contains
/// @throws Error for a text that is no world
[[nodiscard]] voxel::WorldInfo unpack_world(const std::string& text);

/// Makes the coordinator's view, bit for bit, except for names and paths.
/// @throws Error, UsageError for invalid texts
[[nodiscard]] shade::View unpack(const PictureSpec& spec, const voxel::WorldInfo& world);
/// The scene of a received specification.
/// @throws UsageError, also for one that names a file of this machine or one of its limits
[[nodiscard]] scene::Scene unpack_scene(const std::string& text);

/// Hash that identifies a text: 16 bytes.
[[nodiscard]] std::string state_hash(const std::string& content);

}  // namespace terravox::farm
