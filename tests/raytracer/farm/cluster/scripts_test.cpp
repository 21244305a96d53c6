#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/util/error.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"
#include "raytracer/farm/cluster/engines.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::cluster;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

const std::string kHostile = "it's \"a\" $(touch never) `x` \\ *\nü";

/// A folder with a program that writes its arguments down, each with a zero byte behind.
struct Stage {
    Stage() {
        fs::create_directories(work());
        std::ofstream(program()) << "#!/bin/bash\nprintf '%s\\0' \"$@\" > "
                                 << "\"$(dirname \"$0\")/said\"\n";
        fs::permissions(program(), fs::perms::owner_all);
        place.work = work();
    }
    [[nodiscard]] fs::path work() const { return folder.path() / "a work 'folder'"; }
    [[nodiscard]] fs::path program() const { return folder.path() / "the program"; }

    /// Runs a script as Slurm would.
    /// @return the arguments that the program was called with
    std::vector<std::string> called(const std::string& script,
                                    const std::vector<std::string>& environment,
                                    const std::vector<std::string>& arguments = {}) {
        const fs::path file = folder.path() / "script";
        std::ofstream(file) << script;
        REQUIRE(util::run_to_end({"bash", "-n", file.string()}).status == 0);
        Command command{"env"};
        command.insert(command.end(), environment.begin(), environment.end());
        command.insert(command.end(), {"bash", file.string()});
        command.insert(command.end(), arguments.begin(), arguments.end());
        done = util::run_to_end(command);
        std::ifstream in(folder.path() / "said");
        std::vector<std::string> out;
        for (std::string word; std::getline(in, word, '\0');)
            out.push_back(word);
        return out;
    }

    [[nodiscard]] std::string slurm(const Body& body, SlurmJob job = SlurmJob::kArray) const {
        return slurm_script(place, "tried", job, body);
    }
    [[nodiscard]] Body worker(const std::string& token, const std::string& address,
                              const std::string& file = {}) const {
        return worker_body(program().string(), place.needs, token, address, file);
    }

    [[nodiscard]] static Body coordinator(const Command& command, const Value& host,
                                          const std::string& file) {
        return {"coordinator", {{"command", command}, {"host", host}, {"address_file", file}}};
    }

    TemporaryFolder folder;
    Place place;
    util::Finished done;
};

/// The lines of a script that Slurm reads, which end at the first command.
std::vector<std::string> asked(const std::string& script) {
    std::vector<std::string> out;
    std::istringstream in(script);
    for (std::string line; std::getline(in, line) && (line.starts_with("#") || line.empty());)
        if (line.starts_with("#SBATCH "))
            out.push_back(line.substr(8));
    return out;
}

bool has(const std::vector<std::string>& lines, const std::string& line) {
    return std::find(lines.begin(), lines.end(), line) != lines.end();
}

}  // namespace

TEST_CASE("tasks render their own run of frames with the arguments as given",
          "[cluster][scripts]") {
    Stage stage;
    const std::string script = stage.slurm(
        frames_body({stage.program().string(), "animate", kHostile, "-o", "%d.png"}, {{3, 12}, 4}));
    const std::vector<std::string> as_given{"animate", kHostile, "-o", "%d.png"};
    struct Case {
        const char* name;
        std::string task;
        std::vector<std::string> arguments;
        std::string first;
        std::string last;
    };
    const auto c = GENERATE(values<Case>({{"first", "0", {"0"}, "3", "6"},
                                          {"last, shorter", "2", {"0"}, "11", "12"},
                                          {"of a second array", "0", {"1"}, "7", "10"},
                                          {"by hand", "1", {}, "7", "10"}}));
    DYNAMIC_SECTION(c.name) {
        auto expected = as_given;
        expected.insert(expected.end(), {"--first", c.first, "--last", c.last});
        CHECK(stage.called(script, {"SLURM_ARRAY_TASK_ID=" + c.task}, c.arguments) == expected);
    }
    CHECK_FALSE(fs::exists(stage.work() / "never"));
}

