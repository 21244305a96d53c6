#include <cmath>
#include <cstdlib>
#include <numbers>

#include "common/geo/sun_position.hpp"
#include "common/geo/time_zone.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/random.hpp"
#include "raytracer/solar/clear_sky.hpp"
#include "raytracer/solar/sky_light.hpp"
#include "tests/bench/entries/light_picture.hpp"

namespace terravox::bench::analyse_entry {
namespace {

constexpr double kRad = std::numbers::pi / 180;

std::string python() {
    const char* asked = std::getenv("TERRAVOX_PYTHON");
    return asked != nullptr && *asked != '\0' ? asked : "python3";
}

std::string script(const std::string& file) {
    return TERRAVOX_SOURCE_DIR "/tests/bench/analyse/" + file;
}

/// Numbers of a case, each between two bounds.
class CaseNumbers {
public:
    explicit CaseNumbers(std::uint64_t number) noexcept : m_case(number) {}
    [[nodiscard]] double between(double low, double high) noexcept {
        return low + (high - low) * core::unit_from(core::hash64(m_case, m_next++));
    }

private:
    std::uint64_t m_case;
    std::uint64_t m_next = 0;
};

/// Directions of the sun at random places and times of 1950 to 2050.
nlohmann::json sun_cases() {
    constexpr int kCases = 10'000;
    constexpr double kFirst_s = -631'152'000;  // 1950-01-01
    constexpr double kLast_s = 2'556'143'999;  // 2050-12-31
    nlohmann::json out = nlohmann::json::array();
    for (int i = 0; i < kCases; ++i) {
        CaseNumbers numbers(static_cast<std::uint64_t>(i));
        const auto second = static_cast<std::int64_t>(numbers.between(kFirst_s, kLast_s));
        const double lat_deg = std::asin(numbers.between(-1, 1)) / kRad;
        const double lon_deg = numbers.between(-180, 180);
        const geo::SunPosition sun = geo::sun_position(geo::clock_at(second, 0), {lat_deg, lon_deg},
                                                       geo::SunPrecision::kAnalysis);
        out.push_back({second, lat_deg, lon_deg, sun.altitude_deg, sun.azimuth_deg});
    }
    return out;
}

/// Light on random planes that nothing stands in front of, by the formulas of solar/sky_light.hpp.
nlohmann::json plane_cases() {
    constexpr int kCases = 10'000;
    nlohmann::json out = nlohmann::json::array();
    for (int i = 0; i < kCases; ++i) {
        CaseNumbers numbers(static_cast<std::uint64_t>(kCases + i));
        const double altitude_deg = numbers.between(5, 85);
        const solar::Irradiance light{numbers.between(0, 900), numbers.between(10, 400)};
        const double outside =
            solar::extraterrestrial_w_m2(static_cast<int>(numbers.between(1, 366)));
        const double tilt_deg = numbers.between(0, 90);
        const double turn_deg = numbers.between(0, 360);
        const double altitude = altitude_deg * kRad;
        const double tilt = tilt_deg * kRad;
        const double cosine = std::cos(tilt) * std::sin(altitude) +
                              std::sin(tilt) * std::cos(altitude) * std::cos(turn_deg * kRad);
        const solar::SkyLight sky = solar::perez_light(light, altitude_deg, outside);
        const double towards = std::max(cosine, 0.0);
        const double diffuse = sky.isotropic * (1 + std::cos(tilt)) / 2 + sky.around_sun * towards +
                               sky.horizon * std::sin(tilt);
        out.push_back({altitude_deg, light.beam, light.diffuse, outside,
                       solar::air_mass(altitude_deg), tilt_deg, turn_deg, std::max(diffuse, 0.0),
                       light.beam * towards});
    }
    return out;
}

struct Row {
    const char* name;  ///< of the entry after "analyse/", and of its script
    const char* measures;
    const char* work;
    const char* modules;  ///< of Python, that it cannot do without
    bool needs_survey = false;
    bool needs_cases = false;
};
constexpr Row kRows[] = {
    {"sky", "sky-view factors against closed forms, and their cost, beside solweig",
     "streets, round basins, 10^6 cells of an invented town with 153 directions", "numpy"},
    {"shade", "shadow masks and hours of sun, beside an exact walk over heights, and solweig",
     "400 x 400 cells of an invented town, 21 June", "numpy, pandas, pvlib"},
    {"sight", "viewsheds beside gdal_viewshed and r.viewshed",
     "a square kilometre of a synthetic survey as heights, 6 observers", "numpy", true},
    {"sun", "directions of the sun and light on tilted planes, beside pvlib",
     "10,000 places and times of 1950 to 2050, 10,000 planes", "numpy, pandas, pvlib", false, true},
    {"energy", "clear days on level ground beside r.sun, cost of a year in half hours",
     "three days, and a square kilometre of a synthetic survey", "numpy", true},
    {"truth", "ground below bridges, crowns and arcades: sun and sky against the survey's truth",
     "300 cells of each on a synthetic survey of 8 points on a square metre",
     "numpy, pandas, pvlib", true},
    {"facades", "walls of houses: direction, area, sun and sky against the survey's truth",
     "houses that stand alone on a synthetic survey of 8 points on a square metre",
     "numpy, pandas, pvlib", true},
};

std::string missing(const Row& row, const Context& c) {
    for (const char* program : {"terravox-raytracer", "terravox-survey"}) {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(c.programs / program, ignored))
            return std::string("no ") + program + " in " + c.programs.string() + " (--programs)";
    }
    const auto said = c.scratch / "modules.txt";
    const auto runs = [&](const std::vector<std::string>& command) {
        return c.children.run(command, said).exit_code == 0;
    };
    if (!runs({"gdalinfo", "--version"}))
        return "no gdalinfo (Debian package gdal-bin)";
    if (!runs({python(), "-c", std::string("import ") + row.modules}))
        return python() + " lacks one of " + row.modules +
               " (TERRAVOX_PYTHON names another Python)";
    return {};
}

Target target_of(const std::string& bound) {
    if (bound.empty())
        return {};
    const double value = std::stod(bound.substr(2));
    return bound.starts_with("<=") ? at_most(value) : at_least(value);
}

void run(const Row& row, const Context& c, Readings& readings) {
    const auto folder = c.scratch / (std::string("analyse-") + row.name);
    std::filesystem::create_directories(folder);
    std::vector<std::string> command = {
        python(),        "-B",        script(std::string(row.name) + ".py"),
        folder.string(), "--program", (c.programs / "terravox-raytracer").string()};
    if (row.needs_survey)
        command.insert(command.end(), {"--survey", (c.scratch / "analyse-survey").string()});
    if (row.needs_cases)
        command.insert(command.end(), {"--cases", (folder / "cases.json").string()});
    const nlohmann::json figures = figures_of(c, command, folder / "figures.json");
    for (const auto& reading : figures.at("readings"))
        readings.add(reading.at(0).get<std::string>(), reading.at(1).get<std::string>(),
                     reading.at(2).get<double>(), target_of(reading.at(3).get<std::string>()));
    for (const auto& note : figures.at("notes"))
        readings.note(note.get<std::string>());
}

void prepare(const Row& row, const Context& c) {
    if (row.needs_cases) {
        const auto folder = c.scratch / (std::string("analyse-") + row.name);
        std::filesystem::create_directories(folder);
        const nlohmann::json cases = {{"sun", sun_cases()}, {"planes", plane_cases()}};
        util::write_file_atomically(folder / "cases.json", cases.dump());
    }
    const auto survey = c.scratch / "analyse-survey";
    if (!row.needs_survey || std::filesystem::exists(survey))
        return;
    const auto said = c.scratch / "analyse-survey.txt";
    const ChildOutcome outcome =
        c.children.run({(c.programs / "terravox-survey").string(), "--seed", "7", "--density", "8",
                        "-o", survey.string()},
                       said);
    if (outcome.exit_code != 0)
        throw util::Error("make a survey: " + last_line(said));
}

std::vector<Entry> entries() {
    std::vector<Entry> out;
    for (const Row& row : kRows) {
        Entry entry;
        entry.name = std::string("analyse/") + row.name;
        entry.measures = row.measures;
        entry.work = row.work;
        entry.floor = "the peers that are installed, in the same run";
        entry.missing = [&row](const Context& c) { return missing(row, c); };
        entry.prepare = [&row](const Context& c) -> Body {
            prepare(row, c);
            return [&row, &c](Readings& readings) { run(row, c, readings); };
        };
        entry.exact = true;  // the scripts look at many cells; only processor time differs
        out.push_back(std::move(entry));
    }
    return out;
}

const Registration kRegistered([] { return entries(); });

}  // namespace
}  // namespace terravox::bench::analyse_entry
