#include <map>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "tests/bench/clocks.hpp"
#include "tests/bench/entries/scale_run.hpp"

namespace terravox::bench::scale_trace_entry {
namespace {

constexpr std::size_t kMib = std::size_t{1} << 20;
constexpr int kLimit_mib = 700;

std::string area_of(int side_km) {
    return std::to_string(side_km * side_km) + " km2";
}

/// Worlds by the length of their edge in km, all boxes kept.
using Worlds = std::map<int, std::shared_ptr<ScaleWorld>>;

Shot shot_of(ScaleWorld& world, const scene::Scene& scene, std::size_t memory_bytes, int threads) {
    Shot out = shoot(world, scene, memory_bytes, threads);
    if (out.hole_rays != 0)
        throw util::Error("trace " + world.info().title + ": " + std::to_string(out.hole_rays) +
                          " rays met holes");
    return out;
}

/// The fastest of three: other programs only ever make a picture slower.
Shot best_shot_of(ScaleWorld& world, const scene::Scene& scene, std::size_t memory_bytes,
                  int threads) {
    Shot best = shot_of(world, scene, memory_bytes, threads);
    for (int again = 0; again < 2; ++again)
        if (Shot next = shot_of(world, scene, memory_bytes, threads); next.seconds < best.seconds)
            best = std::move(next);
    return best;
}

void add_shot(const std::string& name, const Shot& shot, double limit_mib, Readings& readings) {
    readings.add(name + ": render", "s", shot.seconds);
    readings.add(name + ": render, CPU", "s", shot.cpu_s);
    readings.add(name + ": rate", "Mray/s", shot.megarays / shot.seconds);
    readings.add(name + ": peak memory of the process", "MiB", shot.peak_mib);
    readings.add(name + ": boxes in memory at most", "MiB", shot.peak_boxes_mib,
                 at_most(1.05 * limit_mib));
    readings.add(name + ": boxes loaded", "boxes", static_cast<double>(shot.boxes));
    readings.add(name + ": boxes loaded, size", "MiB", shot.boxes_mib);
}

Entry entry_of(const std::string& name, const std::string& measures, const std::string& work) {
    Entry out;
    out.name = name;
    out.measures = measures;
    out.work = work;
    out.missing = [](const Context&) { return std::string(); };
    out.exact = out.only_by_name = true;
    return out;
}

/// Makes the boxes, and counts what that costs where they are not kept yet.
Entry prepare_entry(const std::vector<int>& sides_km, const std::string& name) {
    Entry out =
        entry_of(name,
                 "making and keeping the boxes of a synthetic landscape, all levels: seconds; mean "
                 "bytes of a box of each level",
                 "squares of " + area_of(sides_km.front()) + " to " + area_of(sides_km.back()) +
                     "; boxes that are kept ($TERRAVOX_BENCH_CACHE) are only read");
    out.prepare = [sides_km](const Context& c) -> Body {
        return [sides_km, &c](Readings& readings) {
            constexpr int kBoxes = 64;
            const auto world = open_scale_world(c, 1);
            const Cost cost = cost_of([&] {
                for (int i = 0; i < kBoxes; ++i)
                    if (!world->make_finest({0, i % 8 - 4, 0, i / 8 - 4}))
                        throw util::Error("make a box of the synthetic landscape: it is empty");
            });
            readings.add("one level-0 box", "CPU ms", cost.cpu_s / kBoxes * 1e3, at_most(4));
            for (const int side_km : sides_km)
                prepare_scale_world(*open_scale_world(c, side_km), c.threads, &readings);
        };
    };
    return out;
}

void measure_sizes(const Worlds& worlds, int threads, Readings& readings) {
    for (const ScaleView& view : scale_views()) {
        double smallest_s = 0;
        double smallest_cpu_s = 0;
        for (const auto& [side_km, world] : worlds) {
            const Shot shot = best_shot_of(*world, view.scene, kLimit_mib * kMib, threads);
            const std::string name = std::string(view.name) + ", " + area_of(side_km);
            add_shot(name, shot, kLimit_mib, readings);
            readings.add(name + ": all memory / 700 MiB", "x", shot.peak_mib / kLimit_mib,
                         at_most(1));
            keep_picture(shot.film, std::string(view.name) + "-" + std::to_string(side_km) + "km");
            if (smallest_s == 0) {
                smallest_s = shot.seconds;
                smallest_cpu_s = shot.cpu_s;
            } else if (view.fills_smallest) {
                const std::string to = " to that of " + area_of(worlds.begin()->first);
                readings.add(name + ": time" + to, "x", shot.seconds / smallest_s, at_most(2));
                readings.add(name + ": CPU time" + to, "x", shot.cpu_s / smallest_cpu_s);
            }
        }
    }
}

/// The same cameras over ever larger worlds.
Entry sizes_entry(const std::vector<int>& sides_km, const std::string& name) {
    Entry out = entry_of(
        name,
        "one camera in a growing world, boxes in files and none in memory: seconds, rays, peak "
        "memory of the process, boxes read",
        "a synthetic landscape of " + area_of(sides_km.front()) + " to " +
            area_of(sides_km.back()) +
            " with 1 m voxels, 1280x720, 1 sample, 700 MiB for boxes, N threads, best of 3");
    out.prepare = [sides_km](const Context& c) -> Body {
        Worlds worlds;
        for (const int side_km : sides_km)
            prepare_scale_world(*(worlds[side_km] = open_scale_world(c, side_km)), c.threads,
                                nullptr);
        return [worlds, threads = c.threads](Readings& readings) {
            measure_sizes(worlds, threads, readings);
        };
    };
    return out;
}

/// Memory changes the time, never the picture.
Entry limits_entry(int side_km) {
    Entry out = entry_of(
        "scale/limits",
        "the same picture with little memory and with plenty: seconds, peak memory, and how many "
        "pixels are not bit-identical",
        "a synthetic landscape of " + area_of(side_km) +
            ", 1280x720, 1 sample, detail 0.2, 300 MiB, 700 MiB and 64 GiB for boxes, N threads");
    out.prepare = [side_km](const Context& c) -> Body {
        const auto world = open_scale_world(c, side_km);
        prepare_scale_world(*world, c.threads, nullptr);
        return [world, threads = c.threads](Readings& readings) {
            for (ScaleView view : scale_views()) {
                view.scene.quality.detail = 0.2;  // so fine that boxes come and go
                const Shot free =
                    shot_of(*world, view.scene, std::size_t{64} * 1024 * kMib, threads);
                readings.add(std::string(view.name) + ", no limit: render", "s", free.seconds);
                readings.add(std::string(view.name) + ", no limit: boxes in memory at most", "MiB",
                             free.peak_boxes_mib);
                for (const int limit_mib : {300, kLimit_mib}) {
                    const Shot shot = shot_of(*world, view.scene,
                                              static_cast<std::size_t>(limit_mib) * kMib, threads);
                    const std::string name =
                        std::string(view.name) + ", " + std::to_string(limit_mib) + " MiB";
                    add_shot(name, shot, limit_mib, readings);
                    readings.add(name + ": unlike pixels", "pixels",
                                 static_cast<double>(pixels_unlike(shot.film, free.film)),
                                 at_most(0));
                }
            }
        };
    };
    return out;
}

/// How far pictures of a coarser level are from those of level 0, and, as a measure of that,
/// pictures of fewer samples from those of more.
Entry detail_entry(int side_km) {
    constexpr int kManySamples = 16;  // fewer differ from each other by more than levels do
    Entry out = entry_of("scale/detail",
                         "mean absolute difference of a picture from that of --detail 0, linear "
                         "light: coarser levels far away; fewer samples",
                         "a synthetic landscape of " + area_of(side_km) + ", 1280x720, 1 and " +
                             std::to_string(kManySamples) + " samples, N threads");
    out.prepare = [side_km](const Context& c) -> Body {
        const auto world = open_scale_world(c, side_km);
        prepare_scale_world(*world, c.threads, nullptr);
        return [world, threads = c.threads](Readings& readings) {
            constexpr std::size_t kPlenty_bytes = std::size_t{8192} * kMib;
            for (const ScaleView& view : scale_views()) {
                const auto film_of = [&](double detail, int samples) {
                    scene::Scene scene = view.scene;
                    scene.quality.detail = detail;
                    scene.quality.samples = samples;
                    return shot_of(*world, scene, kPlenty_bytes, threads).film;
                };
                const std::string name = std::string(view.name) + ", ";
                const std::string many = std::to_string(kManySamples) + " samples";
                const output::Film once = film_of(0, 1);
                const output::Film best = film_of(0, kManySamples);
                readings.add(name + "1 sample to " + many, "%", difference_percent(once, best));
                for (const int detail : {1, 2, 4}) {
                    const std::string which = name + "detail " + std::to_string(detail);
                    readings.add(which + ", 1 sample", "%",
                                 difference_percent(film_of(detail, 1), once));
                    const output::Film coarse = film_of(detail, kManySamples);
                    readings.add(which + ", " + many, "%", difference_percent(coarse, best),
                                 detail == 1 ? at_most(1) : Target{});
                    keep_picture(coarse,
                                 std::string(view.name) + "-detail" + std::to_string(detail));
                }
                keep_picture(best, std::string(view.name) + "-detail0");
            }
        };
    };
    return out;
}

const Registration kRegistered([] {
    return std::vector{
        prepare_entry({1, 2, 5, 10}, "scale/prepare"), sizes_entry({1, 2, 5, 10}, "scale/trace"),
        sizes_entry({1, 2, 5, 10, 20}, "scale/trace/400km2"), limits_entry(10), detail_entry(5)};
});

}  // namespace
}  // namespace terravox::bench::scale_trace_entry