TEST_CASE("a task's resources are requested in the lines that Slurm reads", "[cluster][scripts]") {
    Stage stage;
    const auto whole = asked(stage.slurm(stage.worker("/t/token", "host:1")));
    CHECK(has(whole, "--exclusive"));
    CHECK(has(whole, "--mem=0"));
    CHECK(has(whole, "--requeue"));
    stage.place.needs = {
        8, 4000, "long", "4:00:00", {"--account=film --qos=low", "--constraint=avx2"}};
    const auto part = asked(stage.slurm(stage.worker("/t/token", "host:1")));
    for (const char* line :
         {"--cpus-per-task=8", "--mem=4000M", "--partition=long", "--time=4:00:00",
          "--account=film --qos=low", "--constraint=avx2", "--output=logs/tried-%A_%a.txt"})
        CHECK(has(part, line));
    CHECK_FALSE(has(part, "--exclusive"));
    const auto once = asked(stage.slurm(
        stage.coordinator({"x"}, Value::plain("\"$HOSTNAME\""), "/a"), SlurmJob::kOnce));
    CHECK(has(once, "--no-requeue"));
    CHECK(has(once, "--output=logs/tried-%j.txt"));
}

TEST_CASE("what would leave its line in a script is refused", "[cluster][scripts]") {
    const auto refused = [](Needs needs) { CHECK_THROWS_AS(needs.check(), util::UsageError); };
    refused({1, 1, "a b", "", {}});
    refused({1, 1, "a\nrm", "", {}});
    refused({1, 1, "", "4:00 --x", {}});
    refused({1, 1, "", "", {"account"}});
    refused({1, 1, "", "", {"--qos=a\n#SBATCH --x"}});
    CHECK_NOTHROW(Needs{1, 1, "a-b_c.d", "1-04:00:00", {"--qos=a -A b"}}.check());
}

TEST_CASE("workers join with what the node has", "[cluster][scripts]") {
    Stage stage;
    stage.place.needs.cpus = 4;
    stage.place.needs.memory_mib = 2000;
    const std::string token = (stage.folder.path() / kHostile).string();
    CHECK(stage.called(stage.slurm(stage.worker(token, "host:7879")), {"SLURM_ARRAY_TASK_ID=0"}) ==
          std::vector<std::string>{"worker", "--once", "--idle-s", "600", "--token-file", token,
                                   "--threads", "4", "--memory-mib", "1500", "--join",
                                   "host:7879"});
    SECTION("where the coordinator is a job, at the address in its file") {
        const fs::path file = stage.folder.path() / kHostile;
        std::ofstream(file) << "node7:20001\n";
        const auto words = stage.called(stage.slurm(stage.worker(token, "", file.string())), {});
        REQUIRE(words.size() == 12);
        CHECK(words[11] == "node7:20001");
    }
}

TEST_CASE("a coordinator that is a job publishes its address", "[cluster][scripts]") {
    Stage stage;
    const fs::path file = stage.folder.path() / kHostile;
    const auto words =
        stage.called(stage.slurm(stage.coordinator({stage.program().string(), "render", kHostile},
                                                   "the-host", file.string())),
                     {"SLURM_JOB_ID=123456"});
    REQUIRE(words.size() == 4);
    CHECK(words[1] == kHostile);
    CHECK(words[2] == "--listen");
    std::ifstream in(file);
    std::string address;
    REQUIRE(std::getline(in, address));
    CHECK(address == "the-host" + words[3]);
    CHECK(std::stoi(words[3].substr(1)) >= 23456);
    CHECK_FALSE(fs::exists(file.string() + ".part"));
}

TEST_CASE("frames are joined when all are there", "[cluster][scripts]") {
    Stage stage;
    const std::string pattern = "it's 100 $frames/%03d of.png";
    const std::string script = stage.slurm(merge_frames_body(
        pattern, {8, 11}, {stage.program().string(), "animate", "--video", kHostile}));
    const fs::path frames = stage.work() / "it's 100 $frames";
    fs::create_directories(frames);
    for (const char* name : {"008 of.png", "009 of.png", "010 of.png"})
        std::ofstream(frames / name) << "x";
    std::ofstream(frames / "011 of.png");  // empty: not there
    CHECK(stage.called(script, {}).empty());
    CHECK(stage.done.status == 1);
    CHECK(stage.done.err ==
          "missing: it's 100 $frames/011 of.png\nterravox: join the frames: 1 are missing\n");
    std::ofstream(frames / "011 of.png") << "x";
    CHECK(stage.called(script, {}) == std::vector<std::string>{"animate", "--video", kHostile});
    CHECK(stage.done.status == 0);
    CHECK_THROWS_AS(merge_frames_body("a.png", {0, 1}, {}), util::UsageError);
}

