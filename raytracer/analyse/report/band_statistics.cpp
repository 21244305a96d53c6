#include "raytracer/analyse/report/band_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::analyse {
namespace {

/// Calls `take` with each value of a band, in the order of the file's blocks.
template <class Take>
void for_each_value(CellFile& cells, int band, const std::stop_token& stop, const Take& take) {
    std::vector<float> values;
    const int edge = cells.block_px();
    for (int y = 0; y < cells.rows(); y += edge)
        for (int x = 0; x < cells.columns(); x += edge) {
            if (stop.stop_requested())
                throw util::Error("interrupted");
            cells.read(
                band, {x, y, std::min(edge, cells.columns() - x), std::min(edge, cells.rows() - y)},
                values);
            for (const float value : values)
                if (value != core::kNoData)
                    take(static_cast<double>(value));
        }
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

BandStatistics statistics_of(CellFile& cells, int band, const std::stop_token& stop) {
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

std::map<int, std::uint64_t> counts_of(CellFile& cells, int band, const std::stop_token& stop) {
    std::map<int, std::uint64_t> out;
    for_each_value(cells, band, stop,
                   [&](double value) { ++out[static_cast<int>(std::lround(value))]; });
    return out;
}

}  // namespace terravox::analyse
