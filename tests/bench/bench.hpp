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

/// What a value should reach. It is printed next to the value and fails nothing: a bench measures,
/// a test judges.
struct Target {
    enum class Sense { kNone, kAtMost, kAtLeast };
    Sense sense = Sense::kNone;
    double bound = 0;
    [[nodiscard]] bool met_by(double value) const noexcept {
        return sense == Sense::kAtMost ? value <= bound : value >= bound;
    }
};
[[nodiscard]] inline Target at_most(double bound) noexcept {
    return {Target::Sense::kAtMost, bound};
}
[[nodiscard]] inline Target at_least(double bound) noexcept {
    return {Target::Sense::kAtLeast, bound};
}

struct Reading {
    std::string metric;
    std::string unit;
    double value = 0;
    Target target = {};
};

/// Takes the numbers of one run. A metric keeps its name and unit from run to run.
class Readings {
public:
    void add(std::string metric, std::string unit, double value, Target target = {}) {
        m_list.push_back({std::move(metric), std::move(unit), value, target});
    }
    /// Markdown that stands below the table, for what is no number: the report shows that of the
    /// last run.
    void note(std::string markdown) { m_notes.push_back(std::move(markdown)); }
    [[nodiscard]] const std::vector<Reading>& list() const noexcept { return m_list; }
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return m_notes; }

private:
    std::vector<Reading> m_list;
    std::vector<std::string> m_notes;
};

/// Does the fixed work once and reads the clocks.
using Body = std::function<void(Readings&)>;

/// One thing that is measured: fixed work, several numbers a run.
struct Entry {
    std::string name;      ///< "area/what/of-what": arguments select by its beginning
    std::string measures;  ///< one line: what the metrics are
    std::string work;      ///< one line: the fixed work
    std::string floor;     ///< what the ratios are to, measured in the same run; empty = no ratios
    /// Why it cannot run here (data or a peer are absent), one line; empty = it can. Cheap:
    /// `--list` calls it, too.
    std::function<std::string(const Context&)> missing;
    /// Everything that is not measured. @throws Error
    std::function<Body(const Context&)> prepare;
    bool exact = false;         ///< the numbers are the same in every run: one run, none to warm up
    bool only_by_name = false;  ///< minutes and gigabytes: runs only when its whole name is given
};

/// Adds entries before main starts. A file in entries/ holds one at namespace scope and stands in
/// CMakeLists.txt: nothing else names it.
class Registration {
public:
    explicit Registration(const std::function<std::vector<Entry>()>& make) noexcept;
};

/// All registered entries by name. @throws Error when two share one
[[nodiscard]] std::vector<Entry> registered_entries();

/// Those whose names begin with one of `prefixes`; all of them without any. Entries that want their
/// whole name are left out otherwise.
/// @param long_too beginnings select those, too @throws UsageError for a prefix that no entry has
[[nodiscard]] std::vector<Entry> select_entries(const std::vector<Entry>& entries,
                                                const std::vector<std::string>& prefixes,
                                                bool long_too = false);

/// Wall time of a call, seconds.
template <class Work>
[[nodiscard]] double measure_seconds(const Work& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace terravox::bench
