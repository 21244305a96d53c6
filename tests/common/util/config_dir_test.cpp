#include "common/util/folders.hpp"

#include <cstdlib>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;

TEST_CASE("the configuration is found next to the sources, or where TERRAVOX_CONFIG says",
          "[common][util][config_dir]") {
    const char* before = std::getenv("TERRAVOX_CONFIG");
    const std::string kept = before != nullptr ? before : "";
    const std::filesystem::path shipped = std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config";

    ::unsetenv("TERRAVOX_CONFIG");
    CHECK(std::filesystem::equivalent(util::config_dir(), shipped));
    ::setenv("TERRAVOX_CONFIG", shipped.c_str(), 1);
    CHECK(util::config_dir() == shipped);
    const test::TemporaryFolder empty;
    ::setenv("TERRAVOX_CONFIG", empty.path().c_str(), 1);
    CHECK_THROWS_AS(util::config_dir(), util::UsageError);
    CHECK_THROWS_WITH(util::config_dir(), test::contains(empty.path().string()));

    if (before != nullptr)
        ::setenv("TERRAVOX_CONFIG", kept.c_str(), 1);
    else
        ::unsetenv("TERRAVOX_CONFIG");
}
