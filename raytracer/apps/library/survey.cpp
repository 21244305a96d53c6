#include <terravox/survey.hpp>

#include <string>

#include "common/util/error.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/state.hpp"
#include "voxelserver/tools/survey/survey.hpp"

namespace terravox {
namespace {

void check(const char* name, double value, double least, double most) {
    if (!(value >= least && value <= most))
        throw util::UsageError("make a survey: " + std::string(name) + " = " +
                               std::to_string(value) + "; allowed: " + std::to_string(least) +
                               " to " + std::to_string(most));
}

survey::SurveyOptions make_options(const SurveyRequest& request) {
    check_threads(request.threads);
    check("density", request.density, 0.1, 200);
    check("squares_east", request.squares_east, 1, 100);
    check("squares_north", request.squares_north, 1, 100);
    check("square_m", request.square_m, 64, 1000);
    if (request.square_m % 16 != 0 && request.square_m != 1000)
        throw util::UsageError("make a survey: square_m = " + std::to_string(request.square_m) +
                               "; allowed: multiples of 16, and 1000");
    if (request.folder.empty())
        throw util::UsageError("make a survey: no folder; allowed: the path of one");
    survey::SurveyOptions out;
    out.seed = request.seed;
    out.density = request.density;
    out.squares_east = request.squares_east;
    out.squares_north = request.squares_north;
    out.square_m = request.square_m;
    out.threads = request.threads;
    out.folder = request.folder;
    return out;
}

}  // namespace

std::vector<std::string> make_survey(const SurveyRequest& request, const Control& control) {
    return guarded(control, [&] {
        note_process();
        const survey::SurveyOptions options = make_options(request);
        const std::size_t total = survey::list_squares(options).size();
        const auto reports =
            survey::run_survey(options, [&](const survey::SquareReport&, std::size_t done) {
                if (control.progress)
                    control.progress(done, total);
                check_stop(control);
            });
        std::vector<std::string> out;
        for (const survey::SquareReport& report : reports)
            out.push_back((options.folder / (report.name + ".laz")).string());
        return out;
    });
}

}  // namespace terravox
