#include "common/util/secret.hpp"

#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <utility>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
namespace fs = std::filesystem;

namespace {

/// These variables, and none of the others of this kind, for as long as this lives.
class Variables {
public:
    Variables(std::initializer_list<std::pair<const char*, std::string>> values) {
        clear();
        for (const auto& [name, value] : values)
            ::setenv(name, value.c_str(), 1);
    }
    ~Variables() { clear(); }
    Variables(const Variables&) = delete;
    Variables& operator=(const Variables&) = delete;

private:
    static void clear() {
        for (const char* name : {"TERRAVOX_TOKEN", util::kFarmTokenVariable,
                                 util::kServerTokenVariable, "CREDENTIALS_DIRECTORY"})
            ::unsetenv(name);
    }
};

fs::path write(const fs::path& path, const std::string& text,
               fs::perms perms = fs::perms::owner_read) {
    std::ofstream(path, std::ios::binary) << text;
    fs::permissions(path, perms);
    return path;
}

}  // namespace

TEST_CASE("each secret has a variable of its own, and the file goes before it",
          "[common][util][secret]") {
    const test::TemporaryFolder folder;
    const auto file = write(folder.path() / "token", "of the file\r\n");
    const Variables variables{{util::kFarmTokenVariable, "of the farm"},
                              {util::kServerTokenVariable, "of the server"}};
    CHECK(util::find_secret({}, util::kFarmTokenVariable).text == "of the farm");
    CHECK(util::find_secret({}, util::kServerTokenVariable).text == "of the server");
    CHECK(util::find_secret(file, util::kServerTokenVariable).text == "of the file");
    CHECK(util::find_secret(file, util::kServerTokenVariable).attempt ==
          "read the token file " + file.string());
    CHECK(util::find_secret({}, util::kFarmTokenVariable).attempt ==
          "read the environment variable TERRAVOX_FARM_TOKEN");
}

TEST_CASE("the old name of both secrets is refused with the new ones, and its value never shown",
          "[common][util][secret]") {
    const test::TemporaryFolder folder;
    const auto file = write(folder.path() / "token", "of the file");
    const Variables variables{{"TERRAVOX_TOKEN", "the-old-secret"},
                              {util::kFarmTokenVariable, "of the farm"}};
    for (const fs::path& from : {fs::path(), file}) {
        CHECK_THROWS_AS(util::find_secret(from, util::kFarmTokenVariable), util::UsageError);
        CHECK_THROWS_WITH(util::find_secret(from, util::kServerTokenVariable),
                          contains("TERRAVOX_TOKEN") && contains("TERRAVOX_FARM_TOKEN") &&
                              contains("TERRAVOX_SERVER_TOKEN") && !contains("the-old-secret"));
    }
    const Variables empty{{"TERRAVOX_TOKEN", ""}};
    CHECK(util::find_secret({}, util::kFarmTokenVariable).text.empty());
}

TEST_CASE("a voxel server's token fits a header, or is refused without being shown",
          "[common][util][secret]") {
    const test::TemporaryFolder folder;
    const Variables variables{};
    CHECK(util::find_server_token({}).empty());
    struct Case {
        const char* name;
        std::string text;
        bool good;
    };
    for (const Case& c :
         {Case{"plain", "eight.or-more", true}, Case{"with a line's end", "eight.or-more\n", true},
          Case{"longest", std::string(512, 'x'), true}, Case{"empty", "", false},
          Case{"short", "7.chars", false}, Case{"too long", std::string(513, 'x'), false},
          Case{"a blank", "two words.", false},
          Case{"a header of its own", "12345678\r\nX-Admin: yes", false},
          Case{"another alphabet", "caf\xc3\xa9-caf\xc3\xa9", false}}) {
        INFO(c.name);
        const auto file = write(folder.path() / c.name, c.text);
        if (c.good) {
            CHECK(util::find_server_token(file) == c.text.substr(0, c.text.find('\n')));
            continue;
        }
        CHECK_THROWS_AS(util::find_server_token(file), util::UsageError);
        CHECK_THROWS_WITH(util::find_server_token(file),
                          contains(file.string()) && contains("allowed: 8 to 512 visible ASCII"));
        if (c.text.empty())
            continue;
        CHECK_THROWS_WITH(util::find_server_token(file), !contains(c.text));
        const Variables of_environment{{util::kServerTokenVariable, c.text}};
        CHECK_THROWS_WITH(util::find_server_token({}), contains("TERRAVOX_SERVER_TOKEN"));
    }
    const auto shown = write(folder.path() / "shown", "eight.or-more",
                             fs::perms::owner_read | fs::perms::others_read);
    CHECK_THROWS_WITH(util::find_server_token(shown), contains("chmod 600"));
}

TEST_CASE("a group may read what systemd hands to a service, and nothing else",
          "[common][util][secret]") {
    const test::TemporaryFolder folder;
    const test::TemporaryFolder elsewhere;
    const auto group_reads = fs::perms::owner_read | fs::perms::group_read;
    const auto credential = write(folder.path() / "token", "of-the-credential", group_reads);
    const auto other = write(elsewhere.path() / "token", "of-another-folder", group_reads);
    const auto shown =
        write(folder.path() / "shown", "of-the-credential", group_reads | fs::perms::others_read);
    const auto below = folder.path() / ".." / elsewhere.path().filename() / "token";
    const auto read = [](const fs::path& file) {
        return util::find_secret(file, util::kFarmTokenVariable).text;
    };
    CHECK_THROWS_WITH(read(credential), contains("chmod 600"));
    const Variables variables{{"CREDENTIALS_DIRECTORY", folder.path().string()}};
    CHECK(read(credential) == "of-the-credential");
    for (const fs::path& file : {other, shown, below}) {
        INFO(file);
        CHECK_THROWS_WITH(read(file), contains("chmod 600"));
    }
}
