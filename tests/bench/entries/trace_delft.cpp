#include "common/util/error.hpp"
#include "raytracer/blocks/block_manager.hpp"
#include "raytracer/processors/thread_processor.hpp"
#include "raytracer/render/passes/passes.hpp"
#include "raytracer/shade/view_maker.hpp"
#include "raytracer/walk/walker.hpp"
#include "tests/bench/entries/data_sets.hpp"

namespace terravox::bench::trace_delft_entry {
namespace {

constexpr std::size_t kBoxMemory_bytes = std::size_t{2} << 30;

/// Delft with every box in memory, and the views to trace.
struct Traced {
    explicit Traced(const Context& c)
        : opened(open_data_set(delft(), c, c.threads)), blocks(*opened.world, kBoxMemory_bytes) {
        const voxel::BoxRange range = voxel::boxes_over(opened.world->info().bounds, 0);
        for (auto key = range.min; key.bx < range.max.bx; ++key.bx)
            for (key.bz = range.min.bz; key.bz < range.max.bz; ++key.bz)
                for (key.by = range.min.by; key.by < range.max.by; ++key.by)
                    (void)blocks.get(key);
        full = std::make_unique<shade::View>(shade::make_view(scene::Scene{}, blocks));
        scene::Scene bare;
        bare.quality.samples = 1;
        bare.quality.ambient_occlusion = bare.quality.reflections = false;
        plain = std::make_unique<shade::View>(shade::make_view(bare, blocks));
    }
    OpenWorld opened;
    blocks::BlockManager blocks;
    std::unique_ptr<shade::View> full;
    std::unique_ptr<shade::View> plain;
};

void add_rates(const std::string& what, double rays, double steps, double seconds,
               Readings& readings) {
    readings.add(what, "Mray/s", rays / seconds / 1e6);
    readings.add(what + ": steps", "steps/ray", steps / rays);
}

/// Rays through pixel centres, no shading, on this thread.
void trace_primary(Traced& t, Readings& readings) {
    walk::BlockReader reader(t.blocks);
    walk::Walker walker(reader, t.plain->cut);
    const auto [width, height] = t.plain->scene.output.size_px;
    std::size_t hits = 0;
    const double seconds = seconds_of([&] {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if (walker.first_hit(t.plain->camera.ray(x + 0.5, y + 0.5)))
                    ++hits;
    });
    if (hits == 0)
        throw util::Error("trace Delft: no ray hit anything");
    add_rates("primary 1t", static_cast<double>(walker.rays()), static_cast<double>(walker.steps()),
              seconds, readings);
}

void trace_view(Traced& t, const shade::View& view, int threads, const std::string& what,
                Readings& readings) {
    render::RenderCounts counts;
    const auto [width, height] = view.scene.output.size_px;
    output::Film film(width, height);
    const double seconds = seconds_of([&] {
        processors::ThreadProcessor processor(view, t.blocks, threads);
        counts = render::render_film({view, processor, true, {}}, film);
    });
    if (counts.trace.hole_rays != 0)
        throw util::Error("trace Delft: " + std::to_string(counts.trace.hole_rays) +
                          " rays met holes");
    add_rates(what, static_cast<double>(counts.trace.all_rays()),
              static_cast<double>(counts.trace.steps), seconds, readings);
}

Entry entry() {
    Entry out;
    out.name = "trace/delft";
    out.measures =
        "rays per second, every box in memory: the walk alone; primary and shadow rays shaded; the "
        "picture as it is rendered";
    out.work = "Delft (" + delft().facts +
               "), 1280x720: 1 sample a pixel (primary, shaded), 4 samples with ambient occlusion "
               "and mirrors (full)";
    out.missing = [](const Context& c) { return delft().missing(c); };
    out.prepare = [](const Context& c) -> Body {
        const auto traced = std::make_shared<Traced>(c);
        return [traced, threads = c.threads](Readings& readings) {
            trace_primary(*traced, readings);
            trace_view(*traced, *traced->plain, 1, "shaded 1t", readings);
            trace_view(*traced, *traced->plain, threads, "shaded Nt", readings);
            trace_view(*traced, *traced->full, 1, "full 1t", readings);
            trace_view(*traced, *traced->full, threads, "full Nt", readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::trace_delft_entry
