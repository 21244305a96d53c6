#include "voxelserver/tools/survey/survey_options.hpp"

#include <charconv>
#include <CLI/CLI.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/program.hpp"
#include "common/util/version.hpp"

namespace terravox::survey {
namespace {

constexpr double kMinDensity = 0.1;
constexpr double kMaxDensity = 200;
constexpr int kMaxSquares = 100;
constexpr int kMinSquare_m = 64;
constexpr int kSquareStep_m = 16;
constexpr int kKilometre_m = 1000;
constexpr int kMaxThreads = 1024;
constexpr double kMaxOrigin_km = 1000;

constexpr const char* kAbout =
    "Makes up a place and surveys it from the air: LAZ squares, orthophotos and the truth.\n"
    "The place: a lake with an island church, a castle on a cliff, a village, a river with "
    "bridges, fields, forests and hills,\n"
    "with further villages, lakes and valleys around it without end. It hangs on the seed alone; "
    "the square TM_462_101 shows\n"
    "the main place. Squares smaller than 1 km start around its middle unless --origin says "
    "otherwise.";

[[noreturn]] void refuse(const std::string& option, const std::string& value,
                         const std::string& allowed) {
    throw util::UsageError("read the option " + option + ": '" + value + "'; allowed: " + allowed);
}

template <class Number>
Number to_number(const std::string& option, const std::string& text, const std::string& allowed) {
    Number value{};
    const char* const end = text.data() + text.size();
    const auto [stopped, failed] = std::from_chars(text.data(), end, value);
    if (failed != std::errc{} || stopped != end || text.empty())
        refuse(option, text, allowed);
    return value;
}

/// The values of the options as they were typed.
struct Texts {
    std::string seed = "7";
    std::string squares = "1x1";
    std::string density = "8";
    std::string origin;
    std::string square_m = "1000";
    std::string threads = "0";
    std::string photo_sun;
    std::string photo_haze;
    std::string photo_clouds;
    std::string folder;
};

std::pair<std::string, std::string> halves(const std::string& option, const std::string& text,
                                           char mark, const std::string& allowed) {
    const auto at = text.find(mark);
    if (at == std::string::npos)
        refuse(option, text, allowed);
    return {text.substr(0, at), text.substr(at + 1)};
}

void read_squares(const std::string& text, SurveyOptions& options) {
    const std::string allowed = "<east>x<north>, each 1 to " + std::to_string(kMaxSquares);
    const auto [east, north] = halves("--squares", text, 'x', allowed);
    options.squares_east = to_number<int>("--squares", east, allowed);
    options.squares_north = to_number<int>("--squares", north, allowed);
    const auto good = [](int n) { return n >= 1 && n <= kMaxSquares; };
    if (!good(options.squares_east) || !good(options.squares_north))
        refuse("--squares", text, allowed);
}

void read_square_m(const std::string& text, SurveyOptions& options) {
    const std::string allowed =
        "1000, or a multiple of 16 from " + std::to_string(kMinSquare_m) + " to 992";
    const int side = to_number<int>("--square-m", text, allowed);
    if (side != kKilometre_m &&
        (side % kSquareStep_m != 0 || side < kMinSquare_m || side > kKilometre_m))
        refuse("--square-m", text, allowed);
    options.square_m = side;
}

std::int64_t whole_metres(const std::string& text, const std::string& all,
                          const std::string& allowed) {
    const double km = to_number<double>("--origin", text, allowed);
    const double metres = std::floor(km * 1000.0 + 0.5);
    if (!(km >= 0 && km <= kMaxOrigin_km) || std::abs(metres - km * 1000.0) > 1e-3)
        refuse("--origin", all, allowed);
    return static_cast<std::int64_t>(metres);
}

void read_origin(const std::string& text, SurveyOptions& options) {
    if (text.empty()) {
        // The first square is centred on the place, its corner on a multiple of 16 m (or on the
        // kilometre).
        const std::int64_t back = options.square_m / 2;
        const std::int64_t step = options.square_m == kKilometre_m ? 1 : kSquareStep_m;
        options.origin_east_m = (static_cast<std::int64_t>(kPlaceEasting_m) - back) / step * step;
        options.origin_north_m = (static_cast<std::int64_t>(kPlaceNorthing_m) - back) / step * step;
        return;
    }
    const std::string allowed = "<east>,<north> in km, each 0 to 1000 and on a whole metre";
    const auto [east, north] = halves("--origin", text, ',', allowed);
    options.origin_east_m = whole_metres(east, text, allowed);
    options.origin_north_m = whole_metres(north, text, allowed);
}

double parse_share(const std::string& option, const std::string& text) {
    const std::string allowed = "0 to 1";
    if (text.empty())
        return 0;
    const double share = to_number<double>(option, text, allowed);
    if (!(share >= 0 && share <= 1))
        refuse(option, text, allowed);
    return share;
}

std::optional<PhotoLight> photo_light(const Texts& texts) {
    const std::string allowed =
        "<azimuth>,<altitude> in degrees, azimuth 0 to 360, altitude 10 to 85";
    if (texts.photo_sun.empty()) {
        for (const auto& [option, text] : {std::pair{"--photo-haze", texts.photo_haze},
                                           std::pair{"--photo-clouds", texts.photo_clouds}})
            if (!text.empty())
                refuse(option, text, "only together with --photo-sun");
        return std::nullopt;
    }
    const auto [azimuth, altitude] = halves("--photo-sun", texts.photo_sun, ',', allowed);
    PhotoLight light;
    light.azimuth_deg = to_number<double>("--photo-sun", azimuth, allowed);
    light.altitude_deg = to_number<double>("--photo-sun", altitude, allowed);
    if (!(light.azimuth_deg >= 0 && light.azimuth_deg <= 360 && light.altitude_deg >= 10 &&
          light.altitude_deg <= 85))
        refuse("--photo-sun", texts.photo_sun, allowed);
    light.haze = parse_share("--photo-haze", texts.photo_haze);
    light.clouds = parse_share("--photo-clouds", texts.photo_clouds);
    return light;
}

SurveyOptions check_options(const Texts& texts) {
    SurveyOptions options;
    options.seed = to_number<std::uint64_t>("--seed", texts.seed, "0 to 18446744073709551615");
    const std::string densities = "0.1 to 200 pulses per square metre";
    options.density = to_number<double>("--density", texts.density, densities);
    if (!(options.density >= kMinDensity && options.density <= kMaxDensity))
        refuse("--density", texts.density, densities);
    read_squares(texts.squares, options);
    read_square_m(texts.square_m, options);
    read_origin(texts.origin, options);
    const std::string threads = "0 (one for each core) to " + std::to_string(kMaxThreads);
    options.threads = to_number<int>("--threads", texts.threads, threads);
    if (options.threads < 0 || options.threads > kMaxThreads)
        refuse("--threads", texts.threads, threads);
    options.photo_light = photo_light(texts);
    options.folder = texts.folder;
    return options;
}

}  // namespace

std::optional<SurveyOptions> parse_options(int argc, const char* const* argv,
                                           std::optional<int>& exit_code) {
    Texts texts;
    CLI::App app(kAbout, "terravox survey");
    app.set_version_flag("--version", std::string("terravox survey ") + kVersion);
    app.add_option("--seed", texts.seed, "which place: 0 to 2^64 - 1")
        ->type_name("N")
        ->capture_default_str();
    app.add_option("--squares", texts.squares,
                   "how many squares to the east and to the north, each 1 to 100")
        ->type_name("ExN")
        ->capture_default_str();
    app.add_option("--density", texts.density,
                   "laser pulses per square metre on average, 0.1 to 200")
        ->type_name("D")
        ->capture_default_str();
    app.add_option("--square-m", texts.square_m,
                   "side of a square in metres: 1000, or a multiple of 16 from 64")
        ->type_name("M")
        ->capture_default_str();
    app.add_option("--origin", texts.origin,
                   "south-west corner in km of EPSG:3794, on a whole metre [462,101; for smaller "
                   "squares the middle of the place]")
        ->type_name("E,N");
    app.add_option("--photo-sun", texts.photo_sun,
                   "where the sun stands in the orthophotos, in degrees: azimuth from grid north 0 "
                   "to 360, altitude 10 to 85; they then have cast shadows, and truth/ has what "
                   "they would be without light [no sun, no shadows]")
        ->type_name("AZIMUTH,ALTITUDE");
    app.add_option("--photo-haze", texts.photo_haze,
                   "haze over the orthophotos, with --photo-sun: 0 to 1 [0]")
        ->type_name("H");
    app.add_option("--photo-clouds", texts.photo_clouds,
                   "how much of the sun the shadows of clouds take away, with --photo-sun: 0 to 1 "
                   "[0]")
        ->type_name("C");
    app.add_option("--threads", texts.threads,
                   "0 = one for each core; the output is the same for any number")
        ->type_name("N")
        ->capture_default_str();
    app.add_option("-o,--output", texts.folder, "folder to write to; made when missing")
        ->type_name("DIR")
        ->required();
    exit_code = util::parse_arguments(app, argc, argv);
    return exit_code ? std::nullopt : std::optional(check_options(texts));
}

}  // namespace terravox::survey
