// The C++ library's side of tests/bench/library/python_rates.py:
//   library_rates ARCHIVE RAYS
// RAYS is a file of doubles as the machine has them: three for each ray's origin, and then three
// for each ray's direction. Commands are lines of standard input, "cast THREADS" and "surface
// THREADS"; each is answered with a line, the seconds that passed and the processor time that it
// took.
#include <terravox/terravox.hpp>

#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

std::vector<double> doubles_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    std::vector<double> out(file ? static_cast<std::size_t>(file.tellg()) / sizeof(double) : 0);
    file.seekg(0);
    file.read(reinterpret_cast<char*>(out.data()),
              static_cast<std::streamsize>(out.size() * sizeof(double)));
    if (!file || out.empty() || out.size() % 6 != 0)
        throw std::runtime_error("read rays from " + path + ": " + std::to_string(out.size()) +
                                 " numbers; allowed: six for each ray");
    return out;
}

/// User and system time of this process, seconds.
double processor_s() {
    rusage use{};
    ::getrusage(RUSAGE_SELF, &use);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
    };
    return seconds(use.ru_utime) + seconds(use.ru_stime);
}

template <class Work>
void answer(const Work& work) {
    const double processor_before = processor_s();
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    std::cout << passed.count() << ' ' << processor_s() - processor_before << std::endl;
}

void serve(const terravox::World& world, std::span<const double> rays) {
    const std::span<const double> origins = rays.first(rays.size() / 2);
    const std::span<const double> directions = rays.last(rays.size() / 2);
    terravox::CastOptions options;
    for (std::string what; std::cin >> what >> options.threads;) {
        if (what == "cast")
            answer([&] { (void)world.cast(origins, directions, options); });
        else if (what == "surface")
            answer([&] { (void)world.surface(std::nullopt, 0, options.threads); });
        else
            throw std::runtime_error("command '" + what + "'; allowed: cast, surface");
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: library_rates ARCHIVE RAYS\n");
        return 2;
    }
    try {
        const auto world = terravox::World::open({argv[1]});
        const std::vector<double> rays = doubles_of(argv[2]);
        (void)world.surface();  // boxes are in memory from here on
        serve(world, rays);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "library_rates: %s\n", error.what());
        return 1;
    }
}
