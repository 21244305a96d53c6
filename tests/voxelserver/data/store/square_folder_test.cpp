#include "voxelserver/data/store/square_folder.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <random>
#include <thread>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

TEST_CASE("the folder never ends above its limit, and what was used longest ago goes first",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    const SquarePtr square = made_square(1, 20'000, 4);  // much larger than the indices
    store::write_square(folder.path() / "probe", *square);
    const std::uint64_t one = fs::file_size(folder.path() / "probe");
    const std::uint64_t limit = 3 * one + one / 2;
    const fs::path cache = folder.path() / "cache";
    store::SquareFolder squares(cache, limit);
    const SquarePtr first = squares.put("s0", square);
    for (int i = 1; i < 8; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(
            15));  // times of files define which was used last; systems round them to 10 ms
        if (i != 6)
            CHECK(squares.find("s0"));  // used again and again, until the end
        squares.put_index("s" + std::to_string(i), made_index(1, 3));
        CHECK(bytes_in(cache) <= limit);
        CHECK(same_square(*squares.put("s" + std::to_string(i), square), *square));
        CHECK(bytes_in(cache) <= limit);
        CHECK(squares.holds("s" + std::to_string(i)));
    }
    CHECK(squares.holds("s0"));
    CHECK_FALSE(squares.holds("s1"));
    CHECK_FALSE(squares.holds("s4"));
    CHECK(squares.find_index("s1"));  // small, and nearly as good
    for (int i = 8; i < 12; ++i)
        CHECK(squares.put("s" + std::to_string(i), square) != square);
    CHECK_FALSE(squares.holds("s0"));
    CHECK(same_square(*first, *square));  // mapped: still there while it is used
}

