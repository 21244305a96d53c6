#pragma once

#include <limits>
#include <string_view>
#include <vector>

#include "raytracer/core/base/scene_words.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::scene {

/// What values a field of a scene may have.
struct FieldRule {
    std::string_view doc;  ///< one line of help with the unit
    /// Closed range, for numbers.
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    std::vector<std::string_view> words = {};  ///< allowed words, for text; empty = any
    std::string_view alias = {};               ///< a shorter flag in addition to --section-field
    std::string_view former = {};  ///< its path before it was renamed: still read, with a warning
};

/// The rule of a field that holds a value of an enumeration.
template <core::WordEnum Enum>
[[nodiscard]] std::vector<std::string_view> list_texts() {
    std::vector<std::string_view> out;
    for (const core::Word<Enum>& word : core::list_words(Enum{}))
        out.push_back(word.text);
    return out;
}

/// The only list of a scene's fields. Calls visit(path, field, rule) for each; `path` is
/// "section.field", as in TOML. File reader, command line, and writer are visitors, so a field
/// added here is supported by all of them. It is one long function because it is a table: its order
/// is that of files, flags and help.
template <class SceneType, class Visit>
void visit_fields(SceneType& s, Visit&& visit) {
    visit("camera.look", s.camera.look,
          FieldRule{"a named view of config/views, or a path", 0, 0, {}, "--look"});
    visit(
        "camera.projection", s.camera.projection,
        FieldRule{"camera projection", 0, 0, list_texts<core::CameraProjection>(), "--projection"});
    visit("camera.fov_deg", s.camera.fov_deg,
          FieldRule{
              "vertical field of view, degrees; of a fisheye up to 360, across the shorter side",
              1,
              360,
              {},
              "--fov"});
    visit("camera.height_m", s.camera.height_m,
          FieldRule{"orthographic, isometric: metres that the picture's height covers; default: "
                    "frames the world",
                    0.001, 1e7});
    visit("camera.aperture_m", s.camera.aperture_m,
          FieldRule{"diameter of the lens, metres; 0 = everything is sharp", 0, 10000});
    visit("camera.focus_m", s.camera.focus_m,
          FieldRule{"distance that is sharp, metres; default: the target's", 0.001, 1e7});
    visit("camera.roll_deg", s.camera.roll_deg,
          FieldRule{"turn about the line of sight, clockwise, degrees", -360, 360});
    visit("camera.azimuth_deg", s.camera.azimuth_deg,
          FieldRule{"where the framing camera stands, clockwise from north, degrees", -360, 360});
    visit("camera.down_deg", s.camera.down_deg,
          FieldRule{"how steeply the framing camera looks down, degrees", -30, 90});
    visit("camera.margin", s.camera.margin,
          FieldRule{"border around the framed world, share of the picture", 0, 0.45});
    visit("camera.zoom", s.camera.zoom,
          FieldRule{"zoom of the framing camera; above 1: nearer", 0.05, 50, {}, "--zoom"});
    visit("camera.position", s.camera.position,
          FieldRule{"where the camera is: a,b,c in camera.space; default: frames the world"});
    visit("camera.target", s.camera.target,
          FieldRule{"what the camera looks at: a,b,c in camera.space"});
    visit(
        "camera.space", s.camera.space,
        FieldRule{
            "of position and target: crs = E,N,height_m; latlon = lat,lon,height_m; voxel = x,y,z",
            0, 0, list_texts<core::CoordinateSpace>()});
    visit("camera.inside_rock", s.camera.inside_rock,
          FieldRule{"allow a camera inside a solid voxel"});
    visit("sun.date", s.sun.date, FieldRule{"YYYY-MM-DD", 0, 0, {}, "--date"});
    visit("sun.time_h", s.sun.time_h, FieldRule{"clock time, hours", 0, 24});
    visit("sun.utc_offset_h", s.sun.utc_offset_h,
          FieldRule{"clock time minus UTC, hours; default: sun.zone, else the zone of the place's "
                    "longitude",
                    -14, 14});
    visit("sun.zone", s.sun.zone,
          FieldRule{
              "IANA time zone with its summer time, such as Europe/Ljubljana", 0, 0, {}, "--zone"});
    visit("sun.altitude_deg", s.sun.altitude_deg,
          FieldRule{"with azimuth_deg instead of date and time, degrees", -90, 90});
    visit("sun.azimuth_deg", s.sun.azimuth_deg,
          FieldRule{"clockwise from north, degrees", -360, 360});
    visit("sun.strength", s.sun.strength, FieldRule{"times the natural light", 0, 100});
    visit("sun.size", s.sun.size,
          FieldRule{"radius of the disc, times the true 0.27 degrees; 0 = hard shadows", 0, 100});
    visit("sun.light", s.sun.light,
          FieldRule{
              "r,g,b of a white surface that faces the sun, linear, instead of the atmosphere's", 0,
              1e6});
    visit("sky.model", s.sky.model,
          FieldRule{"model of the sky's light", 0, 0, list_texts<core::SkyModel>()});
    visit("sky.colour", s.sky.colour,
          FieldRule{"r,g,b of the uniform sky, linear; default 1,1,1", 0, 1e6});
    visit("sky.turbidity", s.sky.turbidity,
          FieldRule{
              "haze of the whole air: 2 very clear, 3 clear, 6 hazy", 1.5, 10, {}, "--turbidity"});
    visit("sky.clouds", s.sky.clouds,
          FieldRule{"share of the sky that clouds cover", 0, 1, {}, "--clouds"});
    visit("sky.cloud_height_m", s.sky.cloud_height_m,
          FieldRule{"height of the clouds above the lowest ground, metres", 100, 12000});
    visit("sky.strength", s.sky.strength, FieldRule{"times the natural light", 0, 100});
    visit("sky.visibility_km", s.sky.visibility_km,
          FieldRule{"distance at which haze leaves 5 % of the contrast, km; 0 = no haze; default: "
                    "by turbidity",
                    0, 100000});
    visit("output.size", s.output.size_px,
          FieldRule{"picture size, WIDTHxHEIGHT in pixels", 1, 65536, {}, "--size"});
    visit(
        "output.exposure_ev", s.output.exposure_ev,
        FieldRule{
            "exposure compensation, stops, in addition to adaptation", -20, 20, {}, "--exposure"});
    visit(
        "output.adaptation", s.output.adaptation,
        FieldRule{
            "how far the exposure follows dusk and night: 0 = as at noon, 1 = as bright as by day",
            0, 1});
    visit("output.tone", s.output.tone,
          FieldRule{"tone curve of 8-bit pictures", 0, 0, list_texts<core::ToneCurve>(), "--tone"});
    visit("output.layers", s.output.layers,
          FieldRule{"of EXR files", 0, 0, list_texts<core::PictureLayers>(), "--layers"});
    visit(
        "output.tiff", s.output.tiff,
        FieldRule{
            "samples of TIFF files; auto: bytes of maps (straight down, orthographic), else floats",
            0, 0, list_texts<core::TiffSamples>()});
    visit("output.denoise", s.output.denoise,
          FieldRule{"through Intel Open Image Denoise", 0, 0, {}, "--denoise"});
    visit("output.credit", s.output.credit,
          FieldRule{"a line with the data's attribution in 8-bit pictures", 0, 0, {}, "--credit"});
    visit("quality.integrator", s.quality.integrator,
          FieldRule{"direct: sun, sky, mirrors, water; path: all light, with bounces", 0, 0,
                    list_texts<core::Integrator>(), "--integrator"});
    visit("quality.samples", s.quality.samples,
          FieldRule{"samples per pixel; with noise or time: at most", 1, 65536, {}, "--samples"});
    visit("quality.noise", s.quality.noise,
          FieldRule{"error of a pixel's mean that is good enough, share of its brightness; 0 = all "
                    "samples everywhere",
                    0,
                    1,
                    {},
                    "--noise"});
    visit("quality.min_samples", s.quality.min_samples,
          FieldRule{"least samples of a pixel before its noise is estimated", 4, 65536});
    visit("quality.time_s", s.quality.time_s,
          FieldRule{"samples go on as long as this, seconds; 0 = until all are done",
                    0,
                    1e7,
                    {},
                    "--time"});
    visit("quality.seed", s.quality.seed, FieldRule{"seed of the random numbers", 0, 2147483647});
    visit("quality.bounces", s.quality.bounces,
          FieldRule{"of a path, and of mirrors", 0, 64, {}, "--bounces"});
    visit(
        "quality.clamp", s.quality.clamp,
        FieldRule{"upper limit of one indirect sample of a path, 1 = white; 0 = no limit", 0, 1e6});
    visit("quality.level", s.quality.level,
          FieldRule{"finest level of the boxes: n = voxels of 2^n times the base size",
                    0,
                    20,
                    {},
                    "--level"});
    visit("quality.detail", s.quality.detail,
          FieldRule{"pixels that a voxel of a coarser level may cover, far away; 0 = the finest "
                    "level everywhere",
                    0,
                    64,
                    {},
                    "--detail"});
    visit("quality.coarse_step", s.quality.coarse_step,
          FieldRule{"first pass: one of n x n pixels, a power of two; 1 = a single pass", 1, 64});
    visit("quality.tile", s.quality.tile,
          FieldRule{"edge of a tile: 1 to 4096 pixels, or 0.1% to 100% of the picture's width",
                    0,
                    0,
                    {},
                    "--tile"});
    visit("quality.tile_order", s.quality.tile_order,
          FieldRule{"order of the tiles", 0, 0, list_texts<core::TileOrder>()});
    visit("quality.shadows", s.quality.shadows, FieldRule{"shadow rays towards the sun"});
    visit("quality.ambient_occlusion", s.quality.ambient_occlusion,
          FieldRule{"ambient occlusion: darker corners"});
    visit("quality.reflections", s.quality.reflections, FieldRule{"mirrors: water, window panes"});
    visit("quality.refraction", s.quality.refraction, FieldRule{"rays into water, ice and glass"});
    visit("quality.ao_rays", s.quality.ao_rays,
          FieldRule{"ambient-occlusion rays for each hit; 0 = dark corners without rays",
                    0,
                    1024,
                    {},
                    "--ao-rays"});
    visit("quality.ao_range_m", s.quality.ao_range_m,
          FieldRule{"how far ambient-occlusion rays look, metres", 0.01, 1e6});
    visit("quality.ao_strength", s.quality.ao_strength,
          FieldRule{"1 = as the rays say, 0 = none", 0, 1});
    visit("quality.materials", s.quality.materials,
          FieldRule{"appearances of the materials: NAME for config/materials-NAME.toml, or a path; "
                    "default: config/materials.toml",
                    0,
                    0,
                    {},
                    "--materials"});
    visit("quality.textures", s.quality.textures,
          FieldRule{"what is drawn on the faces of voxels"});
    visit("quality.cut_outs", s.quality.cut_outs, FieldRule{"holes between leaves"});
    visit("quality.colour", s.quality.colour,
          FieldRule{"of voxels with a true colour", 0, 0, list_texts<core::VoxelColour>(),
                    "--colour"});
    visit("quality.colour_mix", s.quality.colour_mix,
          FieldRule{"share of the true colour for mix", 0, 1});
    visit("analysis.kind", s.analysis.kind,
          FieldRule{"of a raster: what terravox analyse measures; pictures have none", 0, 0,
                    list_texts<core::AnalysisKind>()});
    visit("analysis.cell_m", s.analysis.cell_m,
          FieldRule{"edge of a raster's cells, metres; 0 = none, a picture", 0, 1e5});
    visit("analysis.relief", s.analysis.relief,
          FieldRule{"surface of slope, aspect and hillshade", 0, 0, {"dtm", "dsm"}, "--relief"});
    visit("analysis.window", s.analysis.window,
          FieldRule{"slopes are those of a plane through the heights of so many cells a side: odd; "
                    "more even out the steps of voxels",
                    3,
                    101,
                    {},
                    "--window"});
    visit("analysis.fill_m", s.analysis.fill_m,
          FieldRule{"how far the ground is interpolated below buildings, metres, and at most 256 "
                    "cells; 0 = not at all",
                    0,
                    1e5,
                    {},
                    "--fill-m"});
    visit("analysis.relief_light", s.analysis.relief_light,
          FieldRule{"azimuth,altitude of the hillshade's light, degrees, clockwise from north",
                    0,
                    0,
                    {},
                    "--light"});
    visit("analysis.surface", s.analysis.surface,
          FieldRule{
              "where in a cell sky, sun and sight are measured: on the highest voxel, or on the "
              "ground below crowns and decks",
              0, 0, list_texts<core::AnalysisSurface>(), "--surface"});
    visit(
        "analysis.thin_blocks", s.analysis.thin_blocks,
        FieldRule{"on the ground and at facades: low vegetation, trunks and wires block light, as "
                  "wide as their voxels",
                  0,
                  0,
                  {},
                  "--thin-blocks"});
    visit("analysis.directions", s.analysis.directions,
          FieldRule{"rays from a cell towards the sky", 16, 4096, {}, "--directions"});
    visit("analysis.range_m", s.analysis.range_m,
          FieldRule{"how far sky and sight look, metres; 0 = to the end of the world",
                    0,
                    1e6,
                    {},
                    "--range-m"});
    visit("analysis.step_min", s.analysis.step_min,
          FieldRule{"steps of the sun's way, minutes", 1, 60, {}, "--step-min"});
    visit("analysis.from", s.analysis.from,
          FieldRule{"first day of a period, YYYY-MM-DD", 0, 0, {}, "--from"});
    visit("analysis.to", s.analysis.to,
          FieldRule{"last day of a period, YYYY-MM-DD", 0, 0, {}, "--to"});
    visit(
        "analysis.clock", s.analysis.clock,
        FieldRule{"offsets of the clock in hours and their instants, instead of sun.zone; workers "
                  "get them",
                  0, 0});
    visit("analysis.place", s.analysis.place,
          FieldRule{"latitude, longitude and convergence of the map where the sun is looked up, "
                    "degrees; default: the middle of the world"});
    visit("analysis.bin_deg", s.analysis.bin_deg,
          FieldRule{"bins that gather the sun's positions of a period, degrees; 0 = a ray for each "
                    "position",
                    0,
                    15,
                    {},
                    "--bin-deg"});
    visit("analysis.linke", s.analysis.linke,
          FieldRule{"Linke turbidity of a sky without clouds: one number, or twelve, January first",
                    0,
                    0,
                    {},
                    "--linke"});
    visit("analysis.diffuse", s.analysis.diffuse,
          FieldRule{"model of where the sky's light comes from",
                    0,
                    0,
                    {"perez", "isotropic"},
                    "--diffuse"});
    visit("analysis.albedo", s.analysis.albedo,
          FieldRule{"share of light that the surroundings reflect", 0, 1, {}, "--albedo"});
    visit(
        "analysis.crown_light", s.analysis.crown_light,
        FieldRule{"share of light that crowns of trees let through: one number, or two with leaves "
                  "and without them, such as 0.03,0.45",
                  0,
                  0,
                  {},
                  "--crown-light"});
    visit("analysis.light", s.analysis.light,
          FieldRule{"light of a period, summed up of a weather file, instead of a sky without "
                    "clouds; workers get it"});
    visit("analysis.horizon", s.analysis.horizon,
          FieldRule{"terrain outside of the data that hides sun and sky, made of a raster of "
                    "heights; workers get it"});
    visit("analysis.side", s.analysis.side,
          FieldRule{"of facades: the walls whose outside is on this side", 0, 0,
                    list_texts<core::WallSide>()});
    visit("analysis.storey", s.analysis.storey,
          FieldRule{"of facades: which storey, from 0 at the foot of the wall", 0, 1000});
    visit("analysis.storey_m", s.analysis.storey_m,
          FieldRule{"of facades: height of a storey, metres", 1, 1000, {}, "--storey-m"});
    visit("analysis.observers", s.analysis.observers,
          FieldRule{"of sight: points that look, x,y,z;... in voxels"});
    visit("analysis.target_m", s.analysis.target_m,
          FieldRule{"height above the surface that is looked for, metres",
                    0,
                    10000,
                    {},
                    "--target-height"});
    visit("analysis.curvature", s.analysis.curvature,
          FieldRule{"curvature of the Earth, with refraction", 0, 0, {}, "--curvature"});
    visit(
        "analysis.refraction", s.analysis.refraction,
        FieldRule{"coefficient of the air's refraction: 0 none, 0.13 by day, more over cold water",
                  -1,
                  1,
                  {},
                  "--refraction"});
    visit("processing.threads", s.processing.threads,
          FieldRule{"threads of this machine; default: one for each core; 0 = none: workers render",
                    0,
                    1024,
                    {},
                    "--threads"});
    visit("processing.memory_mib", s.processing.memory_mib,
          FieldRule{"limit for boxes in memory, MiB", 1, 1048576, {}, "--memory-mib"});
    visit("processing.box_timeout_s", s.processing.box_timeout_s,
          FieldRule{"timeout for fetching a box from a voxel server, seconds",
                    1,
                    86400,
                    {},
                    {},
                    "processing.box_patience_s"});
    visit("world.crs", s.world.crs,
          FieldRule{"coordinate reference system of LiDAR files and rasters, instead of their own",
                    0,
                    0,
                    {},
                    "--crs"});
    visit("world.classes", s.world.classes,
          FieldRule{"class table of the LiDAR files: an id of config/classes, or a path; auto: the "
                    "one that is meant for such files",
                    0,
                    0,
                    {},
                    "--classes"});
    visit("world.mark_unknown", s.world.mark_unknown,
          FieldRule{"show points of classes that the table does not name in magenta, instead of "
                    "guessing them",
                    0,
                    0,
                    {},
                    "--mark-unknown"});
    visit("world.vertical_unit", s.world.vertical_unit,
          FieldRule{"of the heights of LiDAR files and rasters; default: from the CRS",
                    0,
                    0,
                    {"", "m", "ft", "us-ft"}});
    visit("world.settings", s.world.settings,
          FieldRule{
              "which voxelization steps run and how: a TOML file; default: config/voxelize.toml",
              0,
              0,
              {},
              "--settings"});
    visit("world.steps", s.world.steps,
          FieldRule{"voxelization steps that run: all, none, some of those listed below, or "
                    "-STEP,... for all but these; default: as world.settings says",
                    0,
                    0,
                    {},
                    "--steps"});
    visit("world.photo", s.world.photo,
          FieldRule{"colours of orthophotos: albedo (sun, shadow and sky are taken out) or raw; "
                    "default: as world.settings says, albedo",
                    0,
                    0,
                    {"", "albedo", "raw"},
                    "--photo"});
    visit("world.plane", s.world.plane,
          FieldRule{
              "what the place stands on, up to the horizon: a table, the sea, or none; default: "
              "table, where the camera frames the place",
              0,
              0,
              {"", "table", "sea", "none"},
              "--plane"});
    visit("world.memory_mib", s.world.memory_mib,
          FieldRule{"limit for what the world keeps of its data, MiB", 64, 1048576});
    visit(
        "world.voxel_m", s.world.voxel_m,
        FieldRule{"edge of a voxel, metres; of LiDAR data, rasters of heights and generated worlds",
                  0.01,
                  1000,
                  {},
                  "--voxel"});
    visit("world.dimension", s.world.dimension,
          FieldRule{"of a Minecraft world: overworld, nether, end, or another's name",
                    0,
                    0,
                    {},
                    "--dimension"});
    visit(
        "world.base_m", s.world.base_m,
        FieldRule{
            "of rasters of heights: rock down to here, metres; default: a little below the lowest",
            -12000, 12000});
    visit("generated.water_level", s.generated.water_level,
          FieldRule{"height of the sea, voxels", -4096, 4096});
    visit("generated.world_height", s.generated.world_height,
          FieldRule{"how far the highest summits rise above the sea, voxels", 8, 4096});
    visit("generated.harmonics", s.generated.harmonics,
          FieldRule{"octaves of hills and ridges, each twice as fine as the one before", 1, 16});
    visit("generated.frequency", s.generated.frequency,
          FieldRule{"of the broadest hills, 1 / voxels", 1e-5, 0.1});
    visit("generated.smoothness", s.generated.smoothness,
          FieldRule{"height of an octave to that of the one before: 0 smooth, 1 jagged", 0, 1});
    visit("generated.trees", s.generated.trees, FieldRule{"trees, bushes and grass"});
}

}  // namespace terravox::scene
