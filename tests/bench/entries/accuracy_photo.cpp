#include <fmt/format.h>

#include <algorithm>

#include "tests/bench/accuracy/photo_flights.hpp"
#include "tests/bench/accuracy/photo_seams.hpp"
#include "tests/bench/bench.hpp"

namespace terravox::bench::accuracy_photo_entry {
namespace {

struct Worst {
    double azimuth_deg = 0;
    double altitude_deg = 0;
    double rmse_sum = 0;
    double contrast_sum = 0;
    int found = 0;
    int flights = 0;
    void add(const FlightErrors& e) {
        azimuth_deg = std::max(azimuth_deg, e.azimuth_deg);
        altitude_deg = std::max(altitude_deg, e.altitude_deg);
        rmse_sum += e.albedo_rmse / e.raw_rmse;
        contrast_sum += e.albedo_contrast / e.raw_contrast;
        found += e.found ? 1 : 0;
        ++flights;
    }
};

std::string row_of(const Flight& flight, const FlightErrors& e) {
    return fmt::format(
        "| {} | {:.0f}, {:.0f} | {:.1f} | {:.1f} | {} | {:.1f} | {:.1f} | {:.4f} | "
        "{:.4f} | {:.2f} | {:.2f} |\n",
        flight.seed, flight.light.azimuth_deg, flight.light.altitude_deg, flight.light.haze,
        flight.light.clouds, e.found ? "yes" : "no", e.azimuth_deg, e.altitude_deg, e.raw_rmse,
        e.albedo_rmse, e.albedo_rmse / e.raw_rmse, e.albedo_contrast / e.raw_contrast);
}

void measure(const Context& c, Readings& readings) {
    Worst clear;
    Worst dim;
    std::string table =
        "| seed | sun | haze | clouds | found | azimuth error | altitude error | RMSE raw | RMSE "
        "albedo | ratio | contrast left |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (const Flight& flight : photo_flights()) {
        const FlightErrors errors = measure_flight(
            flight, c.scratch / ("photo-flight-" + std::to_string(flight.seed)), c.threads);
        (flight.light.haze + flight.light.clouds > 0 ? dim : clear).add(errors);
        table += row_of(flight, errors);
    }
    const auto add = [&](const std::string& name, const Worst& w) {
        readings.add(name + ": suns found", "", static_cast<double>(w.found) / w.flights);
        readings.add(name + ": greatest error of azimuth", "degrees", w.azimuth_deg);
        readings.add(name + ": greatest error of altitude", "degrees", w.altitude_deg);
        readings.add(name + ": mean RMSE of albedo over that of the photograph", "",
                     w.rmse_sum / w.flights);
        readings.add(name + ": mean contrast left across edges of shadows", "",
                     w.contrast_sum / w.flights);
    };
    add("clear", clear);
    add("haze or clouds", dim);
    const SeamSteps steps = measure_seams(c.scratch / "photo-mosaic", c.threads);
    readings.add("mosaic of nine: step across borders of photographs", "log", steps.at_borders);
    readings.add("mosaic of nine: step across other lines", "log", steps.elsewhere);
    readings.note(table);
}

const Registration kRegistered([] {
    Entry out;
    out.name = "accuracy/photo";
    out.measures = "the sun of photographs, and their colours without light, against the truth";
    out.work =
        "twenty synthetic flights over squares of 512 m (8 pulses/m2, photographs of 0.5 m), and "
        "nine photographs of 256 m side by side; voxels of 1 m";
    out.missing = [](const Context&) { return std::string(); };
    out.exact = true;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) { measure(c, readings); };
    };
    return std::vector{out};
});

}  // namespace
}  // namespace terravox::bench::accuracy_photo_entry
