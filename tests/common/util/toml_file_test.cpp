#include "common/util/toml_file.hpp"

#include <sys/stat.h>

#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMax_bytes = std::size_t{1} << 20;

toml::table read(const fs::path& file) {
    return util::read_toml(
        file, [](const std::string& what) { throw util::UsageError("said: " + what); });
}

std::string repeated(const std::string& part, int times) {
    std::string out;
    for (int i = 0; i < times; ++i)
        out += part;
    return out;
}

}  // namespace

TEST_CASE("a TOML file is read", "[common][util][toml]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "a.toml") << "[a]\nb.c = 0.5\n";
    CHECK(read(folder.path() / "a.toml")["a"]["b"]["c"].value_or(0.0) == 0.5);
    std::ofstream(folder.path() / "empty.toml");
    CHECK(read(folder.path() / "empty.toml").empty());
    fs::create_symlink(folder.path() / "a.toml", folder.path() / "link.toml");
    CHECK(read(folder.path() / "link.toml").size() == 1);
}

TEST_CASE("only a plain file is read as TOML, and opening any other kind does not block",
          "[common][util][toml]") {
    const TemporaryFolder folder;
    const auto pipe = folder.path() / "pipe";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    for (const fs::path& file :
         {folder.path(), fs::path("/"), fs::path("/dev/zero"), fs::path("/dev/null"), pipe}) {
        INFO(file.string());
        CHECK_THROWS_AS(read(file), util::UsageError);
        CHECK_THROWS_WITH(read(file), "said: not a plain file");
    }
    CHECK_THROWS_WITH(read(folder.path() / "none.toml"), "said: no such file");
    CHECK_THROWS_WITH(read(folder.path() / "none" / "none.toml"), "said: no such file");
}

TEST_CASE("an error in a TOML file names its line", "[common][util][toml]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "a.toml") << "a = 1\nb = \n";
    CHECK_THROWS_WITH(read(folder.path() / "a.toml"), contains("said: ") && contains("(line 2)"));
}

TEST_CASE("a file may be a mebibyte long, and no longer", "[common][util][toml]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "a.toml";
    std::ofstream(file) << "a = 1\n#" << std::string(kMax_bytes - 7, '-');
    REQUIRE(fs::file_size(file) == kMax_bytes);
    CHECK(read(file).size() == 1);
    std::ofstream(file, std::ios::app) << "-";
    CHECK_THROWS_WITH(read(file), contains("1 MiB"));
    fs::resize_file(file, std::uintmax_t{1} << 40);  // a hole of a tebibyte is not read
    CHECK_THROWS_WITH(read(file), contains("1 MiB"));
}

// Deeper nesting than a stack holds; the parser itself stops only values within values.
TEST_CASE("no nesting of names or values ends the program", "[common][util][toml]") {
    struct Case {
        const char* name;
        std::string text;
        bool fits;
    };
    const auto c = GENERATE(values<Case>({
        {"a name of 500,000 parts", "a" + repeated(".a", 500'000) + " = 1", false},
        {"a table of 500,000 parts", "[a" + repeated(".a", 500'000) + "]", false},
        {"parts of digits", "1" + repeated(".1", 500'000) + " = 1", false},
        {"parts that look like something else", "\"=\"" + repeated(".\"=\"", 250'000) + " = 1",
         false},
        {"tables of long names in each other", repeated("{a" + repeated(".a", 40) + " = ", 250),
         false},
        {"500,000 lists in each other", "a = " + repeated("[", 500'000), false},
        {"the deepest that is allowed", "a" + repeated(".a", 10'000) + " = 1", true},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        std::ofstream(folder.path() / "a.toml") << c.text;
        if (c.fits)
            CHECK(read(folder.path() / "a.toml").size() == 1);
        else
            CHECK_THROWS_AS(read(folder.path() / "a.toml"), util::UsageError);
    }
}

TEST_CASE("reading ends even where the error callback returns", "[common][util][toml]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "a.toml") << "a = \n";
    CHECK_THROWS_AS(util::read_toml(folder.path() / "a.toml", [](const std::string&) {}),
                    util::Error);
}
