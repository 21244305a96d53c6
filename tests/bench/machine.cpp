#include "tests/bench/machine.hpp"

#include <sched.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>

#include "common/util/version.hpp"

namespace terravox::bench {
namespace {

constexpr double kQuietLoad = 1.5;

std::string cpu_model() {
    std::ifstream file("/proc/cpuinfo");
    std::string line;
    while (std::getline(file, line))
        if (line.compare(0, 10, "model name") == 0)
            if (const auto colon = line.find(": "); colon != std::string::npos)
                return line.substr(colon + 2);
    return {};
}

int usable_cores() {
    cpu_set_t set;
    CPU_ZERO(&set);
    return ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

std::string system_name() {
    utsname name{};
    return ::uname(&name) == 0 ? std::string(name.sysname) + " " + name.release + " " + name.machine
                               : std::string();
}

std::string compiler_name() {
#if defined(__clang__)
    return std::string("Clang ") + __clang_version__;
#elif defined(__GNUC__)
    return std::string("GCC ") + __VERSION__;
#else
    return {};
#endif
}

std::string utc_now() {
    const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    std::tm parts{};
    ::gmtime_r(&now, &parts);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text.data();
}

/// Empty without git or outside a checkout: a figure is still a figure.
std::string find_commit(ChildRunner& children, const std::filesystem::path& scratch) {
    const auto answer = scratch / "git.txt";
    const auto outcome = children.run(
        {"git", "-C", TERRAVOX_SOURCE_DIR, "describe", "--always", "--dirty", "--tags"}, answer);
    return outcome.exit_code == 0 ? last_line(answer) : std::string();
}

}  // namespace

Machine read_machine(ChildRunner& children, const std::filesystem::path& scratch) {
    Machine out;
    out.cpu = cpu_model();
    out.system = system_name();
    out.compiler = compiler_name();
    out.build_type = TERRAVOX_BUILD_TYPE;
    out.cores = usable_cores();
    out.memory_gib = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                     static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1024.0 * 1024 * 1024);
    double load = 0;
    if (::getloadavg(&load, 1) == 1)
        out.load = load;
    out.date = utc_now();
    out.version = kVersion;
    out.commit = find_commit(children, scratch);
    return out;
}

std::vector<std::string> list_warnings(const Machine& machine) {
    std::vector<std::string> out;
    if (machine.load > kQuietLoad) {
        std::array<char, 160> text{};
        std::snprintf(text.data(), text.size(),
                      "noisy: load average %.2f at the start; figures are steady below %.1f",
                      machine.load, kQuietLoad);
        out.emplace_back(text.data());
    }
    if (machine.build_type != "Release")
        out.push_back("slow: a " + (machine.build_type.empty() ? "nameless" : machine.build_type) +
                      " build; measure Release");
    return out;
}

}  // namespace terravox::bench
