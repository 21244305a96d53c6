#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/core/base/scene_words.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::scene {

/// Points of a world, voxels of level 0: x east, y up, z south.
struct PointList {
    static constexpr std::size_t kMaxPoints = 1024;
    static constexpr double kFarthest = 1e9;  ///< of a coordinate, either way
    static constexpr const char* kAllowed =
        "up to 1024 points x,y,z in voxels, with ';' between them";

    std::vector<std::array<double, 3>> points;

    /// @param text "1,2,3;4.5,6,-7"; empty: no point
    /// @return nullopt for anything else, for more than kMaxPoints, and beyond kFarthest
    [[nodiscard]] static std::optional<PointList> parse(const std::string& text);
    /// In the form that parse() takes; the same numbers to the last bit.
    [[nodiscard]] std::string text() const;
    friend bool operator==(const PointList&, const PointList&) = default;
};

/// The edge of a tile: pixels, or a share of the picture's width.
struct TileSize {
    static constexpr int kMax_px = 4096;
    static constexpr double kMin_percent = 0.1;
    static constexpr double kMax_percent = 100;
    static constexpr const char* kAllowed =
        "1 to 4096 pixels, or 0.1% to 100% of the picture's width";

    int px = 64;         ///< 1 to kMax_px; ignored when percent is not 0
    double percent = 0;  ///< of the picture's width

    /// @param text "64" or "5%"; numbers as in C++
    /// @return nullopt for anything else, and out of range
    [[nodiscard]] static std::optional<TileSize> parse(const std::string& text);
    /// In the form that parse() takes.
    [[nodiscard]] std::string text() const;
    /// In a picture of this width: whole pixels, the nearest to the share, 1 to kMax_px.
    [[nodiscard]] int in_picture(int width_px) const noexcept;
    friend bool operator==(const TileSize&, const TileSize&) = default;
};

