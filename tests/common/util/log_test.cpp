#include "common/util/log.hpp"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <functional>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"

using terravox::test::contains;

namespace {

/// All that is written to standard error meanwhile.
std::string written_by(const std::function<void()>& body) {
    const terravox::test::TemporaryFolder folder;
    const auto path = folder.path() / "stderr";
    const int before = ::dup(STDERR_FILENO);
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    REQUIRE((before >= 0 && file >= 0));
    std::fflush(stderr);
    ::dup2(file, STDERR_FILENO);
    body();
    std::fflush(stderr);
    ::dup2(before, STDERR_FILENO);
    ::close(before);
    ::close(file);
    return terravox::test::read_content(path);
}

}  // namespace

TEST_CASE("a message with untrusted text is one line without control characters",
          "[common][util][log]") {
    using terravox::util::LogFormat;
    const auto logger = spdlog::default_logger();
    struct Case {
        const char* name;
        LogFormat format;
        const char* shown;
    };
    for (const Case c :
         {Case{"text", LogFormat::kText, R"(worker \x1b[2Jx\n[error] forged\u009b Köln is lost)"},
          Case{"JSON", LogFormat::kJson,
               R"(worker \\x1b[2Jx\\n[error] forged\\u009b Köln is lost)"}}) {
        INFO(c.name);
        const std::string written = written_by([&] {
            terravox::util::set_up_log("info", c.format);
            terravox::util::log_error("worker {} is lost",
                                      "\x1b[2Jx\n[error] forged\xc2\x9b K\xc3\xb6ln");
        });
        CHECK_THAT(written, contains(c.shown));
        CHECK(std::count(written.begin(), written.end(), '\n') == 1);
        CHECK(written.find('\x1b') == std::string::npos);
        CHECK(written.find("\xc2\x9b") == std::string::npos);
    }
    spdlog::set_default_logger(logger);
}

TEST_CASE("a wrong level of the log is refused with those that are allowed",
          "[common][util][log]") {
    const auto before = spdlog::default_logger();
    for (const char* wrong : {"", "loud", "INFO", "warning"}) {
        INFO(wrong);
        CHECK_THROWS_AS(terravox::util::set_up_log(wrong), terravox::util::UsageError);
        CHECK_THROWS_WITH(terravox::util::set_up_log(wrong),
                          contains("'" + std::string(wrong) + "'") && contains("warn, error, off"));
    }
    spdlog::set_default_logger(before);
}

TEST_CASE("messages of a level are written from that level on", "[common][util][log]") {
    using namespace terravox;
    const auto before = spdlog::default_logger();
    const std::string written = written_by([] {
        util::set_up_log("warn");
        util::log_trace("{} to be left out", 1);
        util::log_debug("{} to be left out", 2);
        util::log_info("{} to be left out", 3);
        util::log_warn("{} of {:.1f} m", "a wall", 2.25);
        util::log_error("{} lost", std::string("two workers"));
        util::log_message(util::LogLevel::kCritical, "the end");
    });
    CHECK(written == "[warning] a wall of 2.2 m\n[error] two workers lost\n[critical] the end\n");
    CHECK(util::is_logged(util::LogLevel::kWarning));
    CHECK_FALSE(util::is_logged(util::LogLevel::kInfo));
    spdlog::set_default_logger(before);
}

TEST_CASE("a message that cannot be formatted is replaced by a line", "[common][util][log]") {
    using namespace terravox;
    const auto before = spdlog::default_logger();
    const std::string written = written_by([] {
        util::set_up_log("info");
        const std::string text = "of no number";
        util::write_log(util::LogLevel::kError, "{:d}", fmt::make_format_args(text));
    });
    CHECK(written == "[error] a message of the log could not be written\n");
    spdlog::set_default_logger(before);
}

TEST_CASE("what many files share is said of the first, and of the others in one line",
          "[common][util][log]") {
    using namespace terravox;
    const auto before = spdlog::default_logger();
    util::say_shared_warnings();
    const std::string written = written_by([] {
        util::set_up_log("info");
        for (const char* file : {"a.laz", "b.laz", "a.laz", "c.laz", "b.laz"})
            util::warn_of_file(file, "holds no points", file == std::string("a.laz") ? "0" : "");
        util::warn_of_file("d.laz", "has strays");
        util::warn_of_file("d.laz", "has strays");
        util::say_shared_warnings();
        util::say_shared_warnings();
        util::warn_of_file("e.laz", "has strays");
    });
    CHECK(written ==
          "[warning] a.laz: holds no points (0)\n[warning] d.laz: has strays\n"
          "[warning] 2 other files, such as b.laz: holds no points\n"
          "[warning] e.laz: has strays\n");
    util::say_shared_warnings();
    spdlog::set_default_logger(before);
}
