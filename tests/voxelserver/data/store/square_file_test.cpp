#include <chrono>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "voxelserver/data/store/square_folder.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

TEST_CASE("a prepared square is read back as it was written", "[voxelserver][store]") {
    struct Case {
        const char* name;
        std::size_t points;
        int patches;
    };
    const auto c = GENERATE(values<Case>({{"empty", 0, 1},
                                          {"a single point", 1, 1},
                                          {"one patch", 3000, 1},
                                          {"twenty patches", 20'000, 20}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "a.square";
        const SquarePtr written = made_square(11, c.points, c.patches);
        store::write_square(file, *written);
        const SquarePtr read = store::map_square(file);
        REQUIRE(read);
        CHECK(read->patches().size() == written->patches().size());
        CHECK(read->all().size() == c.points);
        CHECK(read->counts().outliers == 11);
        CHECK(read->counts().kept == c.points);
        CHECK(same_square(*written, *read));
        CHECK(read->points({1000, 1000}).empty());
        CHECK(read->memory_bytes() >= std::filesystem::file_size(file));
        CHECK(files_ending(folder.path(), ".square").size() == 1);  // nothing unfinished stays
        SECTION("and so is a copy of the mapped one") {
            const auto second = folder.path() / "b.square";
            store::write_square(second, *read);
            CHECK((read_content(second) == read_content(file)));
        }
        SECTION("and it stays readable when its file goes") {
            std::filesystem::remove(file);
            CHECK(same_square(*written, *read));
        }
    }
}

TEST_CASE("a chunk index is read back as it was written", "[voxelserver][store]") {
    const TemporaryFolder folder;
    const std::size_t chunks = GENERATE(std::size_t{0}, std::size_t{1}, std::size_t{300});
    const auto written = made_index(5, chunks);
    store::write_chunks(folder.path() / "a.chunks", written);
    const auto read = store::read_chunks(folder.path() / "a.chunks");
    REQUIRE(read);
    CHECK(read->chunks().size() == chunks);
    CHECK(same_index(written, *read));
}

TEST_CASE("a file that is not there is no error, and what is no plain file is one",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    CHECK(store::map_square(folder.path() / "none.square") == nullptr);
    CHECK(store::map_square(folder.path() / "none" / "below.square") == nullptr);
    CHECK_FALSE(store::read_chunks(folder.path() / "none.chunks"));
    write_bytes(folder.path() / "plain", "text");
    CHECK(store::map_square(folder.path() / "plain" / "below.square") == nullptr);
    std::filesystem::create_directory(folder.path() / "folder.square");
    CHECK_THROWS_WITH(store::map_square(folder.path() / "folder.square"),
                      contains("folder.square: not a plain file"));
    const auto pipe = folder.path() / "pipe.square";
    REQUIRE(std::system(("mkfifo " + pipe.string()).c_str()) == 0);
    CHECK_THROWS_WITH(store::map_square(pipe),
                      contains("not a plain file"));  // and opening it does not wait for a writer
    write_bytes(folder.path() / "empty", "");
    const auto empty = util::MappedFile::open(folder.path() / "empty");
    REQUIRE(empty);
    CHECK(empty->bytes().empty());
}

TEST_CASE("a square that cannot be written is an error that names it", "[voxelserver][store]") {
    const TemporaryFolder folder;
    const SquarePtr square = made_square(1, 100, 3);
    write_bytes(folder.path() / "plain", "text");
    CHECK_THROWS_WITH(store::write_square(folder.path() / "plain" / "a.square", *square),
                      contains("a.square"));
    CHECK_THROWS_AS(store::write_square("/proc/terravox/a.square", *square), util::Error);
    CHECK_THROWS_AS(store::write_chunks(folder.path() / "plain" / "a.chunks", made_index(1, 3)),
                    util::Error);
}

TEST_CASE("the name of a prepared square changes with its file and its recipe",
          "[voxelserver][store]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "a.laz";
    std::string bytes(200'000, 'p');
    write_bytes(file, bytes);
    const auto time = fs::last_write_time(file);
    const std::string name = store::square_name(file, "recipe");
    CHECK(store::square_name(file, "recipe") == name);
    CHECK(name.starts_with("a-"));
    CHECK(store::square_name(file, "recipe ") != name);
    struct Case {
        const char* name;
        std::size_t at;
        bool longer;
        bool later;
    };
    const auto c = GENERATE(values<Case>({{"first byte", 0, false, false},
                                          {"last byte", 199'999, false, false},
                                          {"byte 65535", 65'535, false, false},
                                          {"longer", 100'000, true, false},
                                          {"later", 100'000, false, true}}));
    DYNAMIC_SECTION(c.name) {
        bytes[c.at] = c.later || c.longer ? 'p' : 'q';
        if (c.longer)
            bytes += 'p';
        write_bytes(file, bytes);
        fs::last_write_time(file, c.later ? time + std::chrono::seconds(1) : time);
        CHECK(store::square_name(file, "recipe") != name);
    }
    fs::remove(file);
    CHECK_THROWS_WITH(store::square_name(file, ""), contains("a.laz"));
}

TEST_CASE("squares of files with odd names are kept", "[voxelserver][store]") {
    const TemporaryFolder folder;
    const std::string stem = GENERATE(as<std::string>(), std::string(250, 'n'), ".hidden", "..",
                                      "with space and \"quotes\"", "\xc5\xbd\xc4\x8d");
    const fs::path file = folder.path() / (stem + ".laz");
    write_bytes(file, "abc");
    store::SquareFolder squares(folder.path() / "cache", 1 << 20);
    const std::string name = store::square_name(file, "");
    const SquarePtr square = made_square(1, 500, 3);
    const Warnings warnings;
    CHECK(same_square(*squares.put(name, square), *square));
    squares.put_index(name, made_index(1, 3));
    INFO(warnings.text());
    CHECK(warnings.text().empty());
    REQUIRE(squares.find(name));
    CHECK(same_square(*squares.find(name), *square));
    CHECK(squares.find_index(name));
}
