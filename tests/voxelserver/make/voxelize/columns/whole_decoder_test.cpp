#include "voxelserver/make/voxelize/columns/square_reader.hpp"

#include <algorithm>
#include <atomic>
#include <new>
#include <thread>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/squares.hpp"

using namespace terravox;
using namespace terravox::test;
using voxelize::LoadedSquare;
using voxelize::WholeDecoder;

namespace {

LoadedSquare loaded(std::size_t file) {
    return {made_square(static_cast<unsigned>(file) + 1, 10, 1), made_index(1, 3)};
}

SquarePtr keep_as_it_is(std::size_t, const LoadedSquare& square) {
    return square.square;
}

}  // namespace

TEST_CASE("a file is decoded, and what keeps it says which square to use",
          "[voxelserver][voxelize][decoder]") {
    const SquarePtr mapped = made_square(9, 10, 1);
    std::vector<std::size_t> files;
    WholeDecoder decoder(2, loaded, [&](std::size_t file, const LoadedSquare& given) {
        files.push_back(file);
        CHECK(same_square(*given.square, *loaded(file).square));
        CHECK(same_index(given.index, made_index(1, 3)));
        return mapped;
    });
    CHECK(decoder.decode(1) == mapped);
    CHECK(decoder.decode(0) == mapped);
    CHECK(files == std::vector<std::size_t>{1, 0});
}

TEST_CASE("a damaged file is tried once, and fails with the same message each time",
          "[voxelserver][voxelize][decoder][damage]") {
    int tries = 0;
    WholeDecoder decoder(
        2,
        [&](std::size_t file) {
            ++tries;
            if (file == 0)
                throw util::Error("read a.laz: cut short");
            return loaded(file);
        },
        keep_as_it_is);
    for (int i = 0; i < 3; ++i)
        CHECK_THROWS_WITH(decoder.decode(0), "read a.laz: cut short");
    CHECK(tries == 1);
    CHECK(decoder.decode(1));
}

TEST_CASE("a failure that is not the file's is not cached", "[voxelserver][voxelize][decoder]") {
    int tries = 0;
    SECTION("no memory to decode it") {
        WholeDecoder decoder(
            1,
            [&](std::size_t file) {
                if (++tries == 1)
                    throw std::bad_alloc();
                return loaded(file);
            },
            keep_as_it_is);
        CHECK_THROWS_AS(decoder.decode(0), std::bad_alloc);
        CHECK(decoder.decode(0));
    }
    SECTION("it could not be kept") {
        WholeDecoder decoder(1, loaded, [&](std::size_t, const LoadedSquare& given) {
            if (++tries == 1)
                throw util::Error("write the square: no space left");
            return given.square;
        });
        CHECK_THROWS_AS(decoder.decode(0), util::Error);
        CHECK(decoder.decode(0));
    }
}

TEST_CASE("one file at a time is decoded and kept", "[voxelserver][voxelize][decoder]") {
    constexpr std::size_t kFiles = 4;
    std::atomic<int> running{0};
    std::atomic<int> max_running{0};
    WholeDecoder decoder(
        kFiles,
        [&](std::size_t file) {
            max_running = std::max(max_running.load(), ++running);
            std::this_thread::yield();
            return loaded(file);
        },
        [&](std::size_t, const LoadedSquare& given) {
            std::this_thread::yield();
            --running;
            return given.square;
        });
    std::vector<std::thread> threads;
    for (std::size_t file = 0; file < kFiles; ++file)
        threads.emplace_back([&, file] {
            for (int i = 0; i < 100; ++i)
                (void)decoder.decode(file);
        });
    for (std::thread& thread : threads)
        thread.join();
    CHECK(max_running == 1);
}
