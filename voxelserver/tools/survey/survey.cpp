#include "voxelserver/tools/survey/survey.hpp"

#include <charconv>
#include <chrono>
#include <CLI/CLI.hpp>
#include <mutex>
#include <span>

#include "common/thread/parallel.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/command_line.hpp"
#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"
#include "voxelserver/tools/survey/orthophoto.hpp"
#include "voxelserver/tools/survey/scanner.hpp"
#include "voxelserver/tools/survey/truth.hpp"

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

SurveyOptions checked(const Texts& texts) {
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

std::vector<SquareExtent> list_squares(const SurveyOptions& options) {
    std::vector<SquareExtent> squares;
    for (int north = 0; north < options.squares_north; ++north)
        for (int east = 0; east < options.squares_east; ++east)
            squares.push_back({options.origin_east_m + std::int64_t{options.square_m} * east,
                               options.origin_north_m + std::int64_t{options.square_m} * north,
                               options.square_m});
    return squares;
}

std::optional<SurveyOptions> parse_options(int argc, const char* const* argv, std::string& answer) {
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
    if (util::wants_option_tables(argc, argv)) {
        answer = util::option_tables(app);
        return std::nullopt;
    }
    const std::span arguments(argv + 1, argc > 1 ? static_cast<std::size_t>(argc) - 1 : 0);
    util::refuse_misread_arguments(app, arguments);
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        answer = util::help_text(app, arguments);
        return std::nullopt;
    } catch (const CLI::CallForVersion& version) {
        answer = std::string(version.what()) + "\n";
        return std::nullopt;
    } catch (const CLI::ParseError& error) {
        throw util::UsageError(util::usage_message(app, error, arguments));
    }
    return checked(texts);
}

namespace {

constexpr double kScale_m = 0.01;
/// A pulse with its foot this far outside may still hit a steeple inside.
constexpr double kFootMargin_m = 24;
constexpr std::uint16_t kSurveyYear = 2026,
                        kSurveyDay = 172;  ///< written into the files; fixed, so that bytes are

std::int64_t hundredths(double v) noexcept {
    return static_cast<std::int64_t>(std::floor(v * 100.0 + 0.5));
}

/// Receives points in the place frame and writes those of one square. Which square a point belongs
/// to is decided after it is rounded to the file's resolution, so that of two neighbours exactly
/// one writes it.
class PointSink {
public:
    PointSink(const std::filesystem::path& path, const SquareExtent& extent)
        : m_writer(path, options_for(extent)),
          m_west(extent.east_m * 100),
          m_south(extent.north_m * 100),
          m_size(extent.size_m * std::int64_t{100}) {}

    void write(const Pulse& pulse, const ScanPoint& point) {
        const auto east = hundredths(point.at.x + kPlaceEasting_m);
        const auto north = hundredths(point.at.y + kPlaceNorthing_m);
        if (east < m_west || east >= m_west + m_size || north < m_south ||
            north >= m_south + m_size)
            return;
        lidar::LasWritePoint out;
        out.x = static_cast<double>(east) * kScale_m;
        out.y = static_cast<double>(north) * kScale_m;
        out.z = point.height_m;
        out.intensity = point.intensity;
        out.classification = point.classification;
        out.return_number = point.return_number;
        out.return_count = point.number_of_returns;
        out.forward_scan = pulse.forward;
        out.line_edge = pulse.strip_edge;
        out.scan_angle_deg = pulse.angle_deg;
        out.point_source = pulse.strip;
        out.gps_time_s = pulse.time_s;
        m_writer.write(out);
    }
    std::uint64_t close() {
        m_writer.close();
        return m_writer.point_count();
    }

private:
    static lidar::LasWriterOptions options_for(const SquareExtent& extent) {
        lidar::LasWriterOptions options;
        options.scale = {kScale_m, kScale_m, kScale_m};
        options.offset = {static_cast<double>(extent.east_m), static_cast<double>(extent.north_m),
                          0};
        options.wkt = survey_wkt1();
        options.system_identifier = "made-up airborne survey";
        options.creation_year = kSurveyYear;
        options.creation_day = kSurveyDay;
        return options;
    }
    lidar::LasWriter m_writer;
    std::int64_t m_west;
    std::int64_t m_south;
    std::int64_t m_size;
};

std::uint64_t write_points(const SurveyOptions& options, const SquareModel& model,
                           const std::filesystem::path& path) {
    const Scanner scanner(model);
    PointSink sink(path, model.extent());
    ScanPattern(options.seed, options.density)
        .visit(model.extent().box().expanded(kFootMargin_m), [&](const Pulse& pulse) {
            const Returns returns = scanner.shoot(pulse);
            for (int i = 0; i < returns.count; ++i)
                sink.write(pulse, returns.points[static_cast<std::size_t>(i)]);
        });
    return sink.close();
}

void write_text(const std::filesystem::path& path, const std::string& text) {
    util::write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

SquareReport survey_square(const SurveyOptions& options, const SquareExtent& extent, int threads) {
    const auto start = std::chrono::steady_clock::now();
    SquareReport report;
    report.name = extent.name();
    const auto points_path = options.folder / (report.name + ".laz");
    const auto ortho_path = options.folder / "ortho" / (report.name + ".tif");
    const auto ground_path = options.folder / "truth" / ("ground_" + report.name + ".tif");
    const auto kind_path = options.folder / "truth" / ("kind_" + report.name + ".tif");
    const auto albedo_path = options.folder / "truth" / ("albedo_" + report.name + ".tif");
    const auto truth_path = options.folder / "truth" / ("truth_" + report.name + ".json");
    const SquareModel model(options.seed, extent, threads);
    thread::parallel_for(2, threads, [&](std::size_t half) {
        if (half == 0) {
            report.points = write_points(options, model, points_path);
            return;
        }
        if (options.photo_light) {
            const LitPhoto lit = take_photo(model, *options.photo_light);
            write_geotiff(ortho_path, extent, lit.photo);
            write_geotiff(albedo_path, extent, lit.albedo);
        } else
            write_geotiff(ortho_path, extent, paint_orthophoto(model));
        write_geotiff(ground_path, extent, true_ground(model));
        write_geotiff(kind_path, extent, true_kinds(model));
        write_text(truth_path, truth_json(model));
    });
    for (const auto& path : {points_path, ortho_path, ground_path, kind_path, truth_path})
        report.bytes += std::filesystem::file_size(path);
    if (options.photo_light)
        report.bytes += std::filesystem::file_size(albedo_path);
    report.seconds = seconds_since(start);
    return report;
}

std::vector<SquareReport> run_survey(
    const SurveyOptions& options,
    const std::function<void(const SquareReport&, std::size_t)>& progress) {
    const auto squares = list_squares(options);
    const int threads = thread::thread_count(options.threads);
    util::check_writable(options.folder / "truth" / "place.json");
    std::vector<SquareReport> reports(squares.size());
    std::mutex one_at_a_time;
    std::size_t done = 0;
    // One square for each thread; with fewer squares than threads, each square is split instead.
    const int inside = squares.size() >= static_cast<std::size_t>(threads) ? 1 : threads;
    thread::parallel_for(squares.size(), threads, [&](std::size_t i) {
        reports[i] = survey_square(options, squares[i], inside);
        const std::lock_guard lock(one_at_a_time);
        progress(reports[i], ++done);
    });
    write_text(options.folder / "truth" / "place.json", place_json(options));
    return reports;
}

}  // namespace terravox::survey