TEST_CASE("a square larger than the whole folder is not written, and indices alone keep the limit",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    const SquarePtr square = made_square(1, 2000, 4);
    const Warnings warnings;
    store::SquareFolder squares(folder.path() / "cache", 20'000);
    CHECK(squares.put("large", square) == square);
    CHECK_FALSE(squares.holds("large"));
    for (unsigned i = 0; i < 40; ++i) {
        squares.put_index("i" + std::to_string(i), made_index(i, 20));
        REQUIRE(bytes_in(folder.path() / "cache") <= 20'000);
    }
    CHECK(squares.find_index("i39"));  // the last one stays whatever else goes
    CHECK(files_ending(folder.path() / "cache", ".chunks").size() < 12);
    store::SquareFolder none(folder.path() / "none", 0);
    CHECK(none.put("a", square) == square);
    none.put_index("a", made_index(1, 3));
    CHECK(bytes_in(folder.path() / "none") == 0);
    CHECK(warnings.text().empty());
}

TEST_CASE("what another writer has not finished stays, what a crash has left behind goes",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    const SquarePtr square = made_square(1, 2000, 4);
    store::SquareFolder squares(folder.path(), 2 * square->memory_bytes());
    const fs::path young = folder.path() / ".x.part-1-0.square";
    const fs::path old = folder.path() / ".y.part-2-0.square";
    write_bytes(young, std::string(100'000, 'x'));
    write_bytes(old, std::string(100'000, 'y'));
    fs::last_write_time(old, fs::file_time_type::clock::now() - std::chrono::hours(3));
    for (int i = 0; i < 4; ++i)
        CHECK(squares.put("s" + std::to_string(i), square) != square);
    CHECK(fs::exists(young));
    CHECK_FALSE(fs::exists(old));
}

TEST_CASE("a folder without a limit keeps all, but what a crash has left behind",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    const fs::path old = folder.path() / ".y.part-2-0.chunks";
    write_bytes(old, std::string(100'000, 'y'));
    fs::last_write_time(old, fs::file_time_type::clock::now() - std::chrono::hours(3));
    store::SquareFolder kept(folder.path(), store::kUnlimited_bytes);
    CHECK_FALSE(fs::exists(old));
    for (unsigned i = 0; i < 40; ++i) {
        const std::string name = "i" + std::to_string(i);
        CHECK_FALSE(kept.holds_index(name));
        kept.put_index(name, made_index(i, 20));
        CHECK(kept.holds_index(name));
    }
    CHECK(files_ending(folder.path(), ".chunks").size() == 40);
}

TEST_CASE("a folder that cannot be made or written is reported once, and squares stay in memory",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    write_bytes(folder.path() / "plain", "text");
    const std::string below = GENERATE(as<std::string>(), "plain", "plain/below", "/proc/terravox");
    const fs::path place = folder.path() / below;
    INFO(place);
    const Warnings warnings;
    store::SquareFolder squares(place, 1 << 30);
    const SquarePtr square = made_square(1, 200, 4);
    for (int i = 0; i < 3; ++i) {
        squares.put_index("a", made_index(1, 3));
        CHECK(squares.put("a", square) == square);
        CHECK_FALSE(squares.holds("a"));
        CHECK(squares.find("a") == nullptr);
        CHECK_FALSE(squares.find_index("a"));
    }
    INFO(warnings.text());
    CHECK(warnings.count("") == 1);
    CHECK(warnings.count(place.string()) == 1);
    CHECK(warnings.count("nothing more is kept in this folder") == 1);
}

TEST_CASE("a folder that stops taking files is still read", "[voxelserver][store]") {
    const TemporaryFolder folder;
    const SquarePtr square = made_square(1, 200, 4);
    const Warnings warnings;
    store::SquareFolder squares(folder.path() / "cache", 1 << 30);
    CHECK(squares.put("kept", square) != square);
    fs::create_directory(folder.path() / "cache" /
                         "blocked.square");  // a square of that name cannot be written
    CHECK(squares.put("blocked", square) == square);
    CHECK(warnings.count("blocked.square") == 1);
    CHECK(squares.put("other", square) == square);
    CHECK(same_square(*squares.find("kept"), *square));
    CHECK(warnings.count("") == 1);
}

TEST_CASE("a folder that is removed while in use is made again", "[voxelserver][store]") {
    const TemporaryFolder folder;
    const SquarePtr square = made_square(1, 200, 4);
    store::SquareFolder squares(folder.path() / "a" / "cache", 1 << 30);
    const SquarePtr first = squares.put("s", square);
    fs::remove_all(folder.path() / "a");
    CHECK(squares.find("s") == nullptr);
    CHECK(same_square(*first, *square));
    CHECK(squares.put("s", square) != square);
    CHECK(squares.holds("s"));
}

TEST_CASE("facts are kept as bytes, and a file of them that is too large is not read",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    store::SquareFolder squares(folder.path(), 1 << 30);
    CHECK_FALSE(squares.find_facts("s"));
    squares.put_facts("s", std::string("a\0b", 3));
    CHECK(store::SquareFolder(folder.path(), 1 << 30).find_facts("s") == std::string("a\0b", 3));
    squares.put_facts("fits", std::string(store::kMaxFactsBytes, 'x'));
    CHECK(squares.find_facts("fits"));
    squares.put_facts("large", std::string(store::kMaxFactsBytes + 1, 'x'));
    const Warnings warnings;
    CHECK_FALSE(squares.find_facts("large"));
    CHECK(warnings.count("large.facts") == 1);
}

TEST_CASE("damaged squares, indices and facts count as absent with a warning, and are replaced",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    const SquarePtr square = made_square(1, 200, 4);
    store::SquareFolder squares(folder.path(), 1 << 30);
    (void)squares.put("s", square);
    squares.put_index("s", made_index(1, 3));
    squares.put_facts("s", "facts");
    for (const char* file : {"s.square", "s.chunks", "s.facts"})
        write_bytes(folder.path() / file, read_content(folder.path() / file).substr(0, 2100));
    const Warnings warnings;
    CHECK(squares.find("s") == nullptr);
    CHECK_FALSE(squares.find_index("s"));
    CHECK_FALSE(squares.find_facts("s"));
    CHECK(warnings.count("s.square") == 1);
    CHECK(warnings.count("s.chunks") == 1);
    CHECK(warnings.count("s.facts") == 1);
    CHECK(warnings.count("it is made again") == 3);
    (void)squares.put("s", square);
    squares.put_index("s", made_index(1, 3));
    REQUIRE(squares.find("s"));
    CHECK(same_square(*squares.find("s"), *square));
    CHECK(same_index(*squares.find_index("s"), made_index(1, 3)));
}

TEST_CASE("threads that put and read the same squares in a small folder get whole squares only",
          "[voxelserver][store][threads]") {
    const TemporaryFolder folder;
    std::vector<SquarePtr> made;
    for (unsigned i = 0; i < 4; ++i)
        made.push_back(made_square(i, 3000, 6));
    const std::uint64_t limit = 2 * made[0]->memory_bytes();
    store::SquareFolder one(folder.path(), limit),
        two(folder.path(), limit);  // as two processes would
    std::atomic<int> wrong{0};
    std::atomic<int> found{0};
    const Warnings warnings;
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < 8; ++t)
        threads.emplace_back([&, t] {
            std::mt19937 random(t);
            store::SquareFolder& squares = t % 2 == 0 ? one : two;
            for (int i = 0; i < 60; ++i) {
                const unsigned which = random() % 4;
                const std::string name = "s" + std::to_string(which);
                const SquarePtr got =
                    i % 3 == 0 ? squares.put(name, made[which]) : squares.find(name);
                if (got) {
                    ++found;
                    wrong += same_square(*got, *made[which]) ? 0 : 1;
                }
                squares.put_index(name, made_index(which, 10));
                const auto index = squares.find_index(name);
                if (index)
                    wrong += same_index(*index, made_index(which, 10)) ? 0 : 1;
            }
        });
    for (auto& t : threads)
        t.join();
    CHECK(wrong == 0);
    CHECK(found > 100);
    INFO(warnings.text());
    CHECK(warnings.text().empty());
    CHECK(one.put("last", made[0]) != made[0]);  // the folder has not given up
    CHECK(bytes_in(folder.path()) <= limit);
    for (const auto& entry : fs::directory_iterator(folder.path()))
        CHECK_FALSE(entry.path().filename().string().starts_with('.'));
}
