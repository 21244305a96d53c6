#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
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
        place.folder = folder.path() / "job";
        fs::create_directories(place.folder);
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

    /// The array job of a task and a join.
    [[nodiscard]] JobFiles slurm(const std::string& task, const std::string& join = ":") const {
        return kEngines[kSlurm].make_array(
            {.name = {}, .tasks_name = "tried", .join_name = "join", .task = task, .join = join},
            place);
    }
    [[nodiscard]] JobFiles pool(const PoolJob& job) const {
        return kEngines[kSlurm].make_pool(job, place);
    }
    [[nodiscard]] FrameJob film(util::IntRange frames, int per_task,
                                const std::string& pattern = "%d.png",
                                const std::string& video = {}) const {
        return {"a film", {program().string(), "animate", kHostile, "-o", pattern},
                pattern,  frames,
                per_task, video};
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

/// @param array "0-3,7", as sbatch takes it
std::vector<int> list_numbers(const std::string& array) {
    std::vector<int> out;
    std::istringstream in(array);
    for (std::string piece; std::getline(in, piece, ',');) {
        const auto dash = piece.find('-');
        const int first = std::stoi(piece);
        const int last = dash == std::string::npos ? first : std::stoi(piece.substr(dash + 1));
        for (int i = first; i <= last; ++i)
            out.push_back(i);
    }
    return out;
}

std::string find_script(const JobFiles& made, const std::string& name) {
    for (const auto& [file, text] : made.scripts)
        if (file == name + ".sbatch")
            return text;
    return "none of this name";
}

bool has(const std::vector<std::string>& lines, const std::string& line) {
    return std::find(lines.begin(), lines.end(), line) != lines.end();
}

}  // namespace

