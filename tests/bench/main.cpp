#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>

#include "common/thread/parallel.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/program.hpp"
#include "common/util/version.hpp"
#include "tests/bench/report.hpp"
#include "tests/common/temporary_folder.hpp"

namespace {

using namespace terravox;
using namespace terravox::bench;

std::atomic<bool> g_stop{false};

/// The first signal ends the bench after the run in progress, the second at once.
void stop_after_run(int signal) {
    g_stop = true;
    std::signal(signal, SIG_DFL);
}

struct Arguments {
    std::vector<std::string> prefixes;
    bool list = false;
    Repeats repeats;
    int threads = 0;
    std::string data = TERRAVOX_SHARED_DATA;
    std::string programs;
    std::string json;
    std::string markdown;
};

void add_arguments(CLI::App& app, Arguments& args) {
    app.add_option("entries", args.prefixes,
                   "what to measure: names of entries or their beginnings; default: all");
    app.add_flag("--list", args.list, "list the entries, and why some cannot run here");
    app.add_option("--repeats", args.repeats.runs, "measured runs of each entry")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--warmup", args.repeats.warmup, "runs before them that are not counted")
        ->check(CLI::Range(0, 100))
        ->capture_default_str();
    app.add_option("--threads", args.threads,
                   "threads where an entry uses several; 0 = one for each core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    app.add_option("--data", args.data,
                   "folder of the shared test data; default: ../shared/data beside the checkout");
    app.add_option("--programs", args.programs,
                   "folder of the programs to measure; default: this program's own");
    app.add_option("--json", args.json, "write everything to this file");
    app.add_option("--markdown", args.markdown,
                   "write the table to this file instead of standard output");
}

void list_entries(const std::vector<Entry>& entries, const Context& context) {
    for (const Entry& entry : entries) {
        std::printf("%s\n    %s\n    work: %s\n", entry.name.c_str(), entry.measures.c_str(),
                    entry.work.c_str());
        if (entry.only_by_name)
            std::printf("    long: runs only when its whole name is given\n");
        if (!entry.floor.empty())
            std::printf("    ratios to: %s\n", entry.floor.c_str());
        if (const std::string reason = entry.missing(context); !reason.empty())
            std::printf("    skipped here: %s\n", reason.c_str());
    }
}

Report measure_all(const std::vector<Entry>& entries, const Context& context,
                   const Arguments& args) {
    Report report;
    report.machine = read_machine(context.children, context.scratch);
    report.warnings = list_warnings(report.machine);
    report.repeats = args.repeats;
    report.threads = context.threads;
    for (const std::string& warning : report.warnings)
        std::fprintf(stderr, "bench: %s\n", warning.c_str());
    for (std::size_t i = 0; i < entries.size(); ++i) {
        std::fprintf(stderr, "bench: %zu of %zu: %s\n", i + 1, entries.size(),
                     entries[i].name.c_str());
        const Result& result =
            report.results.emplace_back(measure(entries[i], context, args.repeats, g_stop));
        if (result.status != Status::kMeasured)
            std::fprintf(stderr, "bench: %s: %s: %s\n", result.name.c_str(),
                         status_name(result.status), result.reason.c_str());
    }
    return report;
}

void write_report(const Report& report, const Arguments& args) {
    if (!args.json.empty())
        util::write_file_atomically(args.json, to_json(report));
    if (!args.markdown.empty())
        util::write_file_atomically(args.markdown, to_markdown(report));
    else
        std::fputs(to_markdown(report).c_str(), stdout);
}

util::ExitCode run(const Arguments& args, ChildRunner& children) {
    util::set_up_log("error");
    const test::TemporaryFolder scratch;
    const std::filesystem::path beside =
        std::filesystem::read_symlink("/proc/self/exe").parent_path();
    const Context context{std::filesystem::weakly_canonical(args.data),
                          args.programs.empty() ? beside : std::filesystem::absolute(args.programs),
                          scratch.path(), thread::thread_count(args.threads), children};
    const auto entries = select_entries(registered_entries(), args.prefixes, args.list);
    if (args.list) {
        list_entries(entries, context);
        return util::ExitCode::kDone;
    }
    for (const std::string& file : {args.json, args.markdown})
        if (!file.empty())
            util::check_writable(file);
    for (const int signal : {SIGINT, SIGTERM})
        std::signal(signal, stop_after_run);
    const Report report = measure_all(entries, context, args);
    write_report(report, args);
    const bool failed = std::any_of(report.results.begin(), report.results.end(),
                                    [](const Result& r) { return r.status == Status::kFailed; });
    return failed ? util::ExitCode::kFailed : util::ExitCode::kDone;
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_program([&] {
        ChildRunner children;  // before anything takes memory
        CLI::App app{
            "Measures Terravox: fixed work, medians of several runs, ratios to a floor of the same "
            "run (docs/benchmarks.md).",
            "terravox bench"};
        app.set_version_flag("--version", std::string("terravox ") + kVersion);
        Arguments args;
        add_arguments(app, args);
        if (const auto code = util::parse_arguments(app, argc, argv))
            return *code;
        return static_cast<int>(run(args, children));
    });
}
