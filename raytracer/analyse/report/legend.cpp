#include "raytracer/analyse/report/legend.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::analyse {
namespace {

/// Calls `take` with each value of a band, in the order of the file's blocks.
template <class Take>
void for_each_value(CellFile& cells, std::string_view band, const std::stop_token& stop,
                    const Take& take) {
    std::vector<float> values;
    cells.each_block(cells.block_px(), [&](const CellRectangle& area) {
        if (stop.stop_requested())
            throw util::Error("interrupted");
        cells.read(band, area, values);
        for (const float value : values)
            if (value != core::kNoData)
                take(static_cast<double>(value));
    });
}

}  // namespace

double BandStatistics::quantile(double share) const noexcept {
    const double wanted = share * static_cast<double>(cells);
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < kBins; ++i) {
        below += bins[i];
        if (static_cast<double>(below) >= wanted)
            return min + (max - min) * static_cast<double>(i + 1) / kBins;
    }
    return max;
}

BandStatistics measure_statistics(CellFile& cells, std::string_view band,
                                  const std::stop_token& stop) {
    BandStatistics out;
    double sum = 0;
    for_each_value(cells, band, stop, [&](double value) {
        out.min = out.cells == 0 ? value : std::min(out.min, value);
        out.max = out.cells == 0 ? value : std::max(out.max, value);
        sum += value;
        ++out.cells;
    });
    if (out.cells == 0)
        return out;
    out.mean = sum / static_cast<double>(out.cells);
    const double width = out.max - out.min;
    for_each_value(cells, band, stop, [&](double value) {
        const double share = width > 0 ? (value - out.min) / width : 0;
        const auto bin = static_cast<std::size_t>(share * BandStatistics::kBins);
        ++out.bins[std::min(bin, BandStatistics::kBins - 1)];
    });
    return out;
}

std::map<int, std::uint64_t> count_values(CellFile& cells, std::string_view band,
                                          const std::stop_token& stop) {
    std::map<int, std::uint64_t> out;
    for_each_value(cells, band, stop,
                   [&](double value) { ++out[static_cast<int>(std::lround(value))]; });
    return out;
}

namespace {

constexpr int kTicks = 5;
constexpr double kOutermost = 0.01;  // of the cells, on each side
constexpr int kDegreesAround = 360;

std::vector<Tick> ticks_between(double low, double high) {
    const double step = round_step(high - low, kTicks);
    std::vector<Tick> out;
    const double slack = (high - low) * 1e-9;
    for (double i = std::ceil((low - slack) / step); i * step <= high + slack; ++i)
        out.push_back({(i * step - low) / (high - low), number_text(i * step, step)});
    return out;
}

std::vector<Tick> points_of_the_compass() {
    return {{0, "N"}, {0.25, "E"}, {0.5, "S"}, {0.75, "W"}, {1, "N"}};
}

}  // namespace

map::Rgba8 Legend::to_colour(double value) const noexcept {
    if (has_categories(ramp))
        return colour_of_category(ramp, static_cast<int>(std::lround(value)));
    return colour_at(ramp, (value - low) / (high - low));
}

Legend scale_for(const BandStyle& style, const BandStatistics& statistics) {
    Legend out;
    out.ramp = style.ramp;
    out.low = style.low.value_or(statistics.quantile(kOutermost));
    out.high = style.high.value_or(statistics.quantile(1 - kOutermost));
    // A scale needs a length, also where all values are alike.
    if (!(out.high > out.low))
        out.high = out.low + std::max(1.0, std::abs(out.low) * 1e-3);
    const double step = round_step(out.high - out.low, kTicks);
    if (!style.low)
        out.low = std::floor(out.low / step) * step;
    if (!style.high)
        out.high = std::ceil(out.high / step) * step;
    const bool is_compass = style.ramp == Ramp::kAround && out.high == kDegreesAround;
    out.ticks = is_compass ? points_of_the_compass() : ticks_between(out.low, out.high);
    return out;
}

Legend categories_for(const BandStyle& style, const std::map<int, std::uint64_t>& counts) {
    Legend out;
    out.ramp = style.ramp;
    std::uint64_t all = 0;
    for (const auto& [number, count] : counts)
        all += count;
    for (const auto& [number, count] : counts)
        out.entries.push_back({number, name_of_category(style.ramp, number),
                               colour_of_category(style.ramp, number),
                               static_cast<double>(count) / static_cast<double>(all)});
    std::stable_sort(out.entries.begin(), out.entries.end(),
                     [](const LegendEntry& a, const LegendEntry& b) { return a.share > b.share; });
    return out;
}

double round_step(double length, int count) noexcept {
    const double about = length / count;
    const double ten = std::pow(10, std::floor(std::log10(about)));
    for (const double times : {1.0, 2.0, 5.0})
        if (times * ten >= about * (1 - 1e-9))
            return times * ten;
    return 10 * ten;
}

std::string number_text(double value, double step) {
    constexpr double kMaxDecimals = 9;
    const double needed = std::ceil(-std::log10(step) - 1e-9);
    const auto decimals = static_cast<int>(std::clamp(needed, 0.0, kMaxDecimals));
    char text[64];
    // No minus sign before a zero.
    std::snprintf(text, sizeof text, "%.*f", decimals, std::abs(value) < step / 2 ? 0.0 : value);
    return text;
}

std::string area_text(double cells, double cell_m) {
    constexpr double kHectare_m2 = 10'000;
    constexpr double kSquareKilometre_m2 = 1'000'000;
    const double m2 = cells * cell_m * cell_m;
    if (m2 >= kSquareKilometre_m2)
        return number_text(m2 / kSquareKilometre_m2, 0.01) + " km\u00b2";
    if (m2 >= kHectare_m2)
        return number_text(m2 / kHectare_m2, 0.01) + " ha";
    return number_text(m2, 0.1) + " m\u00b2";
}

}  // namespace terravox::analyse