TEST_CASE("tasks render their own run of frames with the arguments as given",
          "[cluster][scripts]") {
    Stage stage;
    const std::string script =
        find_script(kEngines[kSlurm].make_array(
                        array_of_frames(stage.film({3, 12}, 4), kEngines[kSlurm]), stage.place),
                    "frames");
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

TEST_CASE("each frame belongs to one task", "[cluster][scripts]") {
    Stage stage;
    const auto per_task = GENERATE(1, 3, 10, 11);
    const FrameJob film = stage.film({5, 14}, per_task);
    const ArrayJob job = array_of_frames(film, kEngines[kSlurm]);
    const std::string script = find_script(kEngines[kSlurm].make_array(job, stage.place), "frames");
    int next = 5;
    for (int task = 0; task < film.tasks(); ++task) {
        const auto words = stage.called(script, {"SLURM_ARRAY_TASK_ID=" + std::to_string(task)});
        REQUIRE(words.size() == 8);
        CHECK(words[5] == std::to_string(next));
        next = std::stoi(words[7]) + 1;
    }
    CHECK(next == 15);
}

TEST_CASE("a task's resources are requested in the lines that Slurm reads", "[cluster][scripts]") {
    Stage stage;
    const auto whole = asked(find_script(stage.slurm(":"), "tried"));
    CHECK(has(whole, "--exclusive"));
    CHECK(has(whole, "--mem=0"));
    CHECK(has(whole, "--requeue"));
    stage.place.needs = {
        8, 4000, "long", "4:00:00", {"--account=film --qos=low", "--constraint=avx2"}};
    const auto part = asked(find_script(stage.slurm(":"), "tried"));
    for (const char* line :
         {"--cpus-per-task=8", "--mem=4000M", "--partition=long", "--time=4:00:00",
          "--account=film --qos=low", "--constraint=avx2", "--output=logs/tried-%A_%a.txt"})
        CHECK(has(part, line));
    CHECK_FALSE(has(part, "--exclusive"));
    const auto once = asked(find_script(stage.pool({"", {"x"}}), "coordinator"));
    CHECK(has(once, "--no-requeue"));
    CHECK(has(once, "--output=logs/coordinator-%j.txt"));
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
    stage.place.folder = stage.folder.path() / kHostile;
    fs::create_directories(stage.place.folder);
    std::ofstream(stage.place.folder / "address") << "node7:20001\n";
    const JobFiles made = stage.pool({"", {stage.program().string(), "render"}});
    CHECK(stage.called(find_script(made, "worker"), {"SLURM_ARRAY_TASK_ID=0"}) ==
          std::vector<std::string>{"worker", "--once", "--idle-s", "600", "--token-file",
                                   (stage.place.folder / "token").string(), "--threads", "4",
                                   "--memory-mib", "1500", "--join", "node7:20001"});
}

TEST_CASE("a coordinator publishes its address", "[cluster][scripts]") {
    Stage stage;
    stage.place.folder = stage.folder.path() / kHostile;
    fs::create_directories(stage.place.folder);
    PoolJob job{"", {stage.program().string(), "render", kHostile}};
    job.address = "the-host";
    const auto call = [&] {
        return stage.called(find_script(stage.pool(job), "coordinator"), {"SLURM_JOB_ID=123456"});
    };
    auto words = call();
    REQUIRE(words.size() == 6);
    CHECK(words[1] == kHostile);
    CHECK(words[3] == (stage.place.folder / "token").string());
    CHECK(words[4] == "--listen");
    CHECK(std::stoi(words[5].substr(1)) >= 23456);
    const auto address = [&] {
        std::ifstream in(stage.place.folder / "address");
        std::string line;
        REQUIRE(std::getline(in, line));
        return line;
    };
    CHECK(address() == "the-host" + words[5]);
    CHECK_FALSE(fs::exists(stage.place.folder / "address.part"));
    job.port = 7;
    words = call();
    CHECK(words[5] == ":7");
    CHECK(address() == "the-host:7");
}

TEST_CASE("frames are joined when all are there", "[cluster][scripts]") {
    Stage stage;
    const std::string pattern = "it's 100 $frames/%03d of.png";
    const auto join = [&](const std::string& video) {
        const ArrayJob job =
            array_of_frames(stage.film({8, 11}, 4, pattern, video), kEngines[kSlurm]);
        return find_script(kEngines[kSlurm].make_array(job, stage.place), "merge");
    };
    const std::string script = join(kHostile);
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
    std::vector<std::string> words{"animate", kHostile, "-o", pattern, "--video", kHostile};
    CHECK(stage.called(script, {}) == words);
    CHECK(stage.done.status == 0);
    words.resize(4);
    words.insert(words.end(), {"--first", "8", "--last", "11"});
    CHECK(stage.called(join(""), {}) == words);
    CHECK_THROWS_AS(array_of_frames(stage.film({0, 1}, 1, "a.png"), kEngines[kSlurm]),
                    util::UsageError);
}

TEST_CASE("parts resume with their tiles, and are joined", "[cluster][scripts]") {
    Stage stage;
    const std::string picture = (stage.folder.path() / kHostile / "a picture.exr").string();
    const auto script = [&](const char* name, int count = 5) {
        const ArrayJob job =
            array_of_parts({stage.program().string(), "render", "w", "-o", picture}, picture, count,
                           {"-o", kHostile, "-o", "b.png"}, kEngines[kSlurm]);
        return find_script(kEngines[kSlurm].make_array(job, stage.place), name);
    };
    CHECK(stage.called(script("parts"), {"SLURM_ARRAY_TASK_ID=2"}, {"0"}) ==
          std::vector<std::string>{"render", "w", "-o", picture, "--resume", "--part", "3/5"});
    CHECK(stage.called(script("parts"), {"SLURM_ARRAY_TASK_ID=1"}, {"3"}).back() == "5/5");
    CHECK(stage.called(script("merge", 2), {}) ==
          std::vector<std::string>{"merge",
                                   farm::checkpoint_path(picture, farm::Part{1, 2}).string(),
                                   farm::checkpoint_path(picture, farm::Part{2, 2}).string(), "-o",
                                   kHostile, "-o", "b.png"});
}

TEST_CASE("squares are prepared by the arguments of the frames", "[cluster][scripts]") {
    Stage stage;
    ArrayJob job = array_of_frames(stage.film({3, 12}, 4), kEngines[kSlurm]);
    job.bakers = 7;
    job.bake = fill("scripts/bake.sh", {{"words", Command{kHostile, "-o", "x"}},
                                        {"program", stage.program().string()},
                                        {"kind", "animate"},
                                        {"tasks", 7},
                                        {"task", kEngines[kSlurm].number()}});
    const JobFiles made = kEngines[kSlurm].make_array(job, stage.place);
    CHECK(stage.called(find_script(made, "bake"), {"SLURM_ARRAY_TASK_ID=6"}) ==
          std::vector<std::string>{"cluster", "bake", "--for", "animate", "--part", "7/7", kHostile,
                                   "-o", "x"});
    CHECK_THAT(made.start, contains("bake 6\n"));
}

TEST_CASE("a job template holds scripts that bash runs", "[cluster][openjd]") {
    Stage stage;
    FrameJob job{"a film", {stage.program().string(), "animate", kHostile}, "%d.png", {0, 9}, 4,
                 "v.mp4"};
    stage.place.needs = {2, 1000};
    const auto openjd = [&] {
        const ArrayJob frames = array_of_frames(job, kEngines[kOpenJd]);
        return kEngines[kOpenJd].make_array(frames, stage.place).start;
    };
    const auto json = nlohmann::json::parse(openjd());
    CHECK(json["specificationVersion"] == "jobtemplate-2023-09");
    CHECK(json["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"] == "0-2");
    CHECK(json["steps"][1]["dependencies"][0]["dependsOn"] == "frames");
    CHECK(json["steps"][0]["hostRequirements"]["amounts"].size() == 2);
    const std::string script = json["steps"][0]["script"]["embeddedFiles"][0]["data"];
    CHECK(stage.called(script, {}, {"2"}) ==
          std::vector<std::string>{"animate", kHostile, "--first", "8", "--last", "9"});
    stage.place.needs = {};
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
    FrameJob job{"film",
                 {stage.program().string(), "animate", kHostile, "$(HOME) $$", "{{command}}"},
                 "%d.png",
                 {0, 9},
                 4};
    stage.place.needs = {2, 1000};
    const auto frames = nlohmann::json::parse(
        kEngines[kKubernetes]
            .make_array(array_of_frames(job, kEngines[kKubernetes]), stage.place)
            .start);
    const auto& spec = frames["items"][0]["spec"];
    CHECK(spec["completions"] == 3);
    CHECK(spec["completionMode"] == "Indexed");
    const auto& command = spec["template"]["spec"]["containers"][0]["command"];
    CHECK(stage.called(expanded(command[2]), {"JOB_COMPLETION_INDEX=1"}) ==
          std::vector<std::string>{"animate", kHostile, "$(HOME) $$", "{{command}}", "--first", "4",
                                   "--last", "7"});

    const std::string join =
        frames["items"][1]["spec"]["template"]["spec"]["containers"][0]["command"][2];
    CHECK_THAT(join, contains("until look 2>/dev/null; do sleep 30; done  # --wait\n"));
    const auto pool = nlohmann::json::parse(
        kEngines[kKubernetes].make_pool({"film", {"p", "render", "$(HOME)"}}, stage.place).start);
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
    const Command run{stage.program().string(), "run"};
    const Command join{stage.program().string(), "join"};
    const Engine& slurm = kEngines[kSlurm];
    return {.name = "land",
            .tasks_name = "shards",
            .join_name = "join",
            .tasks = tasks,
            .task = fill("scripts/shards.sh",
                         {{"command", run}, {"tasks", 3}, {"task", slurm.number()}}),
            .join = fill("scripts/join.sh", {{"command", join}, {"waits", slurm.waits()}})};
}

}  // namespace

