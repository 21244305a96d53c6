#include <cpl_conv.h>
#include <gdal_priv.h>

#include <map>
#include <set>

#include "common/geo/gdal.hpp"
#include "tests/voxelserver/tools/survey/survey_fixture.hpp"
#include "voxelserver/tools/survey/scanner.hpp"

using namespace terravox::survey;
using namespace terravox::survey::test;

namespace {

std::vector<std::string> list_files(const std::string& name) {
    return {name + ".laz", "ortho/" + name + ".tif", "truth/ground_" + name + ".tif",
            "truth/kind_" + name + ".tif", "truth/truth_" + name + ".json"};
}

const auto kQuiet = [](const SquareReport&, std::size_t) {};

}  // namespace

TEST_CASE("another seed gives another place", "[survey]") {
    const TemporaryFolder one, two;
    auto options = small_survey(one.path());
    options.square_m = 128;
    const auto reports = run_survey(options, kQuiet);
    options.folder = two.path();
    options.seed = 8;
    run_survey(options, kQuiet);
    for (const auto& file : list_files(reports.front().name))
        CHECK(read_content(one.path() / file) != read_content(two.path() / file));
}

TEST_CASE("a square depends neither on threads nor on which survey it belongs to", "[survey]") {
    const TemporaryFolder alone, among;
    auto options = small_survey(among.path());
    options.square_m = 128;
    options.photo_light = PhotoLight{150, 35, 0.2, 0.3};
    options.squares_east = 2;
    options.threads = 2;
    const std::string name = run_survey(options, kQuiet).back().name;
    options.folder = alone.path();
    options.squares_east = 1;
    options.origin_east_m += 128;
    options.threads = 1;
    run_survey(options, kQuiet);
    for (const auto& file : list_files(name)) {
        INFO(file);
        CHECK(read_content(alone.path() / file) == read_content(among.path() / file));
    }
    CHECK(read_content(alone.path() / "truth" / ("albedo_" + name + ".tif")) ==
          read_content(among.path() / "truth" / ("albedo_" + name + ".tif")));
}

TEST_CASE("points lie in their square and neighbours share none", "[survey]") {
    const TemporaryFolder folder;
    auto options = small_survey(folder.path());
    options.square_m = 128;
    const auto whole = list_squares(small_survey(folder.path())).front();
    options.squares_east = options.squares_north = 2;
    std::size_t in_parts = 0;
    for (const auto& extent : list_squares(options)) {
        survey_square(options, extent, 1);
        std::vector<double> bounds;
        const auto points = list_points(folder.path() / (extent.name() + ".laz"), &bounds);
        in_parts += points.size();
        const auto east = static_cast<double>(extent.east_m);
        const auto north = static_cast<double>(extent.north_m);
        CHECK(bounds[0] >= east - 1e-6);
        CHECK(bounds[1] < east + 128 - 5e-3);
        CHECK(bounds[2] >= north - 1e-6);
        CHECK(bounds[3] < north + 128 - 5e-3);
    }
    const auto report = survey_square(small_survey(folder.path()), whole, 1);
    CHECK(report.points == in_parts);
}

TEST_CASE("the files of a square say what they are", "[survey]") {
    const TemporaryFolder folder;
    const auto options = small_survey(folder.path());
    const auto report = run_survey(options, kQuiet).front();
    CHECK(report.name == "TM_462400_101240");
    const auto points = list_points(folder.path() / (report.name + ".laz"));
    CHECK(points.size() == report.points);

    {
        INFO("the classes are those of the description");
        std::set<int> classes;
        for (const auto& point : points)
            classes.insert(point.classification);
        for (const int wanted : {2, 3, 4, 5, 6, 9})
            CHECK(classes.count(wanted) == 1);
        const std::set<int> known = {2, 3, 4, 5, 6, 7, 9, 14, 15, 17, 18};
        for (const int found : classes)
            CHECK(known.count(found) == 1);
    }
    {
        INFO(
            "time runs forward in each strip, and returns of a pulse come together, highest first");
        std::map<int, double> last_time;
        int wrong_times = 0;
        int wrong_returns = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto& point = points[i];
            const auto seen = last_time.find(point.strip);
            if (seen != last_time.end() && point.time_s < seen->second)
                ++wrong_times;
            last_time[point.strip] = point.time_s;
            if (point.return_number < 1 || point.return_number > point.return_count)
                ++wrong_returns;
            if (i > 0 && points[i - 1].time_s == point.time_s &&
                points[i - 1].strip == point.strip &&
                (points[i - 1].return_number >= point.return_number ||
                 points[i - 1].z < point.z - 1e-9))
                ++wrong_returns;
        }
        CHECK(wrong_times == 0);
        CHECK(wrong_returns == 0);
    }
    {
        INFO("ground points lie on the true ground");
        terravox::geo::start_gdal();
        GDALDatasetUniquePtr image{GDALDataset::Open(
            (folder.path() / "truth" / ("ground_" + report.name + ".tif")).c_str(),
            GDAL_OF_RASTER)};
        REQUIRE(image);
        std::vector<float> truth(256 * 256);
        REQUIRE(image->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, 256, 256, truth.data(), 256, 256,
                                                  GDT_Float32, 0, 0) == CE_None);
        double squares = 0;
        std::size_t count = 0;
        std::size_t far = 0;
        for (const auto& point : points) {
            if (point.classification != 2)
                continue;
            const auto column = static_cast<std::size_t>(point.x - 462400.0);
            const auto row = static_cast<std::size_t>(101240.0 + 256.0 - point.y);
            const double off = point.z - truth[std::min<std::size_t>(row, 255) * 256 + column];
            if (std::abs(off) > 1.5)
                ++far;  // only cliffs change as much within half a pixel
            else {
                squares += off * off;
                ++count;
            }
        }
        REQUIRE(count > 10000);
        CHECK(std::sqrt(squares / static_cast<double>(count)) < 0.25);
        CHECK(static_cast<double>(far) < 0.01 * static_cast<double>(count));
    }
}
