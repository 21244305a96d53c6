#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "tests/bench/serve_script.hpp"

namespace terravox::bench::view_entry {
namespace {

constexpr double kMega = 1e6;
constexpr double kMebi = 1024.0 * 1024.0;

std::string missing(const Context& c) {
    const auto page = std::filesystem::path(TERRAVOX_SOURCE_DIR) / "voxelserver/page";
    std::error_code ignored;
    if (!std::filesystem::is_directory(page / "node_modules/playwright-core", ignored))
        return "no packages of the page (terravox deps)";
    const char* browser = std::getenv("TERRAVOX_CHROMIUM");
    const std::string chromium = browser != nullptr ? browser : "/usr/bin/chromium";
    if (!std::filesystem::is_regular_file(chromium, ignored))
        return "no " + chromium + ": install chromium, or name one with TERRAVOX_CHROMIUM";
    return missing_for_serving(c);
}

void add_first(const std::string& what, const nlohmann::json& first, double requests, double bytes,
               Readings& readings) {
    const auto value = [&](const char* name) { return first.at(name).get<double>(); };
    readings.add(what + ": requests", "requests", value("requests"), at_most(requests));
    readings.add(what + ": transferred", "MB", value("bytes") / kMega, at_most(bytes));
    readings.add(what + ": until it stands", "s", value("ms") / 1000, at_most(5));
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
    add_first("first picture", figures.at("first"), 25, 1.5, readings);
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

void measure_large(const Context& c, Readings& readings) {
    const auto figures = run_script(c, "view/square", {"--sizes", "1920x1080,3840x2160"});
    const auto& sizes = figures.at("sizes");
    for (const char* size : {"1920x1080", "3840x2160"})
        add_size(size, sizes.at(size), {}, readings);
    add_graphics(sizes.at("3840x2160"), readings);
}

Entry large() {
    Entry out;
    out.name = "view/large";
    out.measures = "the same at 1080p and 4K: for a machine with a graphics processor";
    out.work = "the demo's square and camera, 1920x1080 and 3840x2160";
    out.missing = missing;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) { measure_large(c, readings); };
    };
    out.only_by_name = true;
    return out;
}

void add_memory(const std::string& who, const nlohmann::json& figures, Readings& readings) {
    const auto value = [&](const char* name) {
        return figures.at(who + name).get<double>() / kMebi;
    };
    readings.add(who + ": heap, slope", "MiB/min", value("_used_slope"), at_most(0.1));
    readings.add(who + ": heap and arrays, slope", "MiB/min", value("_slope"));
    readings.add(who + ": heap, peak", "MiB", value("_used_peak"));
    readings.add(who + ": heap and arrays, peak", "MiB", value("_peak"));
}

void measure_flight(const Context& c, const std::string& seconds, Readings& readings) {
    const auto figures = run_script(c, "view/flight", {"--seconds", seconds});
    const auto value = [&](const char* name) { return figures.at(name).get<double>(); };
    add_first("first picture of 1 km2", figures.at("small"), 25, 1.5, readings);
    add_first("first picture of 100 km2", figures.at("large"), 50, 3, readings);
    readings.add("pools", "MiB", value("pool_bytes") / kMebi, at_most(256));
    readings.add("all textures, peak", "MiB", value("texture_bytes") / kMebi);
    readings.add("pools, largest share in use", "", value("fill"));
    readings.add("objects of WebGL that came and stayed", "", value("objects_more"), at_most(4));
    readings.add("textures made", "", value("textures_made"));
    readings.add("textures in the end", "", value("textures_live"));
    add_memory("page", figures, readings);
    add_memory("worker", figures, readings);
    readings.add("frames", "frames", value("frames"));
    readings.add("requests", "requests", value("requests"));
    readings.add("transferred", "MB", value("bytes") / kMega);
}

Entry flight(const std::string& name, const std::string& seconds) {
    Entry out;
    out.name = "view/flight/" + name;
    out.measures =
        "100 km2 in a browser: the first picture next to that of 1 km2, then a flight at 100 m/s: "
        "memory of the page, its worker and the graphics, objects that are left over";
    out.work = seconds +
               " s at 320x180 above a world of noise, whose archive of 0.5 GB is made before "
               "($TERRAVOX_BENCH_CACHE keeps it)";
    out.missing = missing;
    out.prepare = [seconds](const Context& c) -> Body {
        return [seconds, &c](Readings& readings) { measure_flight(c, seconds, readings); };
    };
    out.exact = out.only_by_name = true;
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

const Registration kRegistered([] {
    return std::vector{square(), large(), equality(), flight("1min", "60"), flight("10min", "600")};
});

}  // namespace
}  // namespace terravox::bench::view_entry