TEST_CASE("tasks of an array know their number, and the join follows", "[cluster][scripts]") {
    Stage stage;
    const JobFiles made = kEngines[kSlurm].make_array(read_array(stage, 3), stage.place);
    REQUIRE(made.scripts.size() == 2);
    CHECK(made.scripts[0].first == "shards.sbatch");
    CHECK(stage.called(made.scripts[0].second, {"SLURM_ARRAY_TASK_ID=2"}, {"1001"}) ==
          std::vector<std::string>{"run", "--task", "1004"});
    CHECK(made.scripts[1].first == "join.sbatch");
    CHECK(stage.called(made.scripts[1].second, {}) == std::vector<std::string>{"join"});
    CHECK(has(asked(made.scripts[0].second), "--job-name=terravox-shards"));
}

namespace {

/// Programs of Slurm that write down what they are called with. A job's number is that of the call.
struct Submission {
    explicit Submission(Stage& of) : stage(of) {
        write("sbatch",
              "printf '%s\n' \"$*\" >> \"$here/submitted\"\nwc -l < \"$here/submitted\"\n");
        write("scontrol", "printf 'MaxArraySize            = %s\\n' \"${LIMIT:-1001}\"\n");
        write("squeue", "cat \"$here/queue\" 2> /dev/null || true\n");
        stage.place.nodes = 7;
    }
    void write(const std::string& name, const std::string& body) const {
        const fs::path file = stage.folder.path() / name;
        std::ofstream(file) << "#!/bin/bash\nhere=$(dirname \"$0\")\n" << body;
        fs::permissions(file, fs::perms::owner_all);
    }
    /// @return calls of sbatch
    std::vector<std::string> run(const ArrayJob& job) const {
        const std::string script = kEngines[kSlurm].make_array(job, stage.place).start;
        (void)stage.called(script, {"PATH=" + stage.folder.path().string() + ":/usr/bin:/bin"});
        std::ifstream in(stage.folder.path() / "submitted");
        std::vector<std::string> lines;
        for (std::string line; std::getline(in, line);)
            lines.push_back(line);
        return lines;
    }
    Stage& stage;
};

}  // namespace

