#include "raytracer/apps/library/picture.hpp"

#include <terravox/error.hpp>
#include <terravox/world.hpp>
#include <utility>

#include "common/thread/parallel.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/scene/views.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"
#include "raytracer/farm/render/passes/passes.hpp"

namespace terravox {
namespace {

/// @param render called with the job
/// @return boxes that could not be read
template <class Render>
std::size_t run(const WorldState& state, const shade::View& view, int threads,
                const Control& control, const Render& render) {
    processors::ThreadProcessor processor(view, state.blocks, thread::thread_count(threads));
    render::RenderJob job{view, processor, true, control.stop};
    job.on_progress = control.progress;
    job.check_world = [&] { state.blocks.check_world(); };
    return render(job).holes.size();
}

}  // namespace

scene::Scene make_scene(const SceneText& text) {
    const auto from_toml = [&](scene::Scene& scene) {
        if (!text.toml.empty())
            scene::parse_scene(text.toml, "given", scene);
    };
    return scene::compose_scene({from_toml, scene::fields_layer(text.fields)});
}

std::size_t render_tiles(const WorldState& state, const shade::View& view, int threads,
                         const Control& control, output::Film& film) {
    return run(state, view, threads, control,
               [&](const render::RenderJob& job) { return render::render_film(job, film); });
}

std::size_t render_tiles(const WorldState& state, const shade::View& view, int threads,
                         const Control& control, output::TileSink& sink) {
    return run(state, view, threads, control,
               [&](const render::RenderJob& job) { return render::render_stream(job, sink); });
}

namespace {

using Values = std::vector<float>;

/// A layer, and how a pixel's values are added to it.
struct LayerRow {
    const char* name;
    std::size_t channels;
    void (*add)(const tiles::LayerSample& sample, Values& out);
};

void add_colour(const voxel::Colour& colour, Values& out) {
    out.insert(out.end(), {colour.r, colour.g, colour.b});
}

constexpr LayerRow kLayers[] = {
    {"albedo", 3, [](const tiles::LayerSample& s, Values& out) { add_colour(s.albedo, out); }},
    {"direct", 3, [](const tiles::LayerSample& s, Values& out) { add_colour(s.direct, out); }},
    {"indirect", 3, [](const tiles::LayerSample& s, Values& out) { add_colour(s.indirect, out); }},
    {"normal", 3,
     [](const tiles::LayerSample& s, Values& out) {
         out.insert(out.end(), s.normal.begin(), s.normal.end());
     }},
    {"position", 3,
     [](const tiles::LayerSample& s, Values& out) {
         out.insert(out.end(), s.position.begin(), s.position.end());
     }},
    {"sun", 1, [](const tiles::LayerSample& s, Values& out) { out.push_back(s.sun); }},
    {"water", 1, [](const tiles::LayerSample& s, Values& out) { out.push_back(s.water); }},
    {"material", 1,
     [](const tiles::LayerSample& s, Values& out) {
         out.push_back(static_cast<float>(s.material));
     }},
};

/// Calls visit(x, y) for each pixel, row by row.
template <class Visit>
void each_pixel(const output::Film& film, const Visit& visit) {
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x)
            visit(x, y);
}

void add_light(const output::Film& film, const shade::View& view, Picture& out) {
    const output::Developer develop(view.exposure_ev, view.scene.output.tone);
    each_pixel(film, [&](int x, int y) {
        const tiles::PixelSample& sample = film.at(x, y);
        add_colour(sample.colour, out.light);
        out.light.push_back(sample.alpha);
        out.depth_m.push_back(sample.depth_m);
        const auto bytes = output::dithered_bytes(develop(sample.colour), x, y);
        out.rgb.insert(out.rgb.end(), bytes.begin(), bytes.end());
    });
}

void add_layers(const output::Film& film, Picture& out) {
    for (const LayerRow& row : kLayers) {
        Picture::Layer layer{row.name, row.channels, {}};
        layer.values.reserve(out.width * out.height * row.channels);
        each_pixel(film, [&](int x, int y) { row.add(film.layers_at(x, y), layer.values); });
        out.layers.push_back(std::move(layer));
    }
}

}  // namespace

Picture World::render(const SceneText& scene, int threads, const Control& control) const {
    return guarded(control, [&] {
        const WorldCall call(*m_state, threads);
        const shade::View view = shade::make_view(make_scene(scene), m_state->blocks);
        const auto [width, height] = view.scene.output.size_px;
        output::Film film(width, height, view.wants_layers());
        Picture out;
        out.width = static_cast<std::size_t>(width);
        out.height = static_cast<std::size_t>(height);
        out.holes = call.checked(render_tiles(*m_state, view, threads, control, film));
        out.light.reserve(out.width * out.height * 4);
        out.depth_m.reserve(out.width * out.height);
        out.rgb.reserve(out.width * out.height * 3);
        add_light(film, view, out);
        if (film.has_layers())
            add_layers(film, out);
        return out;
    });
}

}  // namespace terravox
