#include "tests/bench/serve_script.hpp"

namespace terravox::bench::farm_entry {
namespace {

Entry scale() {
    Entry out;
    out.name = "farm/scale";
    out.measures =
        "one picture by green, threads and socket workers: time of the tracing, efficiency against "
        "threads and against one worker";
    out.work =
        "640x360 paths of 64 samples of a synthetic square of 512 m; workers on loopback, then 1 "
        "to 12 that have 14 % of a core each (control groups; as root)";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "farm/scale", {"--runs", "10"});
            const auto add = [&](const char* metric, const char* unit, const char* name,
                                 Target target = {}) {
                readings.add(metric, unit, figures.at(name).get<double>(), target);
            };
            add("green", "s", "green_s");
            add("1 thread", "s", "threads_1_s");
            add("2 threads", "s", "threads_2_s");
            add("2 workers, cold", "s", "workers_2_cold_s");
            add("2 workers, warm", "s", "workers_2_s");
            add("efficiency of 2 workers against 2 threads", "", "loopback_efficiency",
                at_least(0.95));
            for (const std::string count : {"1", "2", "4", "6", "12"}) {
                readings.add(count + " workers of a share", "s",
                             figures.at("shared_" + count + "_s").get<double>());
                readings.add("efficiency of " + count, "",
                             figures.at("shared_" + count + "_efficiency").get<double>(),
                             at_least(0.9));
            }
            add("different pictures", "", "pictures", at_most(1));
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

Entry kill() {
    Entry out;
    out.name = "farm/kill";
    out.measures =
        "kill -9 of 1 or 2 of 3 workers at random times: pictures that are not the same, and time "
        "beyond that of the workers that are left";
    out.work =
        "50 pictures of 320x180, seeded; workers that have a quarter of a core each (control "
        "groups; as root)";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "farm/kill", {});
            const auto value = [&](const char* name) { return figures.at(name).get<double>(); };
            readings.add("pictures", "", value("runs"), at_least(50));
            readings.add("wrong", "", value("wrong"), at_most(0));
            readings.add("kills", "", value("kills"));
            readings.add("three workers without kills", "s",
                         value("ready_s") + value("working_s") + value("end_s"));
            readings.add("beyond the ideal, median", "s", value("over_median_s"));
            readings.add("beyond the ideal, most", "s", value("over_most_s"),
                         at_most(1 + value("tile_s")));
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

/// A figure of a row of tests/bench/farm/faults.py, and its target.
struct Figure {
    const char *row, *name, *metric, *unit;
    Target target = {};
};

std::vector<Figure> figures_of_faults() {
    return {
        {"kill", "wrong", "wrong pictures", "", at_most(0)},
        {"kill", "over_median_s", "beyond the ideal, median", "s"},
        {"kill", "over_most_s", "beyond the ideal, most", "s"},
        {"kill", "over_allowance", "runs of more than the ideal, a tile and 1 s", "", at_most(0)},
        {"lease", "bands", "bands lost", "", at_least(100)},
        {"lease", "wrong", "wrong pictures", "", at_most(0)},
        {"lease", "told_most_s", "until the loss is known, most", "s"},
        {"lease", "median_s", "until a band is leased again, median", "s"},
        {"lease", "p99_s", "until a band is leased again, p99", "s", at_most(0.25)},
        {"lease", "heavy_p99_s", "the same where a tile takes long, p99", "s"},
        {"stop", "tests_most_s", "until all is leased again, times of tests", "s", at_most(5)},
        {"stop", "defaults_most_s", "until all is leased again", "s", at_most(15)},
        {"stop", "defaults_back_s", "until it works again after SIGCONT", "s", at_least(0)},
        {"stop", "defaults_wrong", "wrong pictures", "", at_most(0)},
        {"partition", "tests_most_s", "until all is leased again, times of tests", "s", at_most(5)},
        {"partition", "defaults_most_s", "until all is leased again", "s", at_most(15)},
        {"partition", "defaults_back_s", "until it works again with the network", "s", at_least(0)},
        {"partition", "defaults_wrong", "wrong pictures", "", at_most(0)},
        {"hung", "most_s", "until all is leased again, times of tests", "s", at_most(5)},
        {"hung", "more", "bands given to it meanwhile", ""},
        {"hung", "cold_most_s", "until all is leased again, right after a start", "s"},
        {"hung", "given_up", "links given up", "", at_most(0)},
        {"hung", "wrong", "wrong pictures", "", at_most(0)},
        {"late", "answers", "late answers counted", "", at_least(100)},
        {"late", "harmed", "workers lost or expelled for them", "", at_most(0)},
        {"late", "wrong", "wrong pictures", "", at_most(0)},
        {"slow", "of_3_ratio", "one of three 10 times slower, against the two others", "",
         at_most(1.3)},
        {"slow", "of_2_ratio", "one of two 10 times slower, against the other", "", at_most(1.3)},
        {"slow", "wrong", "wrong pictures", "", at_most(0)},
        {"term", "exit_most_s", "exit, most", "s", at_most(10)},
        {"term", "exit_codes", "exit codes other than 0", "", at_most(0)},
        {"term", "finished", "bands finished after SIGTERM", ""},
        {"term", "given_back", "bands given back", ""},
        {"term", "unaccounted", "bands neither finished nor given back", "", at_most(0)},
        {"term", "wrong", "wrong pictures", "", at_most(0)},
        {"resume", "kills", "kills of the coordinator", "", at_least(20)},
        {"resume", "again", "finished tiles rendered again", "", at_most(0)},
        {"resume", "lost", "finished tiles lost", "", at_most(0)},
        {"resume", "wrong", "wrong pictures", "", at_most(0)},
        {"loss", "second_answers_ratio", "payload from the worker against its tiles' bytes", "",
         at_most(1.1)},
        {"loss", "second_traffic_ratio", "payload both ways against them, boxes included", "",
         at_most(1.1)},
        {"loss", "second_link_ratio",
         "the link's bytes from the worker, headers and repeats included, against them", ""},
        {"loss", "second_again_share", "sent again", ""},
        {"loss", "wrong", "wrong pictures", "", at_most(0)},
        {"latency", "latency_s", "picture at 200 +- 50 ms each way", "s"},
        {"latency", "latency_without_s", "without", "s"},
        {"latency", "latency_wrong", "wrong pictures", "", at_most(0)},
        {"latency", "resets", "connections reset", "", at_least(1)},
        {"latency", "resets_s", "picture at that, with resets", "s"},
        {"latency", "resets_wrong", "wrong pictures", "", at_most(0)},
        {"storm", "worker_joined_s", "coordinator meets a worker after a flood", "s", at_most(2)},
        {"storm", "coordinator_joined_s", "worker joins a coordinator after a flood", "s",
         at_most(2)},
        {"storm", "worker_meanwhile_joined_s",
         "coordinator meets a worker while strangers come again and again", "s"},
        {"storm", "coordinator_meanwhile_joined_s", "worker joins a coordinator while they do",
         "s"},
        {"storm", "wrong", "wrong pictures", "", at_most(0)},
        {"unwelcome", "cases", "cases", "", at_least(13)},
        {"unwelcome", "most_s", "until both ends have said why, most", "s", at_most(1)},
        {"unwelcome", "let_in", "let in", "", at_most(0)},
        {"soak", "pictures", "pictures", ""},
        {"soak", "kills", "kills", ""},
        {"soak", "wrong", "wrong pictures", "", at_most(0)},
        {"soak", "growth", "memory of a survivor, last third against the first", "", at_most(1.05)},
        {"soak", "small_growth", "the same where boxes may take 64 MiB", "", at_most(1.05)},
        {"soak", "more_descriptors", "descriptors of survivors, more", "", at_most(0)},
        {"tasks", "tiles", "tiles through one daemon", "", at_least(10'000)},
        {"tasks", "growth_mib", "its memory after all, more than after a fifth", "MiB",
         at_most(10)},
        {"tasks", "wrong", "wrong pictures", "", at_most(0)},
    };
}

Entry faults() {
    Entry out;
    out.name = "farm/faults";
    out.measures =
        "a farm whose workers, coordinators and networks are killed, stopped, cut off, slow, "
        "flooded and lied to: pictures that are not the same, and what it costs";
    out.work =
        "one row for each kind of fault, seeded (tests/bench/farm/faults.py); what wants root, "
        "control groups, namespaces or Go is left out without, and named below";
    out.missing = [](const Context& c) { return missing_for_serving(c); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            const auto figures = run_script(c, "farm/faults", {});
            const auto &skipped = figures.at("skipped"), &failed = figures.at("failed");
            for (const Figure& f : figures_of_faults())
                if (!skipped.contains(f.row) && !failed.contains(f.row))
                    readings.add(std::string(f.row) + ": " + f.metric, f.unit,
                                 figures.at(std::string(f.row) + "_" + f.name).get<double>(),
                                 f.target);
            readings.add("rows that failed", "", static_cast<double>(failed.size()), at_most(0));
            for (const auto& [row, why] : failed.items())
                readings.note("`" + row + "` failed: " + why.get<std::string>());
            for (const auto& [row, why] : skipped.items())
                readings.note("`" + row + "` was left out: " + why.get<std::string>());
        };
    };
    out.exact = out.only_by_name = true;
    return out;
}

const Registration kRegistered([] { return std::vector{scale(), kill(), faults()}; });

}  // namespace
}  // namespace terravox::bench::farm_entry