TEST_CASE("arrays are submitted one after the other, and the join after all of them",
          "[cluster][scripts]") {
    Stage stage;
    const Submission slurm(stage);
    CHECK(slurm.run(read_array(stage, 1500)) ==
          std::vector<std::string>{
              "--parsable --array=0-1000%7 shards.sbatch 0",
              "--parsable --array=0-498%7 --dependency=afterany:1 shards.sbatch 1001",
              "--parsable --dependency=afterany:1:2 join.sbatch"});
    REQUIRE(stage.done.status == 0);
    CHECK(stage.done.out == "submitted: tasks 1:2, join 3\n");
    std::ofstream(stage.folder.path() / "queue") << "2 2_7 R None\n9 9_1 R None\n3 3 PD Priority\n";
    CHECK(slurm.run(read_array(stage, 1500)).size() == 3);
    CHECK(stage.done.status == 1);
    CHECK_THAT(stage.done.err, contains("terravox: run the tasks: 2 of "));
    std::ofstream(stage.folder.path() / "queue") << "9 9_1 R None\n";
    CHECK(slurm.run(read_array(stage, 1)).size() == 5);
}

TEST_CASE("only tasks that are not done are submitted", "[cluster][scripts]") {
    Stage stage;
    const Submission slurm(stage);
    ArrayJob job = read_array(stage, 3000);
    struct Case {
        const char* name;
        const char* tasks;
        std::vector<std::string> arrays;
    };
    const auto c = GENERATE(values<Case>(
        {{"one", "7", {"7%7 shards.sbatch 0"}},
         {"runs and single ones", "0 1 2 7 9 10", {"0-2,7,9-10%7 shards.sbatch 0"}},
         {"a run across the limit",
          "999 1000 1001 1002",
          {"999-1000%7 shards.sbatch 0", "0-1%7 --dependency=afterany:1 shards.sbatch 1001"}},
         {"of the last array alone", "2002 2004", {"0,2%7 shards.sbatch 2002"}}}));
    DYNAMIC_SECTION(c.name) {
        job.to_do = std::string("tasks=(") + c.tasks + ")";
        const auto lines = slurm.run(job);
        REQUIRE(lines.size() == c.arrays.size() + 1);
        for (std::size_t i = 0; i < c.arrays.size(); ++i)
            CHECK(lines[i] == "--parsable --array=" + c.arrays[i]);
    }
}

TEST_CASE("every task is in one array, with a number below the limit", "[cluster][scripts]") {
    Stage stage;
    const Submission slurm(stage);
    ArrayJob job = read_array(stage, 3000);
    const auto seed = GENERATE(1U, 2U, 3U);
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::vector<int> tasks;
    job.to_do = "tasks=(";
    for (int i = 0; i < 3000; ++i)
        if (random() % 3 != 0) {
            tasks.push_back(i);
            job.to_do += std::to_string(i) + " ";
        }
    job.to_do += ")";
    auto lines = slurm.run(job);
    REQUIRE(lines.size() == 4);
    lines.pop_back();  // the join
    std::vector<int> found;
    for (const std::string& line : lines) {
        const std::size_t begin = line.find("--array=") + 8;
        const int offset = std::stoi(line.substr(line.rfind(' ')));
        for (const int number : list_numbers(line.substr(begin, line.find('%') - begin))) {
            CHECK(number < 1001);
            found.push_back(offset + number);
        }
    }
    CHECK(found == tasks);
}

TEST_CASE("tasks of frames are those that animate lists", "[cluster][scripts]") {
    Stage stage;
    const Submission slurm(stage);
    std::ofstream(stage.program()) << "#!/bin/bash\n[[ $FAIL ]] && exit 2\necho 5 6 12\n";
    ArrayJob job = array_of_frames(stage.film({3, 12}, 4), kEngines[kSlurm]);
    // The program of this machine lists them; here it is the stage's.
    const std::string line = "list=(\n";
    const std::size_t at = job.to_do.find(line) + line.size();
    job.to_do.replace(at, job.to_do.find('\n', at) - at,
                      util::shell_word(stage.program().string()));
    CHECK(slurm.run(job).front() == "--parsable --array=0,2%7 frames.sbatch 0");
    CHECK_THAT(stage.done.err, contains("3 of 10 frames are to be made"));
}
