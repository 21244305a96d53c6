#include "raytracer/farm/render/joined_pictures.hpp"

#include <algorithm>
#include <memory>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/core/output/denoise.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/output/tile_stream.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/shade/view.hpp"

namespace terravox::render {
namespace {

/// Layers are kept only for EXR files, as in a picture rendered in one go: the other formats list
/// none in their metadata, and the memory is saved.
scene::Scene make_scene(const farm::PictureKey& key, const std::vector<std::string>& files) {
    scene::Scene scene;
    scene::parse_scene(key.scene, "of the checkpoint", scene);
    if (std::none_of(files.begin(), files.end(), output::is_exr))
        scene.output.layers = core::PictureLayers::kBeauty;
    return scene;
}

output::StreamShape make_shape(const farm::PictureKey& key, const scene::Scene& scene) {
    return {key.grid.width_px, key.grid.height_px, key.grid.tile_px,
            scene.output.layers != core::PictureLayers::kBeauty || scene.output.denoise};
}

bool streams(const output::StreamShape& shape, const PictureOptions& options) {
    return output::must_stream(shape, (std::uint64_t{options.memory_mib} << 20) / 2);
}

}  // namespace

void check_joined_pictures(const farm::PictureKey& key, const std::vector<std::string>& files,
                           const PictureOptions& options) {
    const scene::Scene scene = make_scene(key, files);
    for (const std::string& file : files)
        output::check_image_target(file, key.grid.width_px, key.grid.height_px);
    if (scene.output.denoise)
        output::check_can_denoise();
    const output::StreamShape shape = make_shape(key, scene);
    if (!streams(shape, options))
        return;
    if (scene.output.denoise)
        throw util::UsageError(
            "merge into " + std::to_string(shape.width_px) + "x" + std::to_string(shape.height_px) +
            " pixels: more than the memory limit holds, and output.denoise = true; "
            "allowed: --memory-mib " +
            std::to_string(output::memory_to_keep_mib(shape)) + " and more");
    for (const std::string& file : files)
        output::check_can_stream(file, shape);
}

output::PictureInfo joined_picture_info(const scene::Scene& scene, const voxel::WorldInfo& world,
                                        const RenderStatistics& statistics) {
    // No ray is traced, so the looks of materials are not needed.
    return picture_info(shade::make_view(scene, world, nullptr, analyse::measure), world,
                        statistics, false);
}

RenderStatistics write_joined_pictures(const farm::JoinedTiles& tiles,
                                       const std::vector<std::string>& files,
                                       const PictureOptions& options) {
    const farm::PictureKey& key = tiles.key();
    const scene::Scene scene = make_scene(key, files);
    const output::StreamShape shape = make_shape(key, scene);
    const voxel::WorldInfo world = voxel::world_from_json(key.world, "the checkpoint");
    // No ray is traced, so the looks of materials are not needed.
    const shade::View view = shade::make_view(scene, world, nullptr, analyse::measure);
    RenderStatistics s;
    s.threads = options.threads;
    s.damage = tiles.damage();
    s.counts.samples = static_cast<std::uint32_t>(scene.quality.samples);

    if (streams(shape, options)) {
        std::vector<std::unique_ptr<output::TileStream>> streams;
        for (const std::string& file : files)
            streams.push_back(std::make_unique<output::TileStream>(
                file, shape, picture_info(view, world, s, false)));
        tiles.each([&](tiles::TileResult&& tile) {
            for (const auto& stream : streams)
                stream->add(tile);
            s.counts.add(tile);
        });
        for (const auto& stream : streams)
            stream->finish(s.counts.holes.size());
        return s;
    }
    output::Film film(shape.width_px, shape.height_px, shape.with_layers);
    tiles.each([&](tiles::TileResult&& tile) {
        film.add(tile);
        s.counts.add(tile);
    });
    if (scene.output.denoise)
        output::denoise(film, options.threads);
    thread::parallel_for(files.size(), options.threads, [&](std::size_t i) {
        output::write_image(film, files[i], picture_info(view, world, s, false));
    });
    return s;
}

}  // namespace terravox::render
