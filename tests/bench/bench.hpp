#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/bench/children.hpp"

namespace terravox::bench {

/// What entries may use. Outlives every entry's body.
struct Context {
    std::filesystem::path data;      ///< the shared test data
    std::filesystem::path programs;  ///< folder of the programs that are measured
    std::filesystem::path scratch;   ///< an empty folder that goes away in the end
    int threads = 1;                 ///< what "Nt" stands for in the names of metrics
    ChildRunner& children;
};

struct Reading {
    std::string metric, unit;
    double value = 0;
};

/// Takes the numbers of one run. A metric keeps its name and unit from run to run.
class Readings {
public:
    void add(std::string metric, std::string unit, double value) { m_list.push_back({std::move(metric), std::move(unit), value}); }
    [[nodiscard]] const std::vector<Reading>& list() const noexcept { return m_list; }

private:
    std::vector<Reading> m_list;
};

/// Does the fixed work once and reads the clocks.
using Body = std::function<void(Readings&)>;

/// One thing that is measured: fixed work, several numbers a run.
struct Entry {
    std::string name;      ///< "area/what/of-what": arguments select by its beginning
    std::string measures;  ///< one line: what the metrics are
    std::string work;      ///< one line: the fixed work
    std::string floor;     ///< what the ratios are to, measured in the same run; empty = no ratios
    /// Why it cannot run here (data or a peer are absent), one line; empty = it can. Cheap: `--list` asks too.
    std::function<std::string(const Context&)> missing;
    /// Everything that is not measured. @throws Error
    std::function<Body(const Context&)> prepare;
};

/// Adds entries before main starts. A file in entries/ holds one at namespace scope and stands in CMakeLists.txt: nothing else names it.
class Registration {
public:
    explicit Registration(const std::function<std::vector<Entry>()>& make) noexcept;
};

/// All registered entries by name. @throws Error when two share one
[[nodiscard]] std::vector<Entry> registered_entries();

/// Those whose names begin with one of `prefixes`; all of them without any.
/// @throws UsageError for a prefix that no entry has
[[nodiscard]] std::vector<Entry> select_entries(const std::vector<Entry>& entries, const std::vector<std::string>& prefixes);

/// Wall time of a call, seconds.
template <class Work>
[[nodiscard]] double seconds_of(const Work& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace terravox::bench
