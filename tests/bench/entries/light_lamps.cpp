#include <algorithm>
#include <cmath>
#include <span>

#include "common/util/error.hpp"
#include "raytracer/core/random.hpp"
#include "raytracer/shade/view_maker.hpp"
#include "tests/bench/entries/light_picture.hpp"
#include "tests/bench/entries/scale_settled.hpp"
#include "tests/bench/entries/scale_world.hpp"
#include "voxelserver/worlds/overlay/overlay_world.hpp"

namespace terravox::bench::light_lamps_entry {
namespace {

constexpr std::size_t kLamps = 500;
constexpr double kLampHeight_m = 5;
constexpr int kSide = 1000;  // columns of the land
constexpr int kSamples = 16;
constexpr int kReferenceSamples = 512;
constexpr int kReferenceSeed = 7;
constexpr int kSeed = 1;

struct Column {
    std::int32_t x = 0;
    std::int32_t z = 0;
};

/// Columns of villages in which no house stands, as if shuffled.
std::vector<Column> free_columns(const Land& land) {
    const SettledLand settled(land, 0, 0, kSide);
    std::vector<Column> out;
    for (std::int32_t z = 0; z < kSide; ++z)
        for (std::int32_t x = 0; x < kSide; ++x)
            if (settled.in_village(x, z) && settled.house_at(x, z, 1) == nullptr)
                out.push_back({x, z});
    std::ranges::sort(out, {}, [](const Column& c) {
        return core::hash64(static_cast<std::uint64_t>(c.x), static_cast<std::uint64_t>(c.z));
    });
    return out;
}

/// The land with street lamps in its village, and a view of it.
struct LitVillage {
    explicit LitVillage(const std::filesystem::path& kept) {
        auto land = std::make_unique<ScaleWorld>(1, kept);
        std::vector<Column> columns = free_columns(land->land());
        if (columns.size() < kLamps)
            throw util::Error("light the village: it has " + std::to_string(columns.size()) +
                              " free columns; allowed: at least " + std::to_string(kLamps));
        columns.resize(kLamps);
        std::vector<overlay::AddedObject> lamps;
        for (const Column& c : columns) {
            const double x = c.x;
            const double z = c.z;
            const double top = std::floor(land->land().height(c.x, c.z)) + 1 + kLampHeight_m;
            lamps.push_back({overlay::Footprint({{{x, z}, {x + 1, z}, {x + 1, z + 1}, {x, z + 1}}}),
                             top, true});
            middle[0] += x / kLamps;
            middle[1] += top / kLamps;
            middle[2] += z / kLamps;
        }
        world = std::make_unique<overlay::OverlayWorld>(std::move(land), std::move(lamps), "lamps");
    }
    std::unique_ptr<voxel::World> world;
    std::array<double, 3> middle{};
};

scene::Scene night_scene(const LitVillage& village, int samples, int seed) {
    scene::Scene out;
    out.output.size_px = {320, 180};
    out.camera.space = core::CoordinateSpace::kVoxel;
    out.camera.target = village.middle;
    out.camera.position = village.middle;
    (*out.camera.position)[0] -= 70;
    (*out.camera.position)[1] += 60;
    (*out.camera.position)[2] += 90;
    out.sun.altitude_deg = -30;
    out.sun.azimuth_deg = 200;
    out.quality.integrator = core::Integrator::kPath;
    out.quality.samples = samples;
    out.quality.seed = seed;
    // The limit of indirect light would take most of the light that is met by chance.
    out.quality.clamp = 0;
    return out;
}

/// @param sampled whether lamps are sampled, or met by chance as they were before
TracedPicture traced(blocks::BlockManager& blocks, const scene::Scene& scene, bool sampled,
                     int threads) {
    shade::View view = shade::make_view(scene, blocks);
    view.lamps = sampled;
    return trace_picture(view, blocks, threads);
}

struct Light {
    const char* name;
    bool sampled;
};

/// Values of the picture's pixels that show neither a lamp nor a lit window: the noise of these is
/// that of their edges, which is the same for any light.
std::vector<bool> lit_values(const LitVillage& village, blocks::BlockManager& blocks, int threads) {
    constexpr float kDark = 0.00003f;
    scene::Scene scene = night_scene(village, 16 * kSamples, kReferenceSeed);
    scene.quality.bounces = 0;
    const LinearPicture emitted = traced(blocks, scene, false, threads).picture;
    std::vector<bool> out;
    for (std::size_t i = 0; i < emitted.rgb.size(); ++i) {
        const std::size_t pixel = i / 3 * 3;
        const auto of_pixel = std::span(emitted.rgb).subspan(pixel, 3);
        out.push_back(std::ranges::max(of_pixel) < kDark);
    }
    return out;
}

/// The village and a picture of it with hardly any noise.
struct Prepared {
    explicit Prepared(const Context& c)
        : village(c.scratch / "light-lamps"),
          blocks(*village.world, std::size_t{1} << 30),
          reference(traced(blocks, night_scene(village, kReferenceSamples, kReferenceSeed), true,
                           c.threads)
                        .picture),
          lit(lit_values(village, blocks, c.threads)) {}
    LitVillage village;
    blocks::BlockManager blocks;
    LinearPicture reference;
    std::vector<bool> lit;
};

/// Mean of the reference, and root of the mean squared difference to it, over what is lit.
struct Compared {
    double mean = 0;
    double reference_mean = 0;
    double error = 0;
};
Compared compare(const LinearPicture& found, const Prepared& place) {
    Compared out;
    double count = 0;
    for (std::size_t i = 0; i < place.lit.size(); ++i) {
        if (!place.lit[i])
            continue;
        const auto value = static_cast<double>(found.rgb[i]);
        const auto reference = static_cast<double>(place.reference.rgb[i]);
        ++count;
        out.mean += value;
        out.reference_mean += reference;
        out.error += (value - reference) * (value - reference);
    }
    out.mean /= count;
    out.reference_mean /= count;
    out.error = std::sqrt(out.error / count);
    return out;
}

void measure(const Context& c, Prepared& place, Readings& readings) {
    const scene::Scene scene = night_scene(place.village, kSamples, kSeed);
    double efforts[2] = {};
    for (const Light& light : {Light{"by chance", false}, Light{"sampled", true}}) {
        const TracedPicture found = traced(place.blocks, scene, light.sampled, c.threads);
        const Compared to_reference = compare(found.picture, place);
        const double error = to_reference.error / to_reference.reference_mean;
        const std::string name = std::string("lamps ") + light.name;
        readings.add(name + ": mean of the picture / of the reference", "",
                     to_reference.mean / to_reference.reference_mean);
        readings.add(name + ": error / mean", "%", 100 * error);
        readings.add(name + ": time", "s", found.cost.wall_s);
        efforts[light.sampled ? 1 : 0] = error * std::sqrt(found.cost.wall_s);
    }
    readings.add("noise at equal time / by chance", "", efforts[1] / efforts[0], at_most(0.2));
}

Entry entry() {
    Entry out;
    out.name = "light/lamps";
    out.measures =
        "noise of a night view with street lamps, sampled and met by chance: error to 512 samples "
        "of another seed where neither lamps nor windows are seen, share of the mean there";
    out.work =
        "a village of the synthetic land (1 km2 of 1 m voxels), 500 lamps of 5 m, 320x180, paths, "
        "16 samples";
    out.only_by_name = true;
    out.missing = [](const Context&) { return std::string(); };
    out.prepare = [](const Context& c) -> Body {
        const auto place = std::make_shared<Prepared>(c);
        return [&c, place](Readings& readings) { measure(c, *place, readings); };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::light_lamps_entry
