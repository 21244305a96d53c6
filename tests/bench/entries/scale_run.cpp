#include "tests/bench/entries/scale_run.hpp"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>

#include "common/util/error.hpp"
#include "common/util/free_memory.hpp"
#include "raytracer/blocks/block_manager.hpp"
#include "raytracer/output/image_writer.hpp"
#include "raytracer/processors/thread_processor.hpp"
#include "raytracer/render/passes/passes.hpp"
#include "raytracer/shade/view_maker.hpp"
#include "tests/bench/clocks.hpp"

namespace terravox::bench {
namespace {

constexpr double kMib = 1024.0 * 1024.0;

std::optional<std::filesystem::path> bench_cache() {
    const char* given = std::getenv("TERRAVOX_BENCH_CACHE");
    return given != nullptr && *given != '\0' ? std::optional<std::filesystem::path>(given)
                                              : std::nullopt;
}

/// Counts the requests to a world.
class CountedWorld final : public voxel::World {
public:
    explicit CountedWorld(voxel::World& world) : m_world(world) {}
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_world.info(); }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        auto out = m_world.box(key);
        if (out) {
            ++boxes;
            bytes += out->memory_bytes();
        }
        return out;
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_world.column(level, bx, bz);
    }
    std::atomic<std::uint64_t> boxes{0};
    std::atomic<std::uint64_t> bytes{0};

private:
    voxel::World& m_world;
};

/// From now on the peak is counted anew. Where the system cannot, the peak is that since the
/// program's start.
void forget_peak() {
    util::trim_heap();  // memory of the picture before must not count for this one
    std::ofstream("/proc/self/clear_refs") << "5";
}

double peak_resident_mib() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:"))
            return std::strtod(line.c_str() + 6, nullptr) / 1024;
    throw util::Error("read the peak memory: /proc/self/status has no VmHWM");
}

scene::Scene scene_from(double x, double y, double z, double to_x, double to_y, double to_z,
                        double fov_deg) {
    scene::Scene out;
    out.camera.space = core::CoordinateSpace::kVoxel;
    out.camera.position = {x, y, z};
    out.camera.target = {to_x, to_y, to_z};
    out.camera.fov_deg = fov_deg;
    out.sun.altitude_deg = 36;
    out.sun.azimuth_deg = 235;
    out.quality.samples = 1;
    return out;
}

}  // namespace

std::shared_ptr<ScaleWorld> open_scale_world(const Context& context, int side_km) {
    return std::make_shared<ScaleWorld>(side_km, bench_cache().value_or(context.scratch) / "scale");
}

void prepare_scale_world(ScaleWorld& world, int threads, Readings* readings) {
    ScaleWorld::Prepared prepared;
    const auto say = [](const std::string& line) {
        std::fprintf(stderr, "bench: %s\n", line.c_str());
    };
    const double seconds = seconds_of([&] { prepared = world.prepare(threads, say); });
    if (readings == nullptr)
        return;
    const std::string size = world.info().title + ": ";
    readings->add(size + "prepare", "s", seconds);
    readings->add(size + "boxes made", "boxes", static_cast<double>(prepared.made));
    for (int level = 0; level < ScaleWorld::kLevels; ++level) {
        const auto boxes = static_cast<double>(prepared.boxes[level]);
        const auto bytes = static_cast<double>(prepared.bytes[level]);
        readings->add(size + "level " + std::to_string(level), "KiB/box", bytes / boxes / 1024);
    }
}

std::vector<ScaleView> scale_views() {
    const Land land(ScaleWorld::kSeed);
    const double high = land.height(0, 0) + 600;
    const double edge = land.height(-480, 190) + 300;
    const double shore = std::floor(land.height(-400, 300)) + 2;
    return {{"high", scene_from(0, high, 0, 2600, high - 700, -900, 45), false},
            {"oblique", scene_from(-480, edge, 190, 480, edge - 210, -140, 45)},
            {"ground", scene_from(-399.5, shore, 300.5, -1000, shore, -900, 50)}};
}

Shot shoot(voxel::World& world, const scene::Scene& scene, std::size_t memory_bytes, int threads) {
    CountedWorld counted(world);
    Shot out{output::Film(scene.output.size_px[0], scene.output.size_px[1])};
    forget_peak();
    render::RenderCounts counts;
    const Cost cost = cost_of([&] {
        blocks::BlockManager blocks(counted, memory_bytes, threads);
        const shade::View view = shade::make_view(scene, blocks);
        render::prefetch_visible(view, blocks);
        processors::ThreadProcessor processor(view, blocks, threads);
        counts = render::render_film({view, processor, true, {}}, out.film);
        out.peak_boxes_mib = static_cast<double>(blocks.stats().peak_bytes) / kMib;
    });
    out.seconds = cost.wall_s;
    out.cpu_s = cost.cpu_s;
    out.peak_mib = peak_resident_mib();
    out.megarays = static_cast<double>(counts.trace.all_rays()) / 1e6;
    out.hole_rays = counts.trace.hole_rays;
    out.boxes = counted.boxes;
    out.boxes_mib = static_cast<double>(counted.bytes) / kMib;
    return out;
}

double difference_percent(const output::Film& film, const output::Film& reference) {
    double off = 0;
    double sum = 0;
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x) {
            const voxel::Colour a = film.at(x, y).colour;
            const voxel::Colour b = reference.at(x, y).colour;
            off += std::fabs(a.r - b.r) + std::fabs(a.g - b.g) + std::fabs(a.b - b.b);
            sum += b.r + b.g + b.b;
        }
    return 100 * off / sum;
}

std::size_t pixels_unlike(const output::Film& film, const output::Film& reference) {
    std::size_t out = 0;
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x) {
            const tiles::PixelSample &a = film.at(x, y), &b = reference.at(x, y);
            const bool same = a.colour.r == b.colour.r && a.colour.g == b.colour.g &&
                              a.colour.b == b.colour.b && a.alpha == b.alpha &&
                              a.depth_m == b.depth_m;
            out += same ? 0 : 1;
        }
    return out;
}

void keep_picture(const output::Film& film, const std::string& name) {
    const auto cache = bench_cache();
    if (!cache)
        return;
    std::filesystem::create_directories(*cache / "pictures");
    output::write_image(film, *cache / "pictures" / (name + ".png"), output::PictureInfo{});
}

}  // namespace terravox::bench
