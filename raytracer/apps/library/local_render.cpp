#include "raytracer/apps/library/local_render.hpp"

#include <terravox/error.hpp>

#include <string>

#include "common/thread/parallel.hpp"
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

scene::Scene scene_of(const SceneText& text) {
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

}  // namespace terravox
