#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "common/thread/parallel.hpp"
#include "common/voxel/coarse_rule.hpp"
#include "common/voxel/colour.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/entries/scale_run.hpp"

namespace terravox::bench::scale_levels_entry {
namespace {

using voxel::Grain;

constexpr int kSideKm = 5, kHalf = 2048;  // the columns [-2048, 2048): whole cells of every level,
                                          // none at the world's edge
constexpr std::size_t kGrains = 5;

/// What lies on top of some level-0 columns, or of one column of a level: sums.
struct Tops {
    double columns = 0;
    double height = 0;
    std::array<double, 3> light{};           ///< linear
    std::array<double, kGrains> of_grain{};  ///< columns with such a top
    void add(const Tops& other) noexcept {
        columns += other.columns;
        height += other.height;
        for (std::size_t i = 0; i < light.size(); ++i)
            light[i] += other.light[i];
        for (std::size_t i = 0; i < of_grain.size(); ++i)
            of_grain[i] += other.of_grain[i];
    }
    [[nodiscard]] double share(Grain grain) const noexcept {
        return of_grain[static_cast<std::size_t>(grain)] / columns;
    }
};
/// Row by row from the north-west; `side` columns of its level along an edge.
struct TopMap {
    int side;
    std::vector<Tops> tops;
    explicit TopMap(int columns)
        : side(columns),
          tops(static_cast<std::size_t>(columns) * static_cast<std::size_t>(columns)) {}
    [[nodiscard]] Tops& at(int x, int z) noexcept {
        return tops[static_cast<std::size_t>(z) * static_cast<std::size_t>(side) +
                    static_cast<std::size_t>(x)];
    }
};

Tops top_of(const voxel::Box& box, int x, int z, int highest) {
    Tops out;
    out.columns = 1;
    for (int y = highest - 1; y >= 0; --y) {
        const auto attr = box.voxel(x, y, z);
        if (!attr)
            continue;
        out.height = static_cast<double>(y + 1) * (1 << box.key().level);
        const voxel::Colour light = voxel::to_linear(attr->colour);
        out.light = {light.r, light.g, light.b};
        out.of_grain[static_cast<std::size_t>(voxel::grain_of(attr->material))] = 1;
        break;
    }
    return out;
}

TopMap tops_of_level(ScaleWorld& world, int level, int threads) {
    const int half = kHalf >> level;
    TopMap out(2 * half);
    const auto range =
        voxel::boxes_over({{-kHalf, 0, -kHalf}, {kHalf, Land::kHighest, kHalf}}, level);
    const auto width = static_cast<std::size_t>(range.max.bx - range.min.bx);
    thread::parallel_for(width * width, threads, [&](std::size_t i) {
        const voxel::BoxKey key{level, range.min.bx + static_cast<std::int32_t>(i % width), 0,
                                range.min.bz + static_cast<std::int32_t>(i / width)};
        const auto box = world.box(key);
        const int highest = box ? box->top() : 0;
        for (int z = 0; z < voxel::kBoxSizeZ; ++z)
            for (int x = 0; x < voxel::kBoxSizeX; ++x) {
                const int px = key.bx * voxel::kBoxSizeX + x + half;
                const int pz = key.bz * voxel::kBoxSizeZ + z + half;
                if (box && px >= 0 && pz >= 0 && px < out.side && pz < out.side)
                    out.at(px, pz) = top_of(*box, x, z, highest);
            }
    });
    return out;
}

TopMap halved(TopMap& fine) {
    TopMap out(fine.side / 2);
    for (int z = 0; z < fine.side; ++z)
        for (int x = 0; x < fine.side; ++x)
            out.at(x / 2, z / 2).add(fine.at(x, z));
    return out;
}

/// What a level shows against what lies below it, over the columns where `counts` holds for what
/// lies below.
template <class Counts>
void compare(TopMap& level_tops, TopMap& truth, int level, const std::string& where,
             const Counts& counts, Readings& readings) {
    Tops shown;
    Tops real;
    double rise = 0;
    for (std::size_t i = 0; i < truth.tops.size(); ++i) {
        if (!counts(truth.tops[i]))
            continue;
        shown.add(level_tops.tops[i]);
        Tops mean = truth.tops[i];
        const double n = mean.columns;
        mean.columns = 1;
        mean.height /= n;
        for (double& v : mean.light)
            v /= n;
        for (double& v : mean.of_grain)
            v /= n;
        rise += (level_tops.tops[i].height - mean.height) / (1 << level);
        real.add(mean);
    }
    if (real.columns == 0)
        return;
    const std::string name = "level " + std::to_string(level) + ", " + where + ": ";
    readings.add(name + "height", "voxels", rise / real.columns);
    const auto bright = [](const Tops& t) {
        return 0.2126 * t.light[0] + 0.7152 * t.light[1] + 0.0722 * t.light[2];
    };
    readings.add(name + "brightness", "%", 100 * (bright(shown) / bright(real) - 1));
    double worst = 0;
    for (std::size_t i = 0; i < 3; ++i)
        if (const double off = 100 * (shown.light[i] / real.light[i] - 1);
            std::fabs(off) > std::fabs(worst))
            worst = off;
    readings.add(name + "worst channel", "%", worst);
    if (where != "all")
        return;
    for (const auto& [grain, what] : {std::pair{Grain::kShell, "roofs"},
                                      {Grain::kSparse, "leaves"},
                                      {Grain::kWater, "water"}}) {
        readings.add(name + "area of " + what + " below", "%", 100 * real.share(grain));
        readings.add(name + "area of " + what + " shown", "%", 100 * shown.share(grain));
    }
}

Entry entry() {
    Entry out;
    out.name = "scale/levels";
    out.measures =
        "how the tops of each level's columns differ from the tops of the level-0 columns below "
        "them: mean height, light and areas";
    out.work = "4096 x 4096 columns of a synthetic landscape with 1 m voxels, levels 1 to 7";
    out.missing = [](const Context&) { return std::string(); };
    out.exact = out.only_by_name = true;
    out.prepare = [](const Context& c) -> Body {
        const auto world = open_scale_world(c, kSideKm);
        prepare_scale_world(*world, c.threads, nullptr);
        return [world, threads = c.threads](Readings& readings) {
            TopMap truth = tops_of_level(*world, 0, threads);
            for (int level = 1; level < ScaleWorld::kLevels; ++level) {
                truth = halved(truth);
                TopMap tops = tops_of_level(*world, level, threads);
                compare(tops, truth, level, "all", [](const Tops&) { return true; }, readings);
                compare(
                    tops, truth, level, "open ground",
                    [](const Tops& t) { return t.share(Grain::kTerrain) == 1; }, readings);
                compare(
                    tops, truth, level, "woods",
                    [](const Tops& t) { return t.share(Grain::kSparse) > 0.7; }, readings);
                compare(
                    tops, truth, level, "lakes",
                    [](const Tops& t) { return t.share(Grain::kWater) == 1; }, readings);
                compare(
                    tops, truth, level, "a quarter or more roofs",
                    [](const Tops& t) { return t.share(Grain::kShell) >= 0.25; }, readings);
            }
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::scale_levels_entry
