#include "raytracer/farm/net/token.hpp"

#include <cstdlib>
#include <fstream>
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
namespace fs = std::filesystem;

namespace {

/// The variable for as long as this lives.
class Variable {
public:
    explicit Variable(const char* value) {
        value != nullptr ? ::setenv("TERRAVOX_FARM_TOKEN", value, 1)
                         : ::unsetenv("TERRAVOX_FARM_TOKEN");
    }
    ~Variable() { ::unsetenv("TERRAVOX_FARM_TOKEN"); }
};

fs::path write(const fs::path& path, const std::string& text,
               fs::perms perms = fs::perms::owner_read | fs::perms::owner_write) {
    std::ofstream(path, std::ios::binary) << text;
    fs::permissions(path, perms);
    return path;
}

}  // namespace

TEST_CASE("new tokens are long, of plain letters, and differ", "[common][net][token]") {
    std::set<std::string> seen;
    for (int i = 0; i < 100; ++i) {
        const std::string token = net::new_token();
        CHECK(token.size() == 32);
        CHECK(token.find_first_not_of("abcdefghjkmnpqrstuvwxyz123456789") == std::string::npos);
        seen.insert(token);
    }
    CHECK(seen.size() == 100);
}

TEST_CASE("a token comes from the file, else from the environment, else from nowhere",
          "[common][net][token]") {
    const test::TemporaryFolder folder;
    const std::string in_file = "kv7r2mx9q4tz8wpd5hcn", in_environment = "y3bw6fj8nq2xs5gm9tzk";
    const auto file = write(folder.path() / "token", in_file + "\r\n");
    {
        const Variable variable(in_environment.c_str());
        CHECK(net::find_token(file) == in_file);
        CHECK(net::find_token({}) == in_environment);
    }
    {
        const Variable variable("");
        CHECK(net::find_token({}).empty());
    }
    const Variable none(nullptr);
    CHECK(net::find_token({}).empty());
    const auto made = net::new_token();
    CHECK(net::find_token(write(folder.path() / "made", made + "\n")) == made);
}

TEST_CASE("an unusable token is reported with its origin", "[common][net][token]") {
    const test::TemporaryFolder folder;
    const auto good = std::string("p4zq9vd2xk7wm5tr8gjn\n");
    using fs::perms;
    constexpr auto kOwner = perms::owner_read | perms::owner_write;
    struct Case {
        const char* name;
        std::string text;
        perms mode;
        const char* why;
    };
    for (const Case& c :
         {Case{"group-reads", good, kOwner | perms::group_read, "chmod 600"},
          Case{"others-read", good, kOwner | perms::others_read, "chmod 600"},
          Case{"others-write", good, kOwner | perms::others_write, "chmod 600"},
          Case{"short", "fifteen letters\n", kOwner, "15 characters; allowed: at least 16"},
          Case{"empty", "", kOwner, "0 characters"},
          Case{"two-lines", "the first line of it\nand the second", kOwner, "one line"},
          Case{"large", std::string(5000, 'x'), kOwner, "longer than 4096"}}) {
        INFO(c.name);
        const auto file = write(folder.path() / c.name, c.text, c.mode);
        CHECK_THROWS_WITH(net::find_token(file), contains(c.why) && contains(file.string()));
    }
    CHECK_THROWS_WITH(net::find_token(folder.path() / "absent"), contains("absent: No such file"));
    CHECK_THROWS_WITH(net::find_token(folder.path()), contains("folder"));
    const Variable variable("too short");
    CHECK_THROWS_WITH(net::find_token({}),
                      contains("TERRAVOX_FARM_TOKEN") && contains("9 characters"));
}

TEST_CASE("a token that can be guessed is refused wherever it is from", "[common][net][token]") {
    const test::TemporaryFolder folder;
    const auto file = write(folder.path() / "weak", "terravox-farm-2024\n");
    CHECK_THROWS_AS(net::find_token(file), util::UsageError);
    CHECK_THROWS_WITH(net::find_token(file), contains("weak: the token can be guessed"));
    const Variable variable("passwordpassword");
    CHECK_THROWS_AS(net::find_token({}), util::UsageError);
}
