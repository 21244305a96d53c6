#include <chrono>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "voxelserver/data/store/square_folder.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

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
