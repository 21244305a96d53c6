#include "raytracer/apps/preview/layers.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/core/output/develop.hpp"

namespace terravox::preview {
namespace {

constexpr voxel::Colour kNothing{0.06f, 0.06f, 0.07f};  // for rays that hit nothing

/// Distinguishable colours for any number: hues by the golden ratio, which are similar for numbers
/// that differ by a Fibonacci number; brightness and saturation differ there. Ref: Knuth, The Art
/// of Computer Programming 3, 6.4.
voxel::Colour hue(std::uint32_t number) noexcept {
    constexpr double kGolden = 0.6180339887498949;
    constexpr std::array kBrightness{0.95, 0.6, 0.78};
    constexpr std::array kPale{0.05, 0.33};
    const double h = std::fmod((number + 1) * kGolden, 1.0) * 6;
    const double bright = kBrightness[number % 3];
    const double pale = kPale[number / 3 % 2];
    const auto channel = [&](double shift) {
        return static_cast<float>(
            bright * std::clamp(std::abs(std::fmod(h + shift, 6.0) - 3) - 1, pale, 1.0));
    };
    return {channel(0), channel(4), channel(2)};
}

voxel::Colour plain(float v) noexcept {
    return {v, v, v};
}

/// How far from the eye the world's nearest and farthest point can be, metres; at the least one and
/// two.
struct DepthRange {
    float near_m;
    float far_m;
};
DepthRange find_depths(const shade::View& view) noexcept {
    const voxel::VoxelBounds& b = view.cut.bounds();
    const core::Vec3 eye = view.camera.position();
    double near2 = 0;
    double far2 = 0;
    const auto axis = [&](double at, double low, double high) {
        const double out = std::max({low - at, at - high, 0.0});
        const double through = std::max(std::abs(at - low), std::abs(at - high));
        near2 += out * out;
        far2 += through * through;
    };
    axis(eye.x, b.min[0], b.max[0]);
    axis(eye.y, b.min[1], b.max[1]);
    axis(eye.z, b.min[2], b.max[2]);
    const double near_m = std::max(std::sqrt(near2) * view.voxel_m, 1.0);
    return {static_cast<float>(near_m),
            static_cast<float>(std::max(std::sqrt(far2) * view.voxel_m, 2 * near_m))};
}

/// From near, white, to far, nearly black; each grey step is a factor.
voxel::Colour of_depth(float metres, const DepthRange& range) noexcept {
    if (!std::isfinite(metres))
        return kNothing;
    const float share = std::clamp(std::log(std::max(metres, range.near_m) / range.near_m) /
                                       std::log(range.far_m / range.near_m),
                                   0.0f, 1.0f);
    return plain(1 - 0.85f * share);
}

voxel::Colour of_normal(const std::array<float, 3>& n) noexcept {
    return {0.5f + 0.5f * n[0], 0.5f + 0.5f * n[1], 0.5f + 0.5f * n[2]};
}

voxel::Colour of_matte(const tiles::Matte& matte) noexcept {
    voxel::Colour out;
    for (std::size_t i = 0; i < tiles::Matte::kMax && matte.share[i] > 0; ++i)
        out = out + hue(matte.object[i]) * matte.share[i];
    return out;
}

/// @param day_h for which the sun is up
voxel::Colour of_sun(const tiles::PixelSample& pixel, double day_h) noexcept {
    constexpr voxel::Colour kHole{1, 0, 0.8f};
    if (pixel.colour.g > 0)
        return kHole;
    return pixel.alpha > 0
               ? colour_of_sun_hours(static_cast<double>(pixel.colour.r / pixel.alpha) * day_h)
               : kNothing;
}

float ratio(float of, float to) noexcept {
    return to > 0 ? of / to : 0;
}

/// The colour in which a layer shows a pixel, except for layers of light.
voxel::Colour find_value(Layer layer, const tiles::PixelSample& pixel, const tiles::LayerSample& l,
                         const shade::View& view, const DepthRange& depths) noexcept {
    switch (layer) {
        case Layer::kSunHours: return of_sun(pixel, analyse::day_hours(view));
        case Layer::kDepth: return of_depth(pixel.depth_m, depths);
        case Layer::kNormal: return pixel.alpha > 0 ? of_normal(l.normal) : kNothing;
        case Layer::kAlbedo:
            return {voxel::linear_to_srgb(l.albedo.r), voxel::linear_to_srgb(l.albedo.g),
                    voxel::linear_to_srgb(l.albedo.b)};
        case Layer::kMaterial: return pixel.alpha > 0 ? of_matte(l.materials) : kNothing;
        case Layer::kSunlight: return pixel.alpha > 0 ? plain(l.sun) : kNothing;
        case Layer::kSquares: return pixel.alpha > 0 ? of_matte(l.squares) : kNothing;
        case Layer::kOcclusion:
            return pixel.alpha > 0 ? plain(voxel::linear_to_srgb(
                                         std::min(ratio(voxel::luminance(l.direct),
                                                        voxel::luminance(l.albedo) * pixel.alpha),
                                                  1.0f)))
                                   : kNothing;
        default: return pixel.colour;  // of a probe layer: shown as it is
    }
}

bool is_light(Layer layer) noexcept {
    return layer == Layer::kBeauty || layer == Layer::kDirect || layer == Layer::kIndirect;
}

/// The parts of a film that a layer needs: pixels alone, or layers too; and which light.
enum class FilmKind : std::uint8_t {
    kPixels,
    kLayers,
    kEvenLight,
    kSunHours,
    kLevels,
    kSteps,
    kCache
};
FilmKind find_kind(Layer layer) noexcept {
    switch (layer) {
        case Layer::kBeauty: return FilmKind::kPixels;
        case Layer::kOcclusion: return FilmKind::kEvenLight;
        case Layer::kSunHours: return FilmKind::kSunHours;
        case Layer::kLevels: return FilmKind::kLevels;
        case Layer::kSteps: return FilmKind::kSteps;
        case Layer::kCache: return FilmKind::kCache;
        default: return FilmKind::kLayers;
    }
}

}  // namespace

scene::Scene scene_for(Layer layer, scene::Scene scene) {
    const FilmKind kind = find_kind(layer);
    scene.output.layers = kind == FilmKind::kLayers || kind == FilmKind::kEvenLight
                              ? core::PictureLayers::kAll
                              : core::PictureLayers::kBeauty;
    scene.output.denoise = false;
    if (kind == FilmKind::kEvenLight) {
        // The light of a uniform sky at a surface is its ambient occlusion times its albedo.
        scene.sky.model = core::SkyModel::kUniform;
        scene.sky.colour.reset();
        scene.sky.strength = 1;
        scene.sky.visibility_km = 0;
        scene.sun.strength = 0;
        scene.quality.integrator = core::Integrator::kDirect;
        scene.quality.ambient_occlusion = true;
        scene.quality.ao_strength = 1;
        scene.quality.ao_rays = std::max(scene.quality.ao_rays, 4);
        scene.quality.reflections = scene.quality.refraction = false;
    }
    if (kind == FilmKind::kSunHours) {
        scene.analysis = {};
        scene.analysis.kind = core::AnalysisKind::kSunView;
    }
    if (is_probe(layer))
        scene.quality.samples = 1;
    return scene;
}

bool same_film(Layer a, Layer b) noexcept {
    const auto film = [](Layer l) {
        return find_kind(l) == FilmKind::kPixels ? FilmKind::kLayers : find_kind(l);
    };
    // A film with layers has the picture, too; one without lacks the layers.
    return a == b || (film(a) == film(b) && find_kind(b) == FilmKind::kPixels) ||
           (find_kind(a) == find_kind(b) && find_kind(a) == FilmKind::kLayers);
}

void ScreenPicture::resize(int width, int height) {
    if (width == width_px && height == height_px)
        return;
    width_px = width;
    height_px = height;
    rgb.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 40);
}

