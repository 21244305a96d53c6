#include <cmath>

#include "tests/bench/accuracy/errors.hpp"
#include "tests/bench/accuracy/measures.hpp"

namespace terravox::bench {
namespace {

constexpr double kSteep =
    0.7;  ///< rise over run; half a metre sideways there is more than a third of a metre in height

void add(const std::string& where, const Errors& errors, Target target, Readings& readings) {
    readings.add("ground RMSE, " + where, "m", errors.rmse(), target);
    readings.add("ground bias, " + where, "m", errors.bias());
}

}  // namespace

void measure_ground(const TruthPlace& truth, const VoxelField& found, Readings& readings) {
    Errors open;
    Errors steep;
    Errors trees;
    Errors buildings;
    Share known;
    for (std::size_t i = 0; i < truth.area.size(); ++i) {
        const survey::TrueColumn& real = truth.columns[i];
        if (real.water_m > survey::kNoWater || real.deck_m > survey::kNoWater)
            continue;
        const double ground_m = found.ground_m(i);
        known.add(!std::isnan(ground_m));
        if (std::isnan(ground_m))
            continue;
        const double off = ground_m - static_cast<double>(real.ground_m);
        if (real.building != survey::TrueColumn::kNone)
            buildings.add(off);
        else if (real.crown_m > survey::kNoWater)
            trees.add(off);
        else if (length(truth.model.gradient(truth.centre(i))) > kSteep)
            steep.add(off);
        else
            open.add(off);
    }
    Errors all_open = open;
    all_open.add(steep);
    add("open", all_open, at_most(0.15), readings);
    add("open, below 35 degrees", open, {}, readings);
    add("under trees", trees, {}, readings);
    add("under buildings", buildings, {}, readings);
    readings.add("ground known", "share", known.value());
}

}  // namespace terravox::bench
