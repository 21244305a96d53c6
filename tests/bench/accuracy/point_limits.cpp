#include "tests/bench/accuracy/point_limits.hpp"

#include <cmath>
#include <mutex>

#include "common/thread/parallel.hpp"
#include "tests/bench/accuracy/errors.hpp"
#include "tests/bench/accuracy/measures.hpp"
#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/survey/scanner.hpp"

namespace terravox::bench {
namespace {

namespace las_class = survey::las_class;
using survey::kNoWater;

constexpr const char* kLimit = " (limit of the points)";

bool plant(std::uint8_t c) noexcept {
    return c >= las_class::kLowVegetation && c <= las_class::kHighVegetation;
}

}  // namespace

PointColumns read_point_columns(const std::vector<std::filesystem::path>& files,
                                const TruthPlace& truth, int threads) {
    PointColumns out;
    const std::size_t n = truth.area.size();
    out.points.resize(n);
    out.building.resize(n);
    out.bridge.resize(n);
    out.ground.resize(n);
    out.plant_m.assign(n, static_cast<float>(kNoWater));
    std::mutex mutex;
    double squares = 0;
    double count = 0;
    // A file for each thread: the columns of two squares are different ones.
    thread::parallel_for(files.size(), threads, [&](std::size_t f) {
        const lidar::LasInfo info = lidar::read_las_info(files[f]);
        double my_squares = 0;
        double my_count = 0;
        lidar::read_las_points(info, {0, info.point_count}, [&](const pointcloud::Point& p) {
            const survey::Vec2 at{p.x - survey::kPlaceEasting_m, p.y - survey::kPlaceNorthing_m};
            const std::ptrdiff_t column = truth.column_of(at);
            if (column < 0)
                return;
            const auto i = static_cast<std::size_t>(column);
            ++out.points[i];
            out.building[i] = static_cast<std::uint16_t>(
                out.building[i] + (p.classification == las_class::kBuilding));
            out.bridge[i] = static_cast<std::uint16_t>(out.bridge[i] +
                                                       (p.classification == las_class::kBridge));
            if (plant(p.classification))
                out.plant_m[i] = std::max(out.plant_m[i], static_cast<float>(p.z));
            if (p.classification != las_class::kGround)
                return;
            out.ground[i] = 1;
            const double off = p.z - truth.model.ground_m(at);
            my_squares += off * off;
            my_count += 1;
        });
        const std::lock_guard lock(mutex);
        squares += my_squares;
        count += my_count;
    });
    out.ground_rmse_m = std::sqrt(squares / std::max(1.0, count));
    return out;
}

void add_point_limits(const TruthPlace& truth, const PointColumns& points, const CrownWidth& width,
                      Readings& readings) {
    Overlap buildings;
    Overlap decks;
    Share beneath;
    std::vector<float> canopy(truth.area.size()), true_canopy(truth.area.size());
    for (std::size_t i = 0; i < truth.area.size(); ++i) {
        const survey::TrueColumn& real = truth.columns[i];
        buildings.add(2 * points.building[i] > points.points[i],
                      real.building != survey::TrueColumn::kNone);
        if (!buried_deck(real))
            decks.add(2 * points.bridge[i] > points.points[i], real.deck_m > kNoWater);
        if (tall_opening(real))
            beneath.add(points.ground[i] != 0);
        canopy[i] = std::max(0.0F, points.plant_m[i] - real.ground_m);
        true_canopy[i] = std::max(0.0F, real.crown_m - real.ground_m);
    }
    readings.add(std::string("ground RMSE") + kLimit, "m", points.ground_rmse_m);
    readings.add(std::string("building footprint IoU") + kLimit, "", buildings.iou());
    readings.add(std::string("bridge deck IoU") + kLimit, "", decks.iou());
    readings.add("overhang: columns with ground points beneath", "share", beneath.value());
    const auto trees = truth.trees();
    const TreeMatch by_points =
        match_trees(find_tree_tops(truth.area, canopy, width, kMinTree_m), trees, kMinTree_m);
    const TreeMatch by_truth =
        match_trees(find_tree_tops(truth.area, true_canopy, width, kMinTree_m), trees, kMinTree_m);
    readings.add(std::string("trees: F1") + kLimit, "", by_points.f1());
    readings.add("trees: F1 (the same detector on the true canopy)", "", by_truth.f1());
}

}  // namespace terravox::bench
