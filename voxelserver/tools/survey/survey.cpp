#include "voxelserver/tools/survey/survey.hpp"

#include <chrono>
#include <mutex>
#include <span>

#include "common/thread/parallel.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"
#include "voxelserver/tools/survey/orthophoto.hpp"
#include "voxelserver/tools/survey/scanner.hpp"
#include "voxelserver/tools/survey/truth.hpp"

namespace terravox::survey {
std::vector<SquareExtent> list_squares(const SurveyOptions& options) {
    std::vector<SquareExtent> squares;
    for (int north = 0; north < options.squares_north; ++north)
        for (int east = 0; east < options.squares_east; ++east)
            squares.push_back({options.origin_east_m + std::int64_t{options.square_m} * east,
                               options.origin_north_m + std::int64_t{options.square_m} * north,
                               options.square_m});
    return squares;
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
