#include "tests/bench/accuracy/photo_mosaic_survey.hpp"

#include "voxelserver/survey/survey.hpp"

namespace terravox::bench {

PhotoMosaicSurvey photo_mosaic_survey(const std::filesystem::path& folder, int threads) {
    survey::SurveyOptions options;
    options.seed = 7;
    options.density = 8;
    options.square_m = PhotoMosaicSurvey::kSquare_m;
    options.squares_east = PhotoMosaicSurvey::kSquares;
    options.squares_north = PhotoMosaicSurvey::kSquares;
    options.origin_east_m = 462368;
    options.origin_north_m = 101360;
    options.photo_light = survey::PhotoLight{120, 32, 0.4, 0};
    options.threads = threads;
    options.folder = folder;
    if (!std::filesystem::exists(folder / "truth" / "place.json"))  // written last
        survey::run_survey(options, [](const survey::SquareReport&, std::size_t) {});
    PhotoMosaicSurvey out;
    for (const survey::SquareExtent& square : survey::squares_of(options)) {
        out.points.push_back(folder / (square.name() + ".laz"));
        out.photos.push_back(folder / "ortho" / (square.name() + ".tif"));
        out.albedos.push_back(folder / "truth" / ("albedo_" + square.name() + ".tif"));
    }
    return out;
}

}  // namespace terravox::bench
