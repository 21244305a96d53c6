#include "tests/bench/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/bench/noise.hpp"

namespace terravox::bench {
namespace {

using Row = std::vector<std::string>;

std::string padded(const std::string& text, std::size_t width, bool right) {
    const std::string space(width - text.size(), ' ');
    return right ? space + text : text + space;
}

/// A Markdown table; columns from `first_number` on are numbers and stand to the right.
std::string table(const std::vector<Row>& rows, std::size_t first_number) {
    std::vector<std::size_t> widths(rows.front().size(), 3);
    for (const Row& row : rows)
        for (std::size_t c = 0; c < row.size(); ++c)
            widths[c] = std::max(widths[c], row[c].size());
    std::string out;
    for (std::size_t r = 0; r < rows.size(); ++r) {
        for (std::size_t c = 0; c < widths.size(); ++c)
            out += "| " + padded(rows[r][c], widths[c], c >= first_number) + " ";
        out += "|\n";
        if (r > 0)
            continue;
        for (std::size_t c = 0; c < widths.size(); ++c)
            out += "|" + (c >= first_number ? std::string(widths[c] + 1, '-') + ":"
                                            : std::string(widths[c] + 2, '-'));
        out += "|\n";
    }
    return out;
}

std::string machine_lines(const Report& report) {
    const Machine& m = report.machine;
    const auto known = [](const std::string& text) {
        return text.empty() ? std::string("unknown") : text;
    };
    std::string out = "- " + known(m.cpu) + ", " + std::to_string(m.cores) + " cores, " +
                      format_number(m.memory_gib) + " GiB, " + known(m.system) + "\n";
    out += "- terravox " + m.version + (m.commit.empty() ? "" : " (" + m.commit + ")") + ", " +
           known(m.compiler) + ", " + known(m.build_type) + "\n";
    out += "- " + m.date + ", load average " + format_number(m.load) + ", " +
           std::to_string(report.repeats.runs) + " runs after " +
           std::to_string(report.repeats.warmup) +
           " to warm up, Nt = " + std::to_string(report.threads) + " threads\n";
    for (const std::string& warning : report.warnings)
        out += "- **" + warning + "**\n";
    for (const Result& r : report.results)
        if (r.others_cores > kQuietCores)
            out += "- **noisy: other programs kept " + format_number(r.others_cores) +
                   " cores busy during " + r.name + "**\n";
    return out;
}

nlohmann::json to_json(const Metric& metric) {
    const Summary s = summarize(metric.values);
    nlohmann::json out = {{"name", metric.name},    {"unit", metric.unit}, {"median", s.median},
                          {"mad", s.mad},           {"min", s.min},        {"max", s.max},
                          {"values", metric.values}};
    if (metric.target.sense != Target::Sense::kNone)
        out["target"] = {{metric.target.sense == Target::Sense::kAtMost ? "at_most" : "at_least",
                          metric.target.bound},
                         {"met", metric.target.met_by(s.median)}};
    return out;
}

std::string target_cell(const Metric& metric, double median) {
    if (metric.target.sense == Target::Sense::kNone)
        return {};
    return std::string(metric.target.sense == Target::Sense::kAtMost ? "<= " : ">= ") +
           format_number(metric.target.bound) + (metric.target.met_by(median) ? " met" : " missed");
}

nlohmann::json to_json(const Result& result) {
    nlohmann::json metrics = nlohmann::json::array();
    for (const Metric& m : result.metrics)
        metrics.push_back(to_json(m));
    nlohmann::json out = {{"name", result.name},
                          {"measures", result.measures},
                          {"work", result.work},
                          {"status", status_name(result.status)},
                          {"metrics", metrics}};
    if (result.others_cores >= 0)
        out["others_cores"] = result.others_cores;
    if (!result.floor.empty())
        out["floor"] = result.floor;
    if (!result.reason.empty())
        out["reason"] = result.reason;
    if (!result.notes.empty())
        out["notes"] = result.notes;
    return out;
}

}  // namespace

std::string format_number(double value) {
    std::array<char, 64> text{};
    const double size = std::abs(value);
    if (size == 0)
        return "0";
    if (size < 0.001 || size >= 1e12)
        std::snprintf(text.data(), text.size(), "%.3e", value);
    else
        std::snprintf(text.data(), text.size(), "%.*f",
                      size >= 1000  ? 0
                      : size >= 100 ? 1
                      : size >= 10  ? 2
                      : size >= 1   ? 3
                                    : 4,
                      value);
    return text.data();
}

std::string to_json(const Report& report) {
    const Machine& m = report.machine;
    nlohmann::json out = {{"format", "terravox-bench"}, {"version", kReportVersion}};
    out["machine"] = {{"cpu", m.cpu},       {"cores", m.cores}, {"memory_gib", m.memory_gib},
                      {"system", m.system}, {"load", m.load},   {"date", m.date}};
    out["build"] = {{"terravox", m.version},
                    {"commit", m.commit},
                    {"compiler", m.compiler},
                    {"type", m.build_type}};
    out["settings"] = {{"repeats", report.repeats.runs},
                       {"warmup", report.repeats.warmup},
                       {"threads", report.threads}};
    out["warnings"] = report.warnings;
    out["entries"] = nlohmann::json::array();
    for (const Result& result : report.results)
        out["entries"].push_back(to_json(result));
    // A file name that is not UTF-8 must not cost the whole report.
    return out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string to_markdown(const Report& report) {
    std::vector<Row> rows = {{"entry", "metric", "unit", "median", "MAD", "min", "max"}};
    std::string others;
    std::string notes;
    const bool targets =
        std::any_of(report.results.begin(), report.results.end(), [](const Result& r) {
            return std::any_of(r.metrics.begin(), r.metrics.end(), [](const Metric& m) {
                return m.target.sense != Target::Sense::kNone;
            });
        });
    if (targets)
        rows.front().push_back("target");
    for (const Result& result : report.results) {
        for (const std::string& note : result.notes)
            notes += "\n" + result.name + ": " + note + "\n";
        if (result.status != Status::kMeasured)
            others += "- " + result.name + ": " + status_name(result.status) + ": " +
                      result.reason + "\n";
        for (std::size_t i = 0; i < result.metrics.size(); ++i) {
            const Metric& metric = result.metrics[i];
            const Summary s = summarize(metric.values);
            rows.push_back({i == 0 ? result.name : "", metric.name, metric.unit,
                            format_number(s.median), format_number(s.mad), format_number(s.min),
                            format_number(s.max)});
            if (targets)
                rows.back().push_back(target_cell(metric, s.median));
        }
    }
    std::string out = machine_lines(report);
    if (rows.size() > 1)
        out += "\n" + table(rows, 3);
    if (!others.empty())
        out += "\n" + others;
    return out + notes;
}

}  // namespace terravox::bench
