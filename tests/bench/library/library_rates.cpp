// How fast the C++ library casts rays and reads surfaces, for tests/bench/library/python_rates.py:
//   library_rates ARCHIVE RAYS THREADS     prints seconds of cast and of surface, a line each
// The rays are those of python_rates.py: a linear congruential generator makes them.
#include <terravox/terravox.hpp>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

/// Numbers in [0, 1). Ref: Knuth's MMIX, "The Art of Computer Programming", volume 2.
class Random {
public:
    double next() {
        m_state = m_state * 6364136223846793005ULL + 1442695040888963407ULL;
        return static_cast<double>(m_state >> 11) / 9007199254740992.0;
    }

private:
    std::uint64_t m_state = 1;
};

template <class Work>
double seconds_of(const Work& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: library_rates ARCHIVE RAYS THREADS\n");
        return 2;
    }
    const auto world = terravox::World::open({argv[1]});
    const auto count = std::strtoull(argv[2], nullptr, 10);
    const int threads = std::atoi(argv[3]);
    const auto& bounds = world.info().bounds;
    Random random;
    std::vector<double> origins;
    std::vector<double> directions;
    for (std::size_t i = 0; i < count; ++i) {
        origins.push_back(bounds.west + (bounds.east - bounds.west) * random.next());
        origins.push_back(bounds.south + (bounds.north - bounds.south) * random.next());
        origins.push_back(bounds.top + 10);
        directions.push_back(2 * random.next() - 1);
        directions.push_back(2 * random.next() - 1);
        directions.push_back(-0.1 - random.next());
    }
    terravox::CastOptions options;
    options.threads = threads;
    (void)world.surface();  // boxes are in memory from here on
    std::printf("%.6f\n", seconds_of([&] { (void)world.cast(origins, directions, options); }));
    std::printf("%.6f\n", seconds_of([&] { (void)world.surface(std::nullopt, 0, threads); }));
    return 0;
}
