#include "tests/bench/report.hpp"

#include <nlohmann/json.hpp>

#include "tests/catch.hpp"

using namespace terravox::bench;
using terravox::test::contains;

namespace {

Report example() {
    Report out;
    out.machine.cpu = "Some CPU";
    out.machine.cores = 2;
    out.machine.version = "1.2.3";
    out.machine.date = "2026-06-21T16:00:00Z";
    out.warnings = {"noisy: load average 3.00"};
    out.repeats = {1, 3};
    out.threads = 2;
    Result measured{"render/somewhere", "a picture", "one file", "LASzip",
                    Status::kMeasured,  {},          {},         0.5};
    measured.metrics = {{"whole", "s", {2, 1, 4}}, {"rate", "Mray/s", {12.5, 12.5, 12.5}}};
    out.results = {
        measured,
        {"boxes/square", "boxes", "one square", "", Status::kSkipped, "no square.laz", {}, -1},
        {"walk/x", "rays", "a scene", "", Status::kFailed, "it broke", {}, -1}};
    return out;
}

}  // namespace

TEST_CASE("the JSON report holds every run and every entry", "[bench][report]") {
    const auto json = nlohmann::json::parse(to_json(example()));
    CHECK(json.at("format") == "terravox-bench");
    CHECK(json.at("version") == kReportVersion);
    CHECK(json.at("machine").at("cpu") == "Some CPU");
    CHECK(json.at("settings").at("repeats") == 3);
    CHECK(json.at("warnings").size() == 1);
    REQUIRE(json.at("entries").size() == 3);
    const auto& whole = json.at("entries")[0].at("metrics")[0];
    CHECK(whole.at("name") == "whole");
    CHECK(whole.at("unit") == "s");
    CHECK(whole.at("median") == 2.0);
    CHECK(whole.at("mad") == 1.0);
    CHECK(whole.at("values") == nlohmann::json({2.0, 1.0, 4.0}));
    CHECK(json.at("entries")[0].at("floor") == "LASzip");
    CHECK(json.at("entries")[0].at("others_cores") == 0.5);
    CHECK(json.at("entries")[1].at("status") == "skipped");
    CHECK(json.at("entries")[1].at("reason") == "no square.laz");
    CHECK(json.at("entries")[2].at("status") == "failed");
}

TEST_CASE("the JSON report stands whatever bytes are in a name", "[bench][report]") {
    Report report = example();
    report.results[1].reason = "no \xff.laz";
    CHECK_NOTHROW(static_cast<void>(nlohmann::json::parse(to_json(report))));
}

TEST_CASE("the table has a row for each metric, and says what was skipped and why",
          "[bench][report]") {
    const std::string text = to_markdown(example());
    CHECK_THAT(
        text,
        contains("| entry            | metric | unit   | median |   MAD |   min |   max |\n"
                 "|------------------|--------|--------|-------:|------:|------:|------:|\n"
                 "| render/somewhere | whole  | s      |  2.000 | 1.000 | 1.000 | 4.000 |\n"
                 "|                  | rate   | Mray/s |  12.50 |     0 | 12.50 | 12.50 |\n"));
    CHECK_THAT(text, contains("- boxes/square: skipped: no square.laz\n"));
    CHECK_THAT(text, contains("- walk/x: failed: it broke\n"));
    CHECK_THAT(text, contains("**noisy: load average 3.00**"));
    CHECK_THAT(
        text, contains("**noisy: other programs kept 0.5000 cores busy during render/somewhere**"));
}

TEST_CASE("numbers keep their digits without an exponent", "[bench][report]") {
    struct Case {
        double value;
        const char* text;
    };
    const auto c = GENERATE(values<Case>({{0, "0"},
                                          {0.01234, "0.0123"},
                                          {1.2345, "1.234"},
                                          {-12.345, "-12.35"},
                                          {123.45, "123.5"},
                                          {7431607, "7431607"},
                                          {0.00001234, "1.234e-05"}}));
    CHECK(format_number(c.value) == c.text);
}

TEST_CASE("other programs and slow builds are warned of", "[bench][machine]") {
    Machine machine;
    machine.build_type = "Release";
    machine.load = 0.3;
    CHECK(list_warnings(machine).empty());
    machine.load = 2;
    REQUIRE(list_warnings(machine).size() == 1);
    CHECK_THAT(list_warnings(machine)[0], contains("noisy: load average 2.00"));
    machine.build_type = "Debug";
    CHECK(list_warnings(machine).size() == 2);
}

TEST_CASE("targets stand beside the values, met or missed, and notes below the table",
          "[bench][report]") {
    Report report = example();
    report.results[0].metrics[0].target = at_most(1.5);
    report.results[0].metrics[1].target = at_least(12.5);
    report.results[0].notes = {"a table of its own"};
    const std::string text = to_markdown(report);
    CHECK_THAT(text, contains("|          target |\n"));
    CHECK_THAT(text, contains("| <= 1.500 missed |\n"));
    CHECK_THAT(text, contains("|    >= 12.50 met |\n"));
    CHECK_THAT(text, contains("\nrender/somewhere: a table of its own\n"));
    const auto json = nlohmann::json::parse(to_json(report));
    const auto& metrics = json.at("entries")[0].at("metrics");
    CHECK(metrics[0].at("target").at("at_most") == 1.5);
    CHECK(metrics[0].at("target").at("met") == false);
    CHECK(metrics[1].at("target").at("met") == true);
    CHECK(json.at("entries")[0].at("notes").size() == 1);
}