void show(const output::Film& film, const shade::View& view, const scene::Scene::Output& output,
          Layer layer, const tiles::RenderTile& tile, ScreenPicture& to) {
    // The view's exposure is the sum of the adaptation to its daylight and the scene's setting.
    const output::Developer develop(
        view.exposure_ev - view.scene.output.exposure_ev + output.exposure_ev, output.tone);
    const DepthRange depths = find_depths(view);
    static const tiles::LayerSample none;
    const auto place = [&](int x, int y) {
        return &to.rgb[(static_cast<std::size_t>(y) * static_cast<std::size_t>(to.width_px) +
                        static_cast<std::size_t>(x)) *
                       3];
    };
    tile.each_pixel([&](int x, int y) {
        const tiles::PixelSample& pixel = film.at(x, y);
        const tiles::LayerSample& layers = film.has_layers() ? film.layers_at(x, y) : none;
        const voxel::Colour c = !is_light(layer)
                                    ? find_value(layer, pixel, layers, view, depths)
                                    : develop(layer == Layer::kBeauty   ? pixel.colour
                                              : layer == Layer::kDirect ? layers.direct
                                                                        : layers.indirect);
        const auto bytes = output::dithered_bytes(c, x, y);
        const int width = std::min(tile.step, to.width_px - x);
        const int height = std::min(tile.step, to.height_px - y);
        std::uint8_t* row = place(x, y);
        for (int i = 0; i < width; ++i)
            std::copy(bytes.begin(), bytes.end(), row + static_cast<std::ptrdiff_t>(i) * 3);
        for (int i = 1; i < height; ++i)
            std::copy(row, row + static_cast<std::ptrdiff_t>(width) * 3, place(x, y + i));
    });
}

voxel::Rgb8 colour_of_material(voxel::Material material) noexcept {
    const voxel::Colour c = hue(static_cast<std::uint32_t>(material));
    const auto byte = [](float v) {
        return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255));
    };
    return {byte(c.r), byte(c.g), byte(c.b)};
}

voxel::Colour colour_of_sun_hours(double hours) noexcept {
    // From black by violet and orange to pale yellow: as bright as the hours are many, so that it
    // can be read without colours, too. Ref: "inferno" of Smith & van der Walt, 2015.
    constexpr std::array<voxel::Colour, 5> kRamp{{{0.0f, 0.0f, 0.02f},
                                                  {0.34f, 0.06f, 0.43f},
                                                  {0.73f, 0.21f, 0.33f},
                                                  {0.98f, 0.56f, 0.04f},
                                                  {0.99f, 1.0f, 0.64f}}};
    constexpr double kLongest_h = 16;
    const double at = std::clamp(hours / kLongest_h, 0.0, 1.0) * (kRamp.size() - 1);
    const std::size_t first = std::min(static_cast<std::size_t>(at), kRamp.size() - 2);
    const auto share = static_cast<float>(at - static_cast<double>(first));
    return kRamp[first] * (1 - share) + kRamp[first + 1] * share;
}

voxel::Colour colour_of_level(int level) noexcept {
    return level == 0 ? voxel::Colour{0.92f, 0.92f, 0.92f} : hue(static_cast<std::uint32_t>(level));
}

}  // namespace terravox::preview
