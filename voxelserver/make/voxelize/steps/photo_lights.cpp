#include "voxelserver/make/voxelize/steps/photo_lights.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/util/linear_light.hpp"
#include "common/util/log.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/sunlight/light_removal.hpp"

namespace terravox::voxelize {
namespace {

using sunlight::Kind;

static_assert(PhotoSurface::kFilledTogether + sunlight::kGapReach <= grid::kPatchSize);

constexpr std::size_t kPatchBytes = 2 * grid::kPatchColumns * (sizeof(float) + sizeof(Kind));
/// Some 400 patches, since each is needed for the nine or more around it.
constexpr std::size_t kKeptBytes = 400 * kPatchBytes;

/// What is highest in a column.
struct Top {
    float height = kNoHeight;  ///< voxels
    Kind kind = Kind::kUnknown;
    void raise(const Surface& surface, Kind what) {
        if (surface.seen() && !(surface.height < height)) {
            height = surface.height;
            kind = what;
        }
    }
};

Top find_top(const PatchColumns& patch, std::size_t i, double voxel_m) {
    const Column& c = patch.columns[i];
    Top top;
    top.raise(c.ground, Kind::kGround);
    if (c.water.seen() && c.water_points > c.ground_points)
        top.raise(c.water, Kind::kWater);
    top.raise(c.deck, Kind::kGround);
    if (c.built_upon())
        top.raise(c.roof, Kind::kRoof);
    if (patch.objects_begin[i + 1] == patch.objects_begin[i])
        return top;
    constexpr double kHides_m = 1.5;  // grass, crops and cars do not
    const ObjectVoxel& object = patch.objects[patch.objects_begin[i + 1] - 1];
    const float height =
        static_cast<float>(object.y) + static_cast<float>(object.fraction) / 256.0F;
    if (top.kind == Kind::kUnknown || (height - top.height) * voxel_m > kHides_m)
        top = {height, Kind::kPlant};
    return top;
}

/// Copies a rectangle of cells.
/// @param x,z,width,height in `from`
/// @param to_x,to_z where it begins in `to`
void copy_cells(const sunlight::Surface& from, int x, int z, int width, int height,
                sunlight::Surface& to, int to_x, int to_z) {
    for (int row = 0; row < height; ++row) {
        const auto first = static_cast<std::ptrdiff_t>(from.index(x, z + row));
        const auto there = static_cast<std::ptrdiff_t>(to.index(to_x, to_z + row));
        std::copy_n(from.top_m.begin() + first, width, to.top_m.begin() + there);
        std::copy_n(from.kind.begin() + first, width, to.kind.begin() + there);
    }
}

}  // namespace

PhotoSurface::PhotoSurface(PointSet& points)
    : m_points(points),
      m_voxel_m(points.sources().frame.voxel_m()),
      m_nothing(std::make_shared<const PatchTops>(
          casting({grid::kPatchSize, grid::kPatchSize, 0, m_voxel_m}))),
      m_tops(kKeptBytes) {}

PhotoSurface::PatchTops PhotoSurface::casting(sunlight::Surface seen) {
    PatchTops out{seen, std::move(seen)};
    sunlight::fill_gaps(out.casts, sunlight::kSmallGap);
    return out;
}

std::shared_ptr<const PhotoSurface::PatchTops> PhotoSurface::find_tops(grid::PatchKey key) {
    const auto make = [&]() -> std::shared_ptr<const PatchTops> {
        const auto columns = m_points.columns(key);
        if (!columns->any)
            return m_nothing;
        sunlight::Surface seen(grid::kPatchSize, grid::kPatchSize, 0, m_voxel_m);
        for (std::size_t i = 0; i < grid::kPatchColumns; ++i) {
            const Top top = find_top(*columns, i, m_voxel_m);
            seen.top_m[i] = top.height * static_cast<float>(m_voxel_m);
            seen.kind[i] = top.kind;
        }
        return std::make_shared<const PatchTops>(casting(std::move(seen)));
    };
    const auto measure_bytes = [&](const auto& tops) {
        return tops == m_nothing ? 0 : kPatchBytes;
    };
    return m_tops.get(key, make, measure_bytes);
}

sunlight::Surface PhotoSurface::assembled(const grid::PatchRect& patches, int margin, Part part) {
    const int across = patches.max.px - patches.min.px + 2 * margin;
    const int down = patches.max.pz - patches.min.pz + 2 * margin;
    sunlight::Surface out(across * grid::kPatchSize, down * grid::kPatchSize,
                          margin * grid::kPatchSize, m_voxel_m);
    for (int pz = 0; pz < down; ++pz)
        for (int px = 0; px < across; ++px) {
            const auto tops =
                find_tops({patches.min.px - margin + px, patches.min.pz - margin + pz});
            copy_cells((*tops).*part, 0, 0, grid::kPatchSize, grid::kPatchSize, out,
                       px * grid::kPatchSize, pz * grid::kPatchSize);
        }
    return out;
}

sunlight::Surface PhotoSurface::around(const grid::PatchRect& patches, int margin) {
    sunlight::Surface out = assembled(patches, margin, &PatchTops::casts);
    sunlight::Surface near = sunlight::inner_cells(assembled(patches, 1, &PatchTops::seen),
                                                   kFilledTogether + sunlight::kGapReach);
    sunlight::fill_gaps(near);
    const int to = out.margin - kFilledTogether;
    copy_cells(near, sunlight::kGapReach, sunlight::kGapReach, near.width - 2 * sunlight::kGapReach,
               near.height - 2 * sunlight::kGapReach, out, to, to);
    return out;
}

namespace {

using imagery::Raster;
using sunlight::Light;
using sunlight::Scene;

constexpr const char* kFindStep = "photo light search";
constexpr const char* kRemoveStep = "photo light";
/// For the light of an image and its entry in the cache.
constexpr std::size_t kLightBytes = 1024;
/// Cells of the search are at least this wide.
constexpr double kFinestCell_m = 0.75;

Light to_linear_value(voxel::Rgb8 colour) noexcept {
    constexpr float kScale = 1.0F / util::kBrightest;
    return {static_cast<float>(util::to_linear(colour.r)) * kScale,
            static_cast<float>(util::to_linear(colour.g)) * kScale,
            static_cast<float>(util::to_linear(colour.b)) * kScale};
}

voxel::Rgb8 to_srgb_value(const Light& light) noexcept {
    const auto part = [](float v) {
        const float scaled = std::clamp(v, 0.0F, 1.0F) * util::kBrightest + 0.5F;
        return util::to_srgb(static_cast<std::uint32_t>(scaled));
    };
    return {part(light[0]), part(light[1]), part(light[2])};
}

/// Puts a raster into a scene whose first column is `from` columns before the raster's.
void show(const Raster& raster, int from, std::optional<std::uint32_t> image, Scene& scene) {
    if (raster.empty())
        return;
    for (int z = 0; z < raster.height; ++z)
        for (int x = 0; x < raster.width; ++x) {
            const auto i = static_cast<std::size_t>(z * raster.width + x);
            if ((raster.flags[i] & Raster::kColour) == 0 || (image && raster.image[i] != *image))
                continue;
            const std::size_t to = scene.index(x + from, z + from);
            scene.photo[to] = to_linear_value(raster.colour[i]);
            scene.shown[to] = 1;
        }
}

/// What the points of a column say of the material of what is seen of it.
sunlight::Cover find_cover(const PatchColumns& columns, int x, int z, Kind kind,
                           const ClassTable& classes) {
    using sunlight::Cover;
    constexpr double kDarkEcho = 0.5;  // asphalt, and what is as dark, over bright ground
    if (kind == Kind::kPlant) {
        const auto objects = columns.objects_at(x, z);
        if (objects.empty())
            return Cover::kUnknown;
        const bool grows = classes.meaning[objects.back().source_class].role == Role::kVegetation;
        return grows ? Cover::kVegetation : Cover::kOther;
    }
    const voxelize::Surface& ground = columns.at(x, z).ground;
    if (kind != Kind::kGround || !ground.seen())
        return Cover::kUnknown;
    if (classes.meaning[ground.source_class].material == voxel::Material::kRoad)
        return Cover::kAsphalt;
    if (ground.brightness == BrightnessScale::kUnknown)
        return Cover::kUnknown;
    return ground.brightness < kDarkEcho * BrightnessScale::kBrightGround ? Cover::kAsphalt
                                                                          : Cover::kOther;
}

void log_light(const std::string& file, const PhotoLight& found) {
    const Light& gain = found.light.gain;
    const std::string levels =
        fmt::format("exposure x {:.2f}, {:.2f}, {:.2f}, black point {:.2f}", gain[0], gain[1],
                    gain[2], sunlight::luminance(found.light.veil));
    if (found.light.sun)
        util::log_info(
            "orthophoto {}: taken with the sun at azimuth {:.1f}, altitude {:.1f} degrees "
            "(correlation {:.2f}, margin {:.2f}, sky {:.2f}), {}; colours are albedo",
            file, found.light.sun->azimuth_deg, found.light.sun->altitude_deg,
            found.estimate.correlation, found.estimate.margin, sunlight::luminance(found.light.sky),
            levels);
    else
        util::log_info(
            "orthophoto {}: no sun found that explains its shadows (correlation {:.2f}, margin "
            "{:.2f}); only these are adjusted: {}",
            file, found.estimate.correlation, found.estimate.margin, levels);
}

/// Takes the black point off the colours that come from an image, and multiplies the rest.
void adjust_levels(std::uint32_t image, const sunlight::FlightLight& levels, Raster& out) {
    if (levels.gain == Light{1, 1, 1} && levels.veil == Light{})
        return;
    for (std::size_t i = 0; i < out.colour.size(); ++i) {
        if ((out.flags[i] & Raster::kColour) == 0 || out.image[i] != image)
            continue;
        Light light = sunlight::without_veil(to_linear_value(out.colour[i]), levels.veil);
        for (std::size_t c = 0; c < 3; ++c)
            light[c] *= levels.gain[c];
        out.colour[i] = to_srgb_value(light);
    }
}

/// Replaces the colours that come from an image by albedo.
/// @param surface of a patch and what lies around it
/// @param inner its inner cells, photographed
void relight(std::uint32_t image, const sunlight::LightField& light,
             const sunlight::Surface& surface, const Scene& inner, Raster& out) {
    const std::vector<Light> albedo = sunlight::remove_light(surface, inner, light);
    constexpr int kFirst = sunlight::kEdgeReach;
    for (int z = 0; z < grid::kPatchSize; ++z)
        for (int x = 0; x < grid::kPatchSize; ++x) {
            const auto i = static_cast<std::size_t>(z * grid::kPatchSize + x);
            if ((out.flags[i] & Raster::kColour) != 0 && out.image[i] == image)
                out.colour[i] = to_srgb_value(albedo[inner.index(x + kFirst, z + kFirst)]);
        }
}

}  // namespace

PhotoLights::PhotoLights(const imagery::Orthophotos& images, PointSet& points,
                         util::StageTimes& times, const KeptLights& kept)
    : m_images(images),
      m_inputs(images.inputs()),
      m_paths(images.order()),
      m_points(points),
      m_times(times),
      m_kept(kept),
      m_around(shadow_patches(points.sources().frame.voxel_m())),
      m_mosaic(m_inputs),
      m_exposure_images(exposure_images(m_inputs)),
      m_surface(points),
      m_own_lights((images.count() + 1) * kLightBytes),
      m_lights((images.count() + 1) * kLightBytes) {}

/// From an earlier world, else by a search, whose result is kept for later ones.
PhotoLight PhotoLights::known_or_found(std::size_t image) {
    const util::StageTimes::Scope timed(m_times, kFindStep);
    const imagery::Orthophotos::Input& input = m_inputs[image];
    const PhotoSample sample = photo_sample(input.rect, m_points.sources());
    if (m_kept.folder == nullptr)
        return find_light(image, sample);
    voxel::ByteWriter inputs;
    inputs.add(m_kept.everywhere);
    inputs.add(to_fingerprint(sample, input.identity, m_points.sources()));
    const std::string name = "light-" + voxel::to_hex(inputs.fingerprint());
    if (const auto bytes = m_kept.folder->find_facts(name))
        if (const auto known = parse_photo_light(*bytes))
            return *known;
    PhotoLight found = find_light(image, sample);
    m_kept.folder->put_facts(name, to_bytes(found));
    return found;
}

/// What the columns of a block say of their material, before the scene's cells are made wider.
void PhotoLights::mark_covers(const grid::PatchRect& block, Scene& scene) {
    scene.cover.assign(scene.size(), sunlight::Cover::kUnknown);
    for (std::int32_t pz = block.min.pz; pz < block.max.pz; ++pz)
        for (std::int32_t px = block.min.px; px < block.max.px; ++px) {
            const auto columns = m_points.columns({px, pz});
            const int x0 = scene.margin + (px - block.min.px) * grid::kPatchSize;
            const int z0 = scene.margin + (pz - block.min.pz) * grid::kPatchSize;
            for (int z = 0; z < grid::kPatchSize; ++z)
                for (int x = 0; x < grid::kPatchSize; ++x) {
                    const std::size_t i = scene.index(x0 + x, z0 + z);
                    scene.cover[i] = find_cover(*columns, x, z, scene.kind[i], m_points.classes());
                }
        }
}

PhotoLight PhotoLights::find_light(std::size_t image, const PhotoSample& sample) {
    std::vector<Scene> scenes;
    for (const grid::PatchRect& block : sample.blocks) {
        Scene scene(m_surface.around(block, m_around));
        const int width = (block.max.px - block.min.px) * grid::kPatchSize;
        const int height = (block.max.pz - block.min.pz) * grid::kPatchSize;
        show(m_images.read_image(image, {block.min.x0(), block.min.z0(), width, height}),
             scene.margin, std::nullopt, scene);
        mark_covers(block, scene);
        while (scene.cell_m < kFinestCell_m)
            scene = sunlight::halved(scene);
        scenes.push_back(std::move(scene));
    }
    PhotoLight out;
    const auto estimate = sunlight::find_sun(scenes);
    if (estimate)
        out.estimate = *estimate;
    std::optional<sunlight::Sun> sun;
    if (estimate && sunlight::is_certain(*estimate))
        sun = estimate->sun;
    out.light = sunlight::measure_light(scenes, sun);
    // What is hardly darker in its shadows was not taken in the sun.
    constexpr float kNoShadow = 0.9F;
    if (sun && sunlight::luminance(out.light.sky) > kNoShadow)
        out.light = sunlight::measure_light(scenes, std::nullopt);
    out.evidence = sunlight::find_evidence(scenes, out.light);
    return out;
}

std::shared_ptr<const PhotoLight> PhotoLights::own_light(std::size_t image) {
    return m_own_lights.get(
        image, [&] { return std::make_shared<const PhotoLight>(known_or_found(image)); },
        [](const auto&) { return sizeof(PhotoLight); });
}

/// Of the photographs of its flight that count for its series; of its own where there are none.
sunlight::Exposure PhotoLights::flight_exposure(std::size_t image) {
    const auto own = own_light(image);
    std::vector<sunlight::Evidence> flight;
    for (const std::size_t other : m_exposure_images.at(m_inputs[image].series)) {
        const auto there = own_light(other);
        const auto& sun = there->light.sun;
        if (sun.has_value() == own->light.sun.has_value() &&
            (!sun || sunlight::is_same_flight(*sun, *own->light.sun)))
            flight.push_back(there->evidence);
    }
    if (flight.empty())
        flight.push_back(own->evidence);
    return sunlight::find_exposure(sunlight::pooled(flight));
}

PhotoLight PhotoLights::make_light(std::size_t image) {
    return *m_lights.get(
        image,
        [&] {
            PhotoLight light = *own_light(image);
            light.light = sunlight::exposed(light.light, flight_exposure(image));
            log_light(m_paths[image].string(), light);
            return std::make_shared<const PhotoLight>(light);
        },
        [](const auto&) { return sizeof(PhotoLight); });
}

/// At a column of an image whose sun is known.
sunlight::FlightLight PhotoLights::light_at(std::size_t image, std::int32_t x, std::int32_t z) {
    const sunlight::FlightLight own = make_light(image).light;
    std::vector<sunlight::WeightedLight> lights;
    for (const PhotoMosaic::Weight& other : m_mosaic.weights(image, x, z)) {
        const sunlight::FlightLight light = make_light(other.image).light;
        if (light.sun && sunlight::is_same_flight(*light.sun, *own.sun))
            lights.push_back({light, other.weight});
    }
    return lights.empty() ? own : sunlight::blended(lights);
}

sunlight::LightField PhotoLights::light_over(std::size_t image, grid::PatchKey key) {
    constexpr std::int32_t kSide = grid::kPatchSize;
    const auto at = [&](std::int32_t east, std::int32_t south) {
        return light_at(image, key.x0() + east, key.z0() + south);
    };
    return {at(kSide / 2, kSide / 2), {at(0, 0), at(kSide, 0), at(0, kSide), at(kSide, kSide)}};
}

Raster PhotoLights::albedo(grid::PatchKey key) {
    constexpr int kReach = sunlight::kEdgeReach;
    constexpr int kSide = grid::kPatchSize + 2 * kReach;
    Raster wide;
    {
        const util::StageTimes::Scope timed(m_times, "orthophoto load");
        wide = m_images.read(key.x0() - kReach, key.z0() - kReach, kSide, kSide);
    }
    Raster out;
    out.width = grid::kPatchSize;
    out.height = grid::kPatchSize;
    if (wide.empty())
        return out;
    const auto middle = [&](const auto& from, auto& to) {
        if (from.empty())
            return;
        for (int z = 0; z < grid::kPatchSize; ++z) {
            const auto at = from.begin() + (z + kReach) * kSide + kReach;
            to.insert(to.end(), at, at + grid::kPatchSize);
        }
    };
    middle(wide.colour, out.colour);
    middle(wide.nir, out.nir);
    middle(wide.red, out.red);
    middle(wide.flags, out.flags);
    middle(wide.image, out.image);
    std::vector<std::uint32_t> images;
    for (std::size_t i = 0; i < out.flags.size(); ++i)
        if ((out.flags[i] & Raster::kColour) != 0)
            images.push_back(out.image[i]);
    std::sort(images.begin(), images.end());
    images.erase(std::unique(images.begin(), images.end()), images.end());
    if (images.empty()) {
        if (std::all_of(out.flags.begin(), out.flags.end(), [](auto f) { return f == 0; }))
            return {grid::kPatchSize, grid::kPatchSize, {}, {}, {}, {}, {}};
        return out;
    }
    std::optional<sunlight::Surface> surface;
    for (const std::uint32_t image : images) {
        const PhotoLight own = make_light(image);
        if (!own.light.sun) {
            adjust_levels(image, own.light, out);
            continue;
        }
        const sunlight::LightField light = light_over(image, key);
        const util::StageTimes::Scope timed(m_times, kRemoveStep);
        if (!surface) {
            surface = m_surface.around({key, {key.px + 1, key.pz + 1}}, m_around);
            surface->margin -= kReach;  // which is photographed, too
        }
        Scene inner(inner_cells(*surface));
        show(wide, 0, image, inner);
        relight(image, light, *surface, inner, out);
    }
    return out;
}

}  // namespace terravox::voxelize
