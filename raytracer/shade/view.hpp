#pragma once

#include "common/voxel/material.hpp"
#include "raytracer/scene/camera.hpp"
#include "raytracer/scene/scene.hpp"
#include "raytracer/shade/sky.hpp"
#include "raytracer/walk/level_cut.hpp"

namespace terravox {

/// What is common to all rays of a picture. Immutable and shared by all processors.
struct View {
    Scene scene;
    Camera camera;
    Sky sky;
    voxel::Palette palette;
    LevelCut cut;        ///< which boxes are looked at
    double voxel_m = 1;  ///< edge of a level-0 voxel
};

}  // namespace terravox
