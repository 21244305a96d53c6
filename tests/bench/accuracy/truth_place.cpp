#include "tests/bench/accuracy/truth_place.hpp"

#include <cmath>

namespace terravox::bench {
namespace {

using survey::Box2;
using survey::Vec2;

Area measure_area(const survey::SurveyOptions& o) {
    const int width = o.square_m * o.squares_east;
    const int height = o.square_m * o.squares_north;
    return {o.origin_east_m, o.origin_north_m + height, width, height};
}

}  // namespace

survey::SurveyOptions accuracy_survey(const std::filesystem::path& folder, int threads) {
    survey::SurveyOptions options;
    options.squares_east = options.squares_north = 2;
    options.origin_east_m = 461500;
    options.origin_north_m = 100500;
    options.folder = folder;
    options.threads = threads;
    return options;
}

TruthPlace::TruthPlace(const survey::SurveyOptions& options, int threads)
    : area(measure_area(options)),
      model(
          options.seed,
          {options.origin_east_m, options.origin_north_m, options.square_m * options.squares_east},
          threads),
      columns(survey::true_columns(model)) {}

Vec2 TruthPlace::centre(std::size_t index) const noexcept {
    const auto width = static_cast<std::size_t>(area.width);
    const Box2 box = model.extent().box();
    return {box.x0 + static_cast<double>(index % width) + 0.5,
            box.y1 - static_cast<double>(index / width) - 0.5};
}

std::ptrdiff_t TruthPlace::find_column(Vec2 p) const noexcept {
    const Box2 box = model.extent().box();
    if (!box.contains(p))
        return -1;
    const int column = static_cast<int>(p.x - box.x0);
    const int row = static_cast<int>(box.y1 - p.y);
    return area.holds(column, row) ? static_cast<std::ptrdiff_t>(area.index(column, row)) : -1;
}

std::vector<TreeTop> TruthPlace::trees() const {
    const Box2 box = model.extent().box();
    std::vector<TreeTop> out;
    for (const survey::Tree& tree : model.trees())
        if (box.contains(tree.at))
            out.push_back({tree.at.x - box.x0, box.y1 - tree.at.y, tree.height_m, tree.radius_m});
    return out;
}

}  // namespace terravox::bench
