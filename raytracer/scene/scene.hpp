#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/core/scene_words.hpp"
#include "raytracer/scene/tile_size.hpp"
#include "voxelserver/worlds/kind/procedural_settings.hpp"

namespace terravox::scene {

/// Everything about a picture but the world it is taken of. One TOML file, and every field a flag
/// (scene_fields.hpp names them, with units and ranges). Version 1.
struct Scene {
    struct Camera {
        std::string look;  ///< a named view of config/views, which the fields given beside it
                           ///< change; empty: none
        core::CameraProjection projection = core::CameraProjection::kPerspective;
        double fov_deg = 40;  ///< vertical; of a fisheye: across the picture's shorter side
        std::optional<double> height_m;  ///< orthographic and isometric: what the picture's height
                                         ///< covers; default: frames the world
        double aperture_m = 0;           ///< diameter of the lens; 0: everything is sharp
        std::optional<double> focus_m;  ///< distance that is sharp; default: that of the target, or
                                        ///< of the framed world's middle
        double roll_deg = 0;            ///< the camera's turn about its line of sight, clockwise
        /// Without position and target the camera frames the whole world: from azimuth_deg, looking
        /// down by down_deg.
        double azimuth_deg =
            225;  ///< where the camera stands, seen from the world's middle, clockwise from north
        double down_deg = 35;
        double margin = 0.04;  ///< free border around the framed world, share of the picture
        double zoom = 1;       ///< above 1: nearer than the frame asks
        std::optional<std::array<double, 3>> position, target;
        core::CoordinateSpace space = core::CoordinateSpace::kCrs;  ///< of position and target
        bool inside_rock = false;  ///< allow a camera inside a solid voxel
        friend bool operator==(const Camera&, const Camera&) = default;
    } camera;
    struct Sun {
        std::string date = "2026-06-21";
        double time_h = 16;
        std::optional<double>
            utc_offset_h;  ///< default: the zone, else the zone of the place's longitude
        std::string zone;  ///< IANA name, such as Europe/Ljubljana; empty: by utc_offset_h
        std::optional<double> altitude_deg, azimuth_deg;  ///< both: override date and time
        double strength = 1;
        double size = 1;  ///< radius of the disc, times the true one; 0: a point, with hard shadows
        std::optional<std::array<double, 3>> light;  ///< instead of the atmosphere's: linear R, G,
                                                     ///< B of a white surface that faces it
        friend bool operator==(const Sun&, const Sun&) = default;
    } sun;
    struct Sky {
        core::SkyModel model = core::SkyModel::kAtmosphere;
        std::optional<std::array<double, 3>>
            colour;              ///< of the uniform sky, linear R, G, B; default 1, 1, 1
        double turbidity = 2.5;  ///< of the air: 2 very clear, 3 clear, 6 hazy
        std::optional<double>
            visibility_km;  ///< distance at which haze leaves 5 % of the contrast; default: by
                            ///< turbidity; 0: no air before things
        double clouds = 0;  ///< share of the sky that they cover
        double cloud_height_m = 1500;  ///< above the lowest voxel of the world
        double strength = 1;
        friend bool operator==(const Sky&, const Sky&) = default;
    } sky;
    struct Output {
        std::array<int, 2> size_px = {1280, 720};
        double exposure_ev = 0;    ///< on top of what adaptation gives
        double adaptation = 0.75;  ///< share of the daylight's want that the exposure makes up: 0
                                   ///< as at noon, 1 as bright as by day
        core::ToneCurve tone = core::ToneCurve::kPhotographic;  ///< of 8-bit pictures
        core::PictureLayers layers = core::PictureLayers::kBeauty;
        core::TiffSamples tiff = core::TiffSamples::kAuto;
        bool denoise = false;
        bool credit =
            false;  ///< a line with the data's attribution at the lower edge of 8-bit pictures
        friend bool operator==(const Output&, const Output&) = default;
    } output;
    struct Quality {
        core::Integrator integrator = core::Integrator::kDirect;
        int samples = 4;       ///< per pixel; with noise: at most
        double noise = 0;      ///< a pixel is done when its mean is known this well, share of its
                               ///< brightness; 0: all samples everywhere
        int min_samples = 16;  ///< before that is asked
        double time_s = 0;  ///< goes on with samples as long as this; 0: until `samples` are done
        int seed = 0;       ///< of the noise
        int bounces = 6;    ///< of a path; of mirrors in direct light
        double clamp = 16;  ///< most light that one indirect sample of a path brings, at the
                            ///< picture's exposure; 0: no limit
        int level = 0;      ///< finest level of the boxes
        double detail = 1;  ///< pixels that a voxel may cover at most, where coarser levels are
                            ///< used; 0: only `level`
        int coarse_step =
            8;  ///< the first pass traces one of step x step pixels; 1 = a single pass
        TileSize tile;
        core::TileOrder tile_order = core::TileOrder::kSpiral;
        bool shadows = true, ambient_occlusion = true, reflections = true, refraction = true;
        int ao_rays =
            0;  ///< ambient-occlusion rays for each hit; 0: corners are darkened without rays
        double ao_range_m = 40, ao_strength = 1;
        std::string materials;  ///< another material file: NAME for config/materials-NAME.toml, or
                                ///< a path; empty: config/materials.toml
        bool textures = true;   ///< what is drawn on the faces of voxels
        bool cut_outs = true;   ///< holes between leaves
        core::VoxelColour colour = core::VoxelColour::kMix;
        double colour_mix = 0.85;  ///< share of the true colour for mix
        friend bool operator==(const Quality&, const Quality&) = default;
    } quality;
    struct Processing {
        std::optional<int>
            threads;  ///< of this machine; default: one for each core; 0: none, workers render
        int memory_mib = 2048;    ///< boxes in memory
        int box_timeout_s = 300;  ///< after which a box of a voxel server is given up
        friend bool operator==(const Processing&, const Processing&) = default;
    } processing;
    struct World {
        std::string crs, classes = "asprs", vertical_unit, settings;
        std::string steps;  ///< of voxelization, over what `settings` says; empty: no change
        double voxel_m = 1;
        int memory_mib = 4096;                ///< decoded squares and columns
        std::string dimension = "overworld";  ///< of a Minecraft world
        std::optional<double>
            base_m;  ///< rasters of heights: rock down to here; default: a little below the lowest
        friend bool operator==(const World&, const World&) = default;
    } world;
    procedural::Settings generated;  ///< but for seed and voxel_m, which come from elsewhere
    friend bool operator==(const Scene&, const Scene&) = default;
};

}  // namespace terravox::scene
