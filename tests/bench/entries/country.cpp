#include <algorithm>
#include <cmath>
#include <fstream>

#include "tests/bench/entries/data_sets.hpp"
#include "tests/bench/moved_square.hpp"
#include "tests/bench/programs.hpp"

namespace terravox::bench::country_entry {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// n x n copies of the square side by side, 1 km apart.
fs::path make_squares(const Context& c, int n) {
    const fs::path folder = c.scratch / ("country-" + std::to_string(n));
    fs::create_directories(folder);
    for (int north = 0; north < n; ++north)
        for (int east = 0; east < n; ++east)
            copy_moved(square().paths(c).front(),
                       folder / ("TM_" + std::to_string(462 + east) + "_" +
                                 std::to_string(101 + north) + ".laz"),
                       1000.0 * east, 1000.0 * north);
    return folder;
}

/// The programs on one country, each from an empty folder.
class Run {
public:
    Run(const Context& c, fs::path data, int shards)
        : m_c(c), m_data(std::move(data)), m_shards(shards), m_place(c.scratch / "country") {
        fs::remove_all(m_place);
        fs::create_directories(m_place);
    }
    ~Run() { fs::remove_all(m_place); }
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    void measure(Readings& out) {
        const ChildOutcome whole =
            program("terravox-convert", with_options({m_data.string(), file("whole.tvx"), "--cache",
                                                      file("cache"), "--quiet"}));
        fs::remove_all(m_place / "cache");
        const ChildOutcome planning =
            program("terravox-raytracer",
                    with_options({"country", "plan", m_data.string(), "-o", file("plan"),
                                  "--shards", std::to_string(m_shards), "--json", "--quiet"}));
        const json plan = said();
        const ChildOutcome run =
            program("terravox-raytracer",
                    {"country", "run", file("plan"), "-o", file("country.tvx"), "--quiet"});
        (void)program("cmp", {file("whole.tvx"), file("country.tvx")});
        report_run(out, plan, planning, whole, run);
        report_archive(out);
        report_patch(out, whole);
    }

private:
    [[nodiscard]] std::string file(const char* name) const { return (m_place / name).string(); }
    [[nodiscard]] static std::vector<std::string> with_options(std::vector<std::string> words) {
        words.insert(words.end(), {"--crs", square().crs, "--classes", square().classes});
        return words;
    }
    [[nodiscard]] json said() const {
        std::ifstream in(m_place / "said");
        return json::parse(in);
    }

    ChildOutcome program(const std::string& name, std::vector<std::string> words) {
        const bool is_ours = name.starts_with("terravox-");
        words.insert(words.begin(), is_ours ? (m_c.programs / name).string() : name);
        return run_program(m_c, words, m_place / "said");
    }

    static double cpu_s(const ChildOutcome& run) { return run.user_s + run.system_s; }

    void report_run(Readings& out, const json& plan, const ChildOutcome& planning,
                    const ChildOutcome& whole, const ChildOutcome& run) const {
        constexpr double kKibOfMib = 1024;
        const auto& estimate = plan.at("one_machine_cpu_s");
        const double foreseen_s = estimate.at("value").get<double>();
        constexpr double kPlanError = 0.25;
        constexpr double kLimit_mib = 700;
        constexpr double kSlower = 1.05;
        out.add("points", "Mpoint", plan.at("points").get<double>() / 1e6);
        out.add("plan CPU", "s", cpu_s(planning));
        out.add("estimate", "s", foreseen_s);
        out.add("stated error", "s", estimate.at("error").get<double>());
        out.add("CPU", "s", cpu_s(run));
        out.add("error of the estimate", "x", std::abs(foreseen_s / cpu_s(run) - 1),
                at_most(kPlanError));
        out.add("estimate of the output", "x",
                plan.at("output_bytes").at("value").get<double>() /
                    static_cast<double>(fs::file_size(m_place / "country.tvx")));
        out.add("CPU / single run", "x", cpu_s(run) / cpu_s(whole), at_most(kSlower));
        out.add("wall / single run", "x", run.wall_s / whole.wall_s, at_most(kSlower));
        out.add("peak memory of a process", "MiB", static_cast<double>(run.peak_kib) / kKibOfMib,
                at_most(kLimit_mib));
    }

    /// Both sides read from the page cache; what is written goes to the disk in both.
    void report_archive(Readings& out) {
        std::vector<std::string> merge{"merge", "-o", file("merged.tvx"), "--quiet"};
        for (const auto& entry : fs::directory_iterator(m_place / "plan" / "shards"))
            merge.push_back(entry.path().string());
        const ChildOutcome merged = program("terravox-archive", merge);
        const ChildOutcome copied =
            program("sh", {"-c", "cat \"$1\"/plan/shards/* > \"$1\"/copy && sync \"$1\"/copy", "sh",
                           m_place.string()});
        const ChildOutcome verified = program("terravox-archive", {"verify", file("merged.tvx")});
        const ChildOutcome read =
            program("sh", {"-c", "cat \"$1\" > /dev/null", "sh", file("merged.tvx")});
        const ChildOutcome compared =
            program("terravox-archive", {"verify", "--checksums", file("merged.tvx")});
        constexpr double kShare = 0.5;
        out.add("merge: speed of a copy", "x", copied.wall_s / merged.wall_s, at_least(kShare));
        out.add("verify: speed of reading", "x", read.wall_s / verified.wall_s, at_least(kShare));
        out.add("verify --checksums: speed of reading", "x", read.wall_s / compared.wall_s,
                at_least(kShare));
        out.add("archive", "MB", static_cast<double>(fs::file_size(m_place / "merged.tvx")) / 1e6);
    }

    /// One square in the middle becomes another file of the same points: so are the bytes.
    void report_patch(Readings& out, const ChildOutcome& whole) {
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(m_data))
            files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        fs::last_write_time(files[files.size() / 2], fs::file_time_type::clock::now());
        const ChildOutcome patch =
            program("terravox-raytracer", {"country", "patch", file("plan"), "--quiet"});
        (void)program("cmp", {file("whole.tvx"), file("country.tvx")});
        constexpr double kShare = 0.03;
        out.add("a square patched", "s", cpu_s(patch));
        out.add("a square patched / single run, CPU", "x", cpu_s(patch) / cpu_s(whole),
                at_most(kShare));
    }

    const Context& m_c;
    const fs::path m_data;
    const int m_shards;
    const fs::path m_place;
};

Entry entry_for(int n, int shards) {
    const std::string size = std::to_string(n) + "x" + std::to_string(n);
    Entry out;
    out.name = "country/" + size;
    out.measures =
        "a plan's estimate against the CPU time, memory of tasks, merge and verify "
        "against copying and reading, a sharded against a single run, one square patched against "
        "all";
    out.work = size + " copies of " + square().facts + " in " + std::to_string(shards) + " shards";
    out.missing = [](const Context& c) {
        const std::string reason =
            missing_programs(c, {"terravox-archive", "terravox-convert", "terravox-raytracer"});
        return reason.empty() ? square().missing(c) : reason;
    };
    out.exact = out.only_by_name = true;
    out.prepare = [n, shards](const Context& c) -> Body {
        const fs::path folder = make_squares(c, n);
        return
            [folder, shards, &c](Readings& readings) { Run(c, folder, shards).measure(readings); };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry_for(3, 9), entry_for(10, 16)}; });

}  // namespace
}  // namespace terravox::bench::country_entry
