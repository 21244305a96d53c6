#pragma once

#include <string>

#include "common/net/farm.pb.h"
#include "common/voxel/world.hpp"
#include "raytracer/shade/view.hpp"

namespace terravox {

/// All that a worker must know of a picture, but for boxes: three texts, each sent once and known by its hash from then on.
struct Parcel {
    std::string scene;      ///< TOML: what shows, with the camera in voxels and the sun by its angles, so that no table of the worker's machine has a say
    std::string materials;  ///< TOML: the material file
    std::string world;      ///< JSON: what is known of the world
};

/// @param scene that the view was made of @throws Error when the material file cannot be read
[[nodiscard]] Parcel pack(const Scene& scene, const voxel::WorldInfo& world);

/// The view that the coordinator has, bit by bit, but for names and paths. @throws Error, UsageError for texts from anywhere
[[nodiscard]] View unpack(const Parcel& parcel, const voxel::WorldInfo& world);
/// The scene of a parcel. @throws UsageError
[[nodiscard]] Scene unpack_scene(const std::string& text);

/// A text's name: 16 bytes.
[[nodiscard]] std::string state_hash(const std::string& content);

}  // namespace terravox
