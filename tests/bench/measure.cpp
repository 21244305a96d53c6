#include "tests/bench/measure.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/util/error.hpp"
#include "tests/bench/noise.hpp"

namespace terravox::bench {

double measure_median(std::vector<double> values) {
    if (values.empty())
        throw util::Error("take the median: of no numbers");
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

Summary summarize(const std::vector<double>& values) {
    Summary out;
    out.median = measure_median(values);
    std::vector<double> deviations;
    for (const double v : values)
        deviations.push_back(std::abs(v - out.median));
    out.mad = measure_median(deviations);
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    out.min = *low;
    out.max = *high;
    out.count = values.size();
    return out;
}

const char* status_name(Status status) noexcept {
    switch (status) {
        case Status::kMeasured: return "measured";
        case Status::kSkipped: return "skipped";
        default: return "failed";
    }
}

void add_readings(std::vector<Metric>& metrics, const Readings& readings) {
    for (const Reading& reading : readings.list()) {
        auto at = std::find_if(metrics.begin(), metrics.end(),
                               [&](const Metric& m) { return m.name == reading.metric; });
        if (at == metrics.end())
            at = metrics.insert(metrics.end(),
                                Metric{reading.metric, reading.unit, {}, reading.target});
        if (at->unit != reading.unit)
            throw util::Error("collect the metric " + reading.metric + ": in " + reading.unit +
                              " now, in " + at->unit + " before");
        at->values.push_back(reading.value);
    }
}

Result measure(const Entry& entry, const Context& context, Repeats repeats,
               const std::atomic<bool>& stop) {
    Result out{entry.name, entry.measures, entry.work, entry.floor, Status::kMeasured, {}, {}, -1};
    if (entry.exact)
        repeats = {0, 1};
    try {
        out.reason = entry.missing ? entry.missing(context) : std::string();
        if (!out.reason.empty()) {
            out.status = Status::kSkipped;
            return out;
        }
        if (stop)
            throw util::Error("interrupted");
        const Body body = entry.prepare(context);
        std::optional<NoiseMeter> noise;
        for (int run = -repeats.warmup; run < repeats.runs; ++run) {
            if (run == 0)
                noise.emplace(context.children);
            Readings readings;
            if (!stop)
                body(readings);
            if (stop)
                throw util::Error("interrupted");
            if (run >= 0)
                add_readings(out.metrics, readings);
            out.notes = readings.notes();
        }
        out.others_cores = noise->others_cores();
    } catch (const std::exception& e) {
        out.status = Status::kFailed;
        out.reason = e.what();
        out.metrics.clear();
        out.notes.clear();
    }
    return out;
}

}  // namespace terravox::bench
