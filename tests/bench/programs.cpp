#include "tests/bench/programs.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "common/util/error.hpp"

namespace terravox::bench {
namespace {

// Debian installs nginx outside of the PATH of normal users.
std::string search_path() {
    const char* path = std::getenv("PATH");
    return std::string(path != nullptr ? path : "/usr/bin:/bin") + ":/usr/sbin:/usr/local/sbin";
}

bool installed(const std::string& program) {
    std::istringstream folders(search_path());
    for (std::string folder; std::getline(folders, folder, ':');) {
        std::error_code ignored;
        if (std::filesystem::is_regular_file(std::filesystem::path(folder) / program, ignored))
            return true;
    }
    return false;
}

}  // namespace

std::string missing_programs(const Context& context, const std::vector<std::string>& names) {
    for (const std::string& name : names) {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(context.programs / name, ignored))
            return "no " + name + " in " + context.programs.string() + " (--programs)";
    }
    return {};
}

ChildOutcome run_program(const Context& context, const std::vector<std::string>& command,
                         const std::filesystem::path& output) {
    const ChildOutcome outcome = context.children.run(command, output);
    if (outcome.exit_code != 0)
        throw util::Error("run " + command.front() + ": exit code " +
                          std::to_string(outcome.exit_code) + ": " + last_line(output));
    return outcome;
}

// The name is that of tests/bench/surveys.py, which takes it, too.
std::filesystem::path demo_survey(const Context& context) {
    auto out = context.scratch / "survey-1000-6";
    if (!std::filesystem::exists(out)) {
        const auto part = context.scratch / "survey-1000-6.part";
        run_program(context,
                    {(context.programs / "terravox-survey").string(), "--seed", "7", "--squares",
                     "1x1", "--square-m", "1000", "--density", "6", "-o", part.string()},
                    context.scratch / "demo-survey.txt");
        std::filesystem::rename(part, out);
    }
    return out;
}

std::string missing_for_grabbing() {
    for (const char* file : {"dist/main.js", "dist-test/tests/grabber/portal/main.js"}) {
        const auto path = std::filesystem::path(TERRAVOX_SOURCE_DIR) / "grabber" / file;
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(path, ignored))
            return "no " + path.string() + " (terravox demo builds it)";
    }
    for (const char* program : {"python3", "node", "curl"})
        if (!installed(program))
            return std::string(program) + " is not installed";
    return {};
}

std::string missing_for_serving(const Context& context, const std::vector<std::string>& others) {
    if (const std::string reason =
            missing_programs(context, {"terravox-voxelserver", "terravox-survey"});
        !reason.empty())
        return reason;
    if (!installed("python3"))
        return "python3 is not installed";
    for (const std::string& program : others)
        if (!installed(program))
            return program + " is not installed";
    return {};
}

nlohmann::json run_script(const Context& context, const std::string& name,
                          const std::vector<std::string>& arguments) {
    const auto program = [&](const char* file) { return (context.programs / file).string(); };
    std::vector<std::string> command = {
        "env",
        "PATH=" + search_path(),
        "TERRAVOX_VOXELSERVER=" + program("terravox-voxelserver"),
        "TERRAVOX_SURVEY=" + program("terravox-survey"),
        "TERRAVOX_RAYTRACER=" + program("terravox-raytracer"),
        "TERRAVOX_ARCHIVE=" + program("terravox-archive"),
        "TERRAVOX_CONVERT=" + program("terravox-convert"),
        "TERRAVOX_PUBLISH=" + program("terravox-publish"),
        "TERRAVOX_VALUES=" + program("picture_values"),
        "TERRAVOX_NODE=" TERRAVOX_NODE,
        "TERRAVOX_BENCH_DATA=" + context.data.string(),
        "TERRAVOX_BENCH_SCRATCH=" + context.scratch.string(),
        "python3",
        "-B",
        std::string(TERRAVOX_SOURCE_DIR) + "/tests/bench/" + name + ".py"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    std::string file = name;
    std::replace(file.begin(), file.end(), '/', '-');
    const auto output = context.scratch / (file + ".txt");
    const ChildOutcome outcome = context.children.run(command, output);
    const std::string said = last_line(output);
    if (outcome.exit_code != 0)
        throw util::Error("run tests/bench/" + name + ".py: exit code " +
                          std::to_string(outcome.exit_code) + ": " + said);
    nlohmann::json figures = nlohmann::json::parse(said, nullptr, false);
    if (!figures.is_object())
        throw util::Error("run tests/bench/" + name + ".py: no figures: " + said);
    return figures;
}

}  // namespace terravox::bench
