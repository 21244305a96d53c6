#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/scene/tile_size.hpp"

namespace terravox {

/// Everything about a picture but the world it is taken of. One TOML file, and every field a flag (scene_fields.hpp names them,
/// with units and ranges). Version 1.
struct Scene {
    struct Camera {
        double fov_deg = 40;  ///< vertical
        /// Without position and target the camera frames the whole world: from azimuth_deg, looking down by down_deg.
        double azimuth_deg = 225;  ///< where the camera stands, seen from the world's middle, clockwise from north
        double down_deg = 35;
        double margin = 0.04;  ///< free border around the framed world, share of the picture
        double zoom = 1;       ///< above 1: nearer than the frame asks
        std::optional<std::array<double, 3>> position, target;
        std::string space = "crs";  ///< of position and target: crs (easting, northing, height in m), latlon (lat, lon, height in m) or voxel (x, y, z)
        bool inside_rock = false;   ///< allow a camera inside a solid voxel
    } camera;
    struct Sun {
        std::string date = "2026-06-21";
        double time_h = 16;
        std::optional<double> utc_offset_h;  ///< default: the zone of the place's longitude
        std::optional<double> altitude_deg, azimuth_deg;  ///< both: override date and time
        double strength = 1;
    } sun;
    struct Sky {
        double strength = 1;
        double visibility_km = 100;  ///< distance at which haze swallows all but 5 % of the contrast
    } sky;
    struct Output {
        std::array<int, 2> size_px = {1280, 720};
        double exposure_ev = 0;
        std::string tone = "photographic";  ///< photographic or linear, for 8-bit pictures
    } output;
    struct Quality {
        int samples = 4;  ///< per pixel
        int level = 0;    ///< finest level of the boxes
        double detail = 1;  ///< pixels that a voxel may cover at most, where coarser levels are used; 0: only `level`
        int coarse_step = 8;  ///< the first pass traces one of step x step pixels; 1 = a single pass
        TileSize tile;
        std::string tile_order = "spiral";
        bool shadows = true, ambient_occlusion = true, reflections = true;
        std::string colour = "mix";  ///< material, true, or mix
        double colour_mix = 0.85;    ///< share of the true colour for mix
    } quality;
    struct Processing {
        int threads = 0;  ///< 0 = one for each core
        int memory_mib = 2048;  ///< boxes in memory
        int box_patience_s = 300;  ///< after which a box of a voxel server is given up
    } processing;
    struct World {
        std::string crs, classes = "asprs", vertical_unit, settings;
        double voxel_m = 1;
        int memory_mib = 4096;  ///< decoded squares and columns
    } world;
};

}  // namespace terravox
