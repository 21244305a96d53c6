#include "common/util/secret.hpp"

#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <set>
#include <utility>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
namespace fs = std::filesystem;

namespace {

const std::string kOfFile = "kv7r2mx9q4tz8wpd5hcnb3fj6gy1ks7a";
const std::string kOfFarm = "y3bw6fj8nq2xs5gm9tzkc7dv1hr4pe8u";
const std::string kOfServer = "n6cq9wx3tz7kf4vm2rjbh8dy5sg1pk3e";

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

TEST_CASE("each token has a variable of its own, and the file goes before it",
          "[common][util][secret]") {
    const test::TemporaryFolder folder;
    const auto file = write(folder.path() / "token", kOfFile + "\r\n");
    const Variables variables{{util::kFarmTokenVariable, kOfFarm},
                              {util::kServerTokenVariable, kOfServer}};
    CHECK(util::find_token({}, util::kFarmTokenVariable) == kOfFarm);
    CHECK(util::find_token({}, util::kServerTokenVariable) == kOfServer);
    CHECK(util::find_token(file, util::kServerTokenVariable) == kOfFile);
    const Variables empty{{util::kFarmTokenVariable, ""}};
    CHECK(util::find_token({}, util::kFarmTokenVariable).empty());
    CHECK(util::find_token({}, util::kServerTokenVariable).empty());
}

TEST_CASE("the old name of both tokens is refused with the new ones, and its value never shown",
          "[common][util][secret]") {
    const test::TemporaryFolder folder;
    const auto file = write(folder.path() / "token", kOfFile);
    const Variables variables{{"TERRAVOX_TOKEN", "the-old-secret"},
                              {util::kFarmTokenVariable, kOfFarm}};
    for (const fs::path& from : {fs::path(), file}) {
        CHECK_THROWS_AS(util::find_token(from, util::kFarmTokenVariable), util::UsageError);
        CHECK_THROWS_WITH(util::find_token(from, util::kServerTokenVariable),
                          contains("TERRAVOX_TOKEN") && contains("TERRAVOX_FARM_TOKEN") &&
                              contains("TERRAVOX_SERVER_TOKEN") && !contains("the-old-secret"));
    }
    const Variables empty{{"TERRAVOX_TOKEN", ""}};
    CHECK(util::find_token({}, util::kFarmTokenVariable).empty());
}

TEST_CASE("tokens that people think of are refused with advice, and those of generators are not",
          "[common][util][secret]") {
    struct Case {
        const char* name;
        std::string text;
        const char* fault;  ///< "": it is a token
    };
    const auto c = GENERATE(values<Case>({
        {"hexadecimal", "9f86d081884c7d659a2feaa0c55ad015", ""},
        {"base64", "q7Zr0QmX1bKf9TqLw3VdYg/+8sUe2HkA==", ""},
        {"a UUID", "f81d4fae-7dec-11d0-a765-00a0c91e6bf6", ""},
        {"words with a random part", "the-token-of-this-farm-7f3a9c51e8", ""},
        {"longest", std::string(480, 'x') + kOfFile, ""},
        {"none", "", "0 characters"},
        {"short", "kv7r2mx9q4tz8wpd5hcnb3fj6gy1ks7", "31 characters"},
        {"too long", std::string(481, 'x') + kOfFile, "513 characters"},
        {"a farm and a year", "terravox-farm-2024", "18 characters"},
        {"words", "vivid-anchor-mosquito-plank-drizzle-hexagon", "no digit"},
        {"digits alone", "31415926535897932384626433832795028", "no letter"},
        {"a repeated word", "password1password1password1password1", "8 different characters"},
        {"one letter", std::string(40, 'a'), "1 different characters"},
        {"a blank", "9f86d081884c7d65 9a2feaa0c55ad015", "a character that is none"},
        {"a header of its own", "9f86d081884c7d659a2feaa0c55ad015\r\nX-Admin: yes",
         "a character that is none"},
        {"another alphabet", "9f86d081884c7d659a2feaa0c55a-caf\xc3\xa9",
         "a character that is none"},
        {"a zero", std::string("9f86d081884c7d659a2feaa0c55ad01\0", 32),
         "a character that is none"},
    }));
    DYNAMIC_SECTION(c.name) {
        if (*c.fault == '\0') {
            CHECK_NOTHROW(util::check_token(c.text, "try"));
            return;
        }
        CHECK_THROWS_AS(util::check_token(c.text, "try"), util::UsageError);
        CHECK_THROWS_WITH(util::check_token(c.text, "try"),
                          contains("try: the token has " + std::string(c.fault)) &&
                              contains("terravox farm token"));
        if (!c.text.empty())
            CHECK_THROWS_WITH(util::check_token(c.text, "try"), !contains(c.text));
    }
}

TEST_CASE("new tokens are long, of plain letters, and differ", "[common][util][secret]") {
    std::set<std::string> seen;
    for (int i = 0; i < 1000; ++i) {
        const std::string token = util::make_token();
        CHECK(token.size() == 32);
        CHECK(token.find_first_not_of("abcdefghjkmnpqrstuvwxyz123456789") == std::string::npos);
        CHECK_NOTHROW(util::check_token(token, "make"));
        seen.insert(token);
    }
    CHECK(seen.size() == 1000);
}

TEST_CASE("an unusable token is reported with its origin", "[common][util][secret]") {
    const test::TemporaryFolder folder;
    const Variables variables{{util::kFarmTokenVariable, "too short"}};
    using fs::perms;
    constexpr auto kOwner = perms::owner_read | perms::owner_write;
    struct Case {
        const char* name;
        std::string text;
        perms mode;
        const char* why;
    };
    for (const Case& c : {Case{"group-reads", kOfFile, kOwner | perms::group_read, "chmod 600"},
                          Case{"others-read", kOfFile, kOwner | perms::others_read, "chmod 600"},
                          Case{"others-write", kOfFile, kOwner | perms::others_write, "chmod 600"},
                          Case{"empty", "\n", kOwner, "0 characters"},
                          Case{"large", std::string(5000, 'x'), kOwner, "longer than 4096"}}) {
        INFO(c.name);
        const auto file = write(folder.path() / c.name, c.text, c.mode);
        CHECK_THROWS_WITH(util::find_token(file, util::kFarmTokenVariable),
                          contains(c.why) && contains(file.string()));
    }
    CHECK_THROWS_WITH(util::find_token(folder.path() / "absent", util::kFarmTokenVariable),
                      contains("absent: No such file"));
    CHECK_THROWS_WITH(util::find_token(folder.path(), util::kFarmTokenVariable),
                      contains("folder"));
    CHECK_THROWS_WITH(util::find_token({}, util::kFarmTokenVariable),
                      contains("TERRAVOX_FARM_TOKEN: the token has 9 characters"));
}

TEST_CASE("a group may read what systemd hands to a service, and nothing else",
          "[common][util][secret]") {
    const test::TemporaryFolder folder;
    const test::TemporaryFolder elsewhere;
    const auto group_reads = fs::perms::owner_read | fs::perms::group_read;
    const auto credential = write(folder.path() / "token", kOfFile, group_reads);
    const auto other = write(elsewhere.path() / "token", kOfFile, group_reads);
    const auto shown =
        write(folder.path() / "shown", kOfFile, group_reads | fs::perms::others_read);
    const auto below = folder.path() / ".." / elsewhere.path().filename() / "token";
    const auto read = [](const fs::path& file) {
        return util::find_token(file, util::kFarmTokenVariable);
    };
    CHECK_THROWS_WITH(read(credential), contains("chmod 600"));
    const Variables variables{{"CREDENTIALS_DIRECTORY", folder.path().string()}};
    CHECK(read(credential) == kOfFile);
    for (const fs::path& file : {other, shown, below}) {
        INFO(file);
        CHECK_THROWS_WITH(read(file), contains("chmod 600"));
    }
    CHECK(util::find_credential("token") == credential);
    CHECK(util::find_credential("absent").empty());
}

TEST_CASE("a program that is no service of systemd has no credentials", "[common][util][secret]") {
    const Variables variables{};
    CHECK(util::find_credential("token").empty());
}
