#include <chrono>
#include <cstdio>
#include <optional>

#include "common/util/program.hpp"
#include "voxelserver/tools/survey/survey_options.hpp"

namespace {

using namespace terravox;

void print_table(const std::vector<survey::SquareReport>& reports, double seconds) {
    survey::SquareReport all;
    std::printf("%-20s %12s %10s %9s\n", "square", "points", "MB", "seconds");
    for (const auto& report : reports) {
        std::printf("%-20s %12llu %10.1f %9.2f\n", report.name.c_str(),
                    static_cast<unsigned long long>(report.points),
                    static_cast<double>(report.bytes) / 1e6, report.seconds);
        all.points += report.points;
        all.bytes += report.bytes;
    }
    std::printf("%-20s %12llu %10.1f %9.2f\n", "all", static_cast<unsigned long long>(all.points),
                static_cast<double>(all.bytes) / 1e6, seconds);
}

int run(int argc, char** argv) {
    std::optional<int> exit_code;
    const auto options = survey::parse_options(argc, argv, exit_code);
    if (!options)
        return *exit_code;
    const auto start = std::chrono::steady_clock::now();
    const std::size_t count = survey::list_squares(*options).size();
    const auto reports =
        survey::run_survey(*options, [count](const survey::SquareReport& report, std::size_t done) {
            std::fprintf(stderr, "survey: %s done, %llu points in %.1f s (%zu of %zu squares)\n",
                         report.name.c_str(), static_cast<unsigned long long>(report.points),
                         report.seconds, done, count);
        });
    print_table(reports,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return static_cast<int>(util::ExitCode::kDone);
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_program([&] { return run(argc, argv); });
}