TEST_CASE("parts resume with their tiles, and are joined", "[cluster][scripts]") {
    Stage stage;
    const std::string picture = (stage.folder.path() / kHostile / "a picture.exr").string();
    const std::string script =
        stage.slurm({"parts",
                     {{"command", Command{stage.program().string(), "render", "w", "-o", picture}},
                      {"parts", 5}},
                     true});
    CHECK(stage.called(script, {"SLURM_ARRAY_TASK_ID=2"}, {"0"}) ==
          std::vector<std::string>{"render", "w", "-o", picture, "--resume", "--part", "3/5"});
    CHECK(stage.called(script, {"SLURM_ARRAY_TASK_ID=1"}, {"3"}).back() == "5/5");
    const auto joined =
        stage.called(stage.slurm({"merge",
                                  {{"outputs", Command{"-o", kHostile, "-o", "b.png"}},
                                   {"parts", 2},
                                   {"tiles", picture + ".part-"},
                                   {"program", stage.program().string()}}}),
                     {});
    CHECK(joined == std::vector<std::string>{
                        "merge", farm::checkpoint_path(picture, farm::Part{1, 2}).string(),
                        farm::checkpoint_path(picture, farm::Part{2, 2}).string(), "-o", kHostile,
                        "-o", "b.png"});
}

TEST_CASE("squares are prepared by the arguments of the frames", "[cluster][scripts]") {
    Stage stage;
    CHECK(stage.called(stage.slurm({"bake",
                                    {{"words", Command{kHostile, "-o", "x"}},
                                     {"program", stage.program().string()},
                                     {"kind", "animate"},
                                     {"tasks", 7}}}),
                       {"SLURM_ARRAY_TASK_ID=6"}) ==
          std::vector<std::string>{"cluster", "bake", "--for", "animate", "--part", "7/7", kHostile,
                                   "-o", "x"});
}

TEST_CASE("a job template holds scripts that bash runs", "[cluster][openjd]") {
    Stage stage;
    FrameJob job{"a film", {stage.program().string(), "animate", kHostile},
                 "%d.png", {{0, 9}, 4},
                 "v.mp4",  2,
                 1000};
    const auto openjd = [&] {
        return kEngines[kOpenJd].make_array(array_of_frames(job), stage.place).start;
    };
    const auto json = nlohmann::json::parse(openjd());
    CHECK(json["specificationVersion"] == "jobtemplate-2023-09");
    CHECK(json["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"] == "0-2");
    CHECK(json["steps"][1]["dependencies"][0]["dependsOn"] == "Frames");
    CHECK(json["steps"][0]["hostRequirements"]["amounts"].size() == 2);
    const std::string script = json["steps"][0]["script"]["embeddedFiles"][0]["data"];
    CHECK(stage.called(script, {}, {"2"}) ==
          std::vector<std::string>{"animate", kHostile, "--first", "8", "--last", "9"});
    job.cpus = job.memory_mib = 0;
    CHECK_FALSE(nlohmann::json::parse(openjd())["steps"][0].contains("hostRequirements"));
    for (const char* braces : {"{{Task.Param.Task}}", "{{command}}"}) {
        job.animate.push_back(braces);
        CHECK_THROWS_AS(openjd(), util::UsageError);
        job.animate.pop_back();
    }
    job.name = "\xff";
    CHECK_THROWS_AS(openjd(), util::UsageError);
}

