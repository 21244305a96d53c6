#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "tests/bench/programs.hpp"

namespace terravox::bench::view_entry {
namespace {

constexpr double kMega = 1e6;
constexpr double kMebi = 1024.0 * 1024.0;

std::string missing(const Context& c) {
    const auto page = std::filesystem::path(TERRAVOX_SOURCE_DIR) / "voxelserver/serve/page";
    std::error_code ignored;
    if (!std::filesystem::is_directory(page / "node_modules/playwright-core", ignored))
        return "no packages of the page (terravox deps)";
    const char* browser = std::getenv("TERRAVOX_CHROMIUM");
    const std::string chromium = browser != nullptr ? browser : "/usr/bin/chromium";
    if (!std::filesystem::is_regular_file(chromium, ignored))
        return "no " + chromium + ": install chromium, or name one with TERRAVOX_CHROMIUM";
    return missing_for_serving(c);
}

void add_first(const nlohmann::json& first, Readings& readings) {
    const auto value = [&](const char* name) { return first.at(name).get<double>(); };
    readings.add("first picture: requests", "requests", value("requests"), at_most(25));
    readings.add("first picture: transferred", "MB", value("bytes") / kMega, at_most(1.5));
    readings.add("first picture: until it stands", "s", value("ms") / 1000, at_most(5));
}

void add_size(const std::string& size, const nlohmann::json& of, Target pass, Readings& readings) {
    const auto value = [&](const char* name) { return of.at(name).get<double>(); };
    readings.add(size + ": a moving pass", "ms", value("moving_ms"), pass);
    readings.add(size + ": a still pass", "ms", value("still_ms"));
    readings.add(size + ": primary rays", "rays/s", value("rays_per_s"));
    readings.add(size + ": frames while turning", "frames/s", value("frames_per_s"));
    readings.add(size + ": pixels of such a frame", "pixels", value("moving_pixels"));
}

void add_graphics(const nlohmann::json& of, Readings& readings) {
    const auto value = [&](const char* name) { return of.at(name).get<double>(); };
    readings.add("pools", "MiB", value("pool_bytes") / kMebi, at_most(256));
    readings.add("all textures", "MiB", value("texture_bytes") / kMebi);
    readings.note("drawn by " + of.at("renderer").get<std::string>());
}

void measure_square(const Context& c, Readings& readings) {
    const auto figures = run_script(c, "view/square", {});
    add_first(figures.at("first"), readings);
    const double scripts = figures.at("script_bytes").get<double>();
    readings.add("page and scripts, gzip", "kB", scripts / 1000, at_most(250));
    const auto& sizes = figures.at("sizes");
    add_size("320x180", sizes.at("320x180"), at_most(150), readings);
    add_size("640x360", sizes.at("640x360"), {}, readings);
    add_graphics(sizes.at("640x360"), readings);
}

Entry square() {
    Entry out;
    out.name = "view/square";
    out.measures =
        "a published square kilometre in a browser: requests, bytes and seconds until the first "
        "whole picture; passes and rays while the camera turns and stands";
    out.work =
        "the demo's square and camera, 320x180 and 640x360, from a host on this machine; "
        "TERRAVOX_CHROMIUM_FLAGS, TERRAVOX_BENCH_VISIBLE=1";
    out.missing = missing;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) { measure_square(c, readings); };
    };
    return out;
}

void measure_equality(const Context& c, Readings& readings) {
    const auto figures = run_script(c, "view/equality", {});
    for (const auto& [name, of] : figures.at("cameras").items()) {
        const auto value = [&](const char* key) { return of.at(key).get<double>(); };
        readings.add(name + ": same voxel, face and level", "% of pixels", 100 * value("same"),
                     at_least(99.9));
        readings.add(name + ": same shadow", "% of pixels", 100 * value("lit"), at_least(99.5));
        readings.add(name + ": direct light, RMSE / mean", "%", 100 * value("rmse"), at_most(3));
        readings.add(name + ": levels in the picture", "", value("levels"));
    }
    const auto dates = figures.at("dates").get<std::vector<double>>();
    readings.add("dates: same shadow, least", "% of pixels",
                 100 * *std::min_element(dates.begin(), dates.end()), at_least(99.5));
    readings.add("dates", "", static_cast<double>(dates.size()));
}

Entry equality() {
    Entry out;
    out.name = "view/equality";
    out.measures =
        "the viewer's picture next to the ray tracer's, pixel by pixel: first voxel, face and "
        "level, hard shadows, one sample of direct light";
    out.work = "the demo's square at 640x360, three cameras, 20 dates over a year and its days";
    out.missing = missing;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) { measure_equality(c, readings); };
    };
    out.exact = out.only_by_name = true;
    return out;
}

const Registration kRegistered([] { return std::vector{square(), equality()}; });

}  // namespace
}  // namespace terravox::bench::view_entry