/// Everything that determines a picture except the world. It is stored as one TOML file, and every
/// field has a command-line flag (scene_fields.hpp lists them, with units and ranges). Version 1.
struct Scene {
    struct Camera {
        /// A named view of config/views, which fields given in addition to it override; empty:
        /// none.
        std::string look;
        core::CameraProjection projection = core::CameraProjection::kPerspective;
        double fov_deg = 40;  ///< vertical; of a fisheye: across the picture's shorter side
        /// Orthographic and isometric: extent that the picture's height covers; default: frames the
        /// world.
        std::optional<double> height_m;
        double aperture_m = 0;  ///< diameter of the lens; 0: everything is sharp
        /// Distance of the plane of focus; default: that of the target, or of the framed world's
        /// middle.
        std::optional<double> focus_m;
        double roll_deg = 0;  ///< rotation of the camera about its line of sight, clockwise
        /// Without position and target the camera frames the whole world: from azimuth_deg, looking
        /// down by down_deg. azimuth_deg is the camera's direction seen from the world's middle,
        /// clockwise from north.
        double azimuth_deg = 225;
        double down_deg = 35;
        double margin = 0.04;  ///< free border around the framed world, share of the picture
        double zoom = 1;       ///< above 1: nearer than framing requires
        std::optional<std::array<double, 3>> position;
        std::optional<std::array<double, 3>> target;
        core::CoordinateSpace space = core::CoordinateSpace::kCrs;  ///< of position and target
        bool inside_rock = false;  ///< allow a camera inside a solid voxel
        friend bool operator==(const Camera&, const Camera&) = default;
    } camera;
    struct Sun {
        std::string date = "2026-06-21";
        double time_h = 16;
        /// Default: that of `zone`, else of the zone of the place's longitude.
        std::optional<double> utc_offset_h;
        std::string zone;  ///< IANA name, such as Europe/Ljubljana; empty: utc_offset_h is used
        std::optional<double> altitude_deg, azimuth_deg;  ///< set together: override date and time
        double strength = 1;
        double size = 1;  ///< radius of the disc, times the true one; 0: a point, with hard shadows
        /// Replaces the atmosphere's light: linear R, G, B of a white surface that faces the sun.
        std::optional<std::array<double, 3>> light;
        friend bool operator==(const Sun&, const Sun&) = default;
    } sun;
    struct Sky {
        core::SkyModel model = core::SkyModel::kAtmosphere;
        /// Of the uniform sky, linear R, G, B; default 1, 1, 1.
        std::optional<std::array<double, 3>> colour;
        double turbidity = 2.5;  ///< of the air: 2 very clear, 3 clear, 6 hazy
        /// Distance at which haze leaves 5 % of the contrast; default: by turbidity; 0: no air in
        /// front of things.
        std::optional<double> visibility_km;
        double clouds = 0;             ///< share of the sky that they cover
        double cloud_height_m = 1500;  ///< above the lowest voxel of the world
        double strength = 1;
        friend bool operator==(const Sky&, const Sky&) = default;
    } sky;
    struct Output {
        std::array<int, 2> size_px = {1280, 720};
        double exposure_ev = 0;  ///< in addition to the adaptation
        /// Share of the lack of daylight for which the exposure compensates: 0 as at noon, 1 as
        /// bright as by day.
        double adaptation = 0.75;
        core::ToneCurve tone = core::ToneCurve::kPhotographic;  ///< of 8-bit pictures
        core::PictureLayers layers = core::PictureLayers::kBeauty;
        core::TiffSamples tiff = core::TiffSamples::kAuto;
        bool denoise = false;
        /// A line with the data's attribution at the lower edge of 8-bit pictures.
        bool credit = false;
        friend bool operator==(const Output&, const Output&) = default;
    } output;
    struct Quality {
        core::Integrator integrator = core::Integrator::kDirect;
        int samples = 4;  ///< per pixel; with noise: at most
        /// A pixel is done when the error of its mean is at most this share of its brightness; 0:
        /// all samples everywhere.
        double noise = 0;
        int min_samples = 16;  ///< samples before `noise` is tested
        double time_s = 0;     ///< adds samples for this long; 0: until `samples` are done
        int seed = 0;          ///< of the noise
        int bounces = 6;       ///< of a path; of mirrors in direct light
        /// Greatest light that one indirect sample of a path contributes, at the picture's
        /// exposure; 0: no limit.
        double clamp = 16;
        int level = 0;  ///< finest level of the boxes
        /// Pixels that a voxel may cover at most, where coarser levels are used; 0: only `level`.
        double detail = 1;
        /// The first pass traces one pixel of step x step; 1: a single pass.
        int coarse_step = 8;
        TileSize tile;
        core::TileOrder tile_order = core::TileOrder::kSpiral;
        bool shadows = true;
        bool ambient_occlusion = true;
        bool reflections = true;
        bool refraction = true;
        /// Ambient-occlusion rays for each hit; 0: corners are darkened without rays.
        int ao_rays = 0;
        double ao_range_m = 40;
        double ao_strength = 1;
        /// Another material file: NAME for config/materials-NAME.toml, or a path; empty:
        /// config/materials.toml.
        std::string materials;
        bool textures = true;  ///< textures on the faces of voxels
        bool cut_outs = true;  ///< holes between leaves
        core::VoxelColour colour = core::VoxelColour::kMix;
        double colour_mix = 0.85;  ///< share of the true colour in VoxelColour::kMix
        friend bool operator==(const Quality&, const Quality&) = default;
    } quality;
    /// Rasters of measured values, made by `terravox analyse`; pictures have none of it.
    struct Analysis {
        core::AnalysisKind kind = core::AnalysisKind::kNone;
        double cell_m = 0;  ///< edge of a cell; 0: none, a picture
        // Of kind terrain, whose slopes are made of the finished tiles.
        std::string relief = "dtm";  ///< surface of slope, aspect and hillshade; or dsm
        int window = 5;              ///< edge of the window of slopes, cells: odd
        double fill_m = 100;         ///< how far the ground is interpolated below buildings
        std::string relief_light = "315,45";  ///< azimuth and altitude of the hillshade's light
        core::AnalysisSurface surface = core::AnalysisSurface::kTop;  ///< of all kinds but terrain
        /// Of kinds sky, sun and energy on the ground, and facade: whether grass, trunks and wires
        /// (core::is_thin) block light, as wide as their voxels.
        bool thin_blocks = false;
        int directions = 256;  ///< of kinds sky, energy: rays from each cell
        /// Of kinds sky, sight: how far their rays look; 0: to the end of the world.
        double range_m = 0;
        /// Of the kinds of the sun: it is where it is in the middle of each step of time.
        double step_min = 10;
        /// First and last day of a period, YYYY-MM-DD; both empty: sun.date alone.
        std::string from, to;
        /// Offsets of the place's clock instead of the sun's zone (solar/place_and_clock.hpp):
        /// workers get them, so that they need no table of time zones.
        std::string clock;
        /// Latitude, longitude and convergence of the map where the sun is looked up, degrees;
        /// default: the middle of the world. The command sets it in wide worlds.
        std::optional<std::array<double, 3>> place;
        /// Of a period: size of the bins that gather the sun's positions; 0: a ray for each.
        double bin_deg = 3;
        // Of kind energy.
        std::string linke = "3";        ///< turbidity of the air: one number, or twelve by month
        std::string diffuse = "perez";  ///< model of the sky's light; or isotropic
        double albedo = 0.2;            ///< share of light that the surroundings reflect
        /// Share of light that crowns let through: with leaves, and without; one number for both.
        std::string crown_light = "0";
        /// Light of a period (solar/energy.hpp) instead of that of a clear sky; empty: none.
        /// The command sums it up of a weather file, so that workers need no file.
        std::string light;
        /// Of kinds sky, sun, energy and facade: terrain outside of the data that hides sun and sky
        /// (solar/far_horizon.hpp); empty: none. The command makes it of a raster of heights.
        std::string horizon;
        // Of kind facade: which walls.
        core::WallSide side = core::WallSide::kSouth;
        int storey = 0;         ///< from 0, at the ground or roof before the wall
        double storey_m = 3;    ///< height of a storey
        PointList observers;    ///< of kind sight
        double target_m = 0;    ///< of kind sight: height above the surface that is looked for
        bool curvature = true;  ///< of kind sight: the Earth's, lessened by the air's refraction
        /// Its coefficient: the Earth's radius to that of a ray of light.
        double refraction = 0.13;
        friend bool operator==(const Analysis&, const Analysis&) = default;
    } analysis;
    struct Processing {
        /// On this machine; default: one for each core; 0: none, workers render.
        std::optional<int> threads;
        int memory_mib = 2048;  ///< boxes in memory
        /// Time after which a request for a box to a voxel server is given up.
        int box_timeout_s = 300;
        friend bool operator==(const Processing&, const Processing&) = default;
    } processing;
    struct World {
        std::string crs;
        std::string classes = "auto";
        bool mark_unknown = false;  ///< show LiDAR classes that the table does not name
        std::string vertical_unit;
        std::string settings;
        std::string steps;  ///< of voxelization, overriding those of `settings`; empty: no change
        std::string photo;  ///< "raw" or "albedo", overriding `settings`; empty: no change
        /// What a picture has beneath the place: "table", "sea", "none"; empty: none, and in
        /// pictures of the commands a table where the camera frames the place.
        std::string plane;
        double voxel_m = 1;
        int memory_mib = 4096;                ///< decoded squares and columns
        std::string dimension = "overworld";  ///< of a Minecraft world
        /// Rasters of heights: rock extends down to here; default: a little below the lowest
        /// height.
        std::optional<double> base_m;
        friend bool operator==(const World&, const World&) = default;
    } world;
    procedural::Settings generated;  ///< except seed and voxel_m, which are set elsewhere
    friend bool operator==(const Scene&, const Scene&) = default;
};

/// @throws UsageError for the scene of an analysis: its pixels are measured values, not light
void check_is_picture(const Scene& scene);

/// The options of a world that are part of a scene: its sections `world`, `generated` and
/// `processing`. Inputs, orthophotos and the cache folder are not part of a scene and stay empty.
[[nodiscard]] worlds::WorldOptions to_world_options(const Scene& scene);

}  // namespace terravox::scene