TEST_CASE("pods get arguments that Kubernetes does not change", "[cluster][kubernetes]") {
    // As Kubernetes does: $$ is a dollar, $(NAME) would be a variable's value.
    const auto expanded = [](const std::string& text) {
        std::string out;
        for (std::size_t i = 0; i < text.size(); ++i) {
            if (text[i] == '$' && i + 1 < text.size() && text[i + 1] == '$')
                ++i;
            else if (text[i] == '$')
                out += "<expanded>";
            out += text[i];
        }
        return out;
    };
    Stage stage;
    stage.place.pods = {"image:1", "worlds"};
    stage.place.nodes = 3;
    FrameJob job{
        "film",   {stage.program().string(), "animate", kHostile, "$(HOME) $$", "{{command}}"},
        "%d.png", {{0, 9}, 4},
        "",       2,
        1000};
    const auto frames = nlohmann::json::parse(
        kEngines[kKubernetes].make_array(array_of_frames(job), stage.place).start);
    const auto& spec = frames["items"][0]["spec"];
    CHECK(spec["completions"] == 3);
    CHECK(spec["completionMode"] == "Indexed");
    const auto& command = spec["template"]["spec"]["containers"][0]["command"];
    CHECK(stage.called(expanded(command[2]), {"JOB_COMPLETION_INDEX=1"}) ==
          std::vector<std::string>{"animate", kHostile, "$(HOME) $$", "{{command}}", "--first", "4",
                                   "--last", "7"});

    const std::string join =
        frames["items"][1]["spec"]["template"]["spec"]["containers"][0]["command"][2];
    CHECK_THAT(join, contains("until look 2>/dev/null; do sleep 30; done\n"));
    stage.place.needs.cpus = 2;
    stage.place.needs.memory_mib = 1000;
    const auto pool =
        nlohmann::json::parse(kubernetes_pool("film", {"p", "render", "$(HOME)"}, stage.place));
    CHECK(pool["items"][1]["spec"]["template"]["spec"]["containers"][0]["command"][2] ==
          "$$(HOME)");
    CHECK(pool["items"][2]["spec"]["parallelism"] == 3);
    for (const std::size_t item : {1U, 2U})
        CHECK(pool["items"][item]["spec"]["template"]["spec"]["containers"][0]["env"]
                  .back()["name"] == "TERRAVOX_FARM_TOKEN");
    CHECK(pool.dump().find("secretKeyRef") != std::string::npos);
    for (const char* name : {"", "Film", "-a", "a_b", "a.b"})
        CHECK_THROWS_AS(stage.place.pods.check(name), util::UsageError);
    CHECK_THROWS_AS((PodPlace{"", "worlds"}.check("a")), util::UsageError);
    CHECK_THROWS_AS((PodPlace{"i", "w", "data"}.check("a")), util::UsageError);
}

namespace {

/// An array whose tasks call the stage's program.
ArrayJob read_array(const Stage& stage, int tasks) {
    ArrayJob job;
    job.name = "land";
    job.tasks_name = "shards";
    job.join_name = "join";
    job.tasks = tasks;
    job.task = {
        "shards", {{"command", Command{stage.program().string(), "run"}}, {"tasks", 3}}, true};
    job.join = {"join", {{"command", Command{stage.program().string(), "join"}}}, false, "--wait"};
    return job;
}

}  // namespace

TEST_CASE("tasks of an array know their number, and the join follows", "[cluster][scripts]") {
    Stage stage;
    const ArrayFiles made = kEngines[kSlurm].make_array(read_array(stage, 3), stage.place);
    REQUIRE(made.scripts.size() == 2);
    CHECK(made.scripts[0].first == "shards.sbatch");
    CHECK(stage.called(made.scripts[0].second, {"SLURM_ARRAY_TASK_ID=2"}, {"1001"}) ==
          std::vector<std::string>{"run", "--task", "1004"});
    CHECK(made.scripts[1].first == "join.sbatch");
    CHECK(stage.called(made.scripts[1].second, {}) == std::vector<std::string>{"join"});
    CHECK(has(asked(made.scripts[0].second), "--job-name=terravox-shards"));
}

TEST_CASE("arrays are submitted one after the other, and the join after all of them",
          "[cluster][scripts]") {
    Stage stage;
    const fs::path sbatch = stage.folder.path() / "sbatch";
    std::ofstream(sbatch) << "#!/bin/bash\nhere=$(dirname \"$0\")\n"
                             "printf '%s\\n' \"$*\" >> \"$here/submitted\"\n"
                             "wc -l < \"$here/submitted\"\n";
    fs::permissions(sbatch, fs::perms::owner_all);
    stage.place.nodes = 7;
    stage.place.folder = stage.work();
    const std::string script =
        kEngines[kSlurm].make_array(read_array(stage, 1500), stage.place).start;
    (void)stage.called(script, {"PATH=" + stage.folder.path().string() + ":/usr/bin:/bin"});
    REQUIRE(stage.done.status == 0);
    CHECK(stage.done.out == "submitted: tasks 1:2, join 3\n");
    std::ifstream in(stage.folder.path() / "submitted");
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);)
        lines.push_back(line);
    CHECK(lines == std::vector<std::string>{
                       "--parsable --array=0-1000%7 shards.sbatch 0",
                       "--parsable --array=0-498%7 --dependency=afterany:1 shards.sbatch 1001",
                       "--parsable --dependency=afterany:1:2 join.sbatch"});
}
