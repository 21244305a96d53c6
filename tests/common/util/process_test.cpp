#include "common/util/process.hpp"

#include <sys/wait.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using terravox::util::Error;
using terravox::util::find_program;
using terravox::util::Finished;
using terravox::util::Process;
using terravox::util::run_to_end;

TEST_CASE("a program's status and output are returned whole", "[common][util][process]") {
    const Finished done = run_to_end(
        {"bash", "-c",
         "head -c 300000 /dev/zero | tr '\\0' x; echo wrong >&2; echo more >&2; exit 3"});
    CHECK(done.status == 3);
    CHECK(done.out == std::string(300000, 'x'));
    CHECK(done.err == "wrong\nmore\n");
    CHECK(done.reason() == "wrong");
    CHECK(run_to_end({"bash", "-c", "kill -KILL $$"}).status == 128 + SIGKILL);
    CHECK(run_to_end({"pwd"}, "/").out == "/\n");
    CHECK(run_to_end({"cat"}).out.empty());  // nothing to read
    CHECK_THROWS_AS(run_to_end({"/nonexistent/program"}), Error);
    CHECK(find_program("sh") != "");
    CHECK(find_program("nonexistent program") == "");
}

TEST_CASE("a child is stopped, by force where need be, and does not outlive its owner",
          "[common][util][process]") {
    Process obeys({.command = {"sleep", "600"}});
    CHECK_FALSE(obeys.wait(std::chrono::milliseconds(1)).has_value());
    CHECK(obeys.stop() == 128 + SIGTERM);
    CHECK(obeys.stop() == 128 + SIGTERM);
    CHECK(obeys.wait(std::chrono::milliseconds(0)) == 128 + SIGTERM);
    // Once the marker is there it is deaf.
    const terravox::test::TemporaryFolder folder;
    const auto marker = folder.path() / "deaf";
    Process deaf({.command = {"bash", "-c", "trap '' TERM; > \"$1\"; while :; do sleep 0.05; done",
                              "bash", marker.string()}});
    for (int tries = 0; tries < 600 && !std::filesystem::exists(marker); ++tries)
        REQUIRE_FALSE(deaf.wait(std::chrono::milliseconds(100)).has_value());
    CHECK(deaf.stop(std::chrono::milliseconds(100)) == 128 + SIGKILL);
    Process ends({.command = {"bash", "-c", "exit 2"}});
    CHECK(ends.wait(std::chrono::seconds(30)) == 2);
    CHECK_THROWS_WITH(Process({.command = {"/nonexistent/program"}}),
                      "start /nonexistent/program: No such file or directory");
    CHECK_THROWS_WITH(Process({.command = {"nonexistent program"}}),
                      "start nonexistent program: No such file or directory");
    std::ofstream(folder.path() / "no program") << "x";
    std::filesystem::permissions(folder.path() / "no program", std::filesystem::perms::owner_all);
    CHECK_THROWS_AS(Process({.command = {(folder.path() / "no program").string()}}), Error);
}

TEST_CASE("a child's output goes to its log, from the start", "[common][util][process]") {
    const terravox::test::TemporaryFolder folder;
    const auto log = folder.path() / "log";
    std::ofstream(log) << "what was said before, at length";
    Process child({.command = {"bash", "-c", "echo out; echo err >&2"}, .log = log});
    CHECK(child.wait() == 0);
    std::ifstream in(log);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    CHECK(text == "out\nerr\n");
    CHECK_THROWS_AS(Process({.command = {"true"}, .log = folder.path() / "none" / "log"}), Error);
    std::filesystem::create_symlink("log", folder.path() / "link");
    CHECK_THROWS_AS(Process({.command = {"true"}, .log = folder.path() / "link"}), Error);
}

TEST_CASE("a child has the variables, the folder and the signals that it is given",
          "[common][util][process]") {
    const terravox::test::TemporaryFolder folder;
    const auto log = folder.path() / "log";
    // What this process ignores or blocks stays so in the child, unless that is confined.
    const bool is_confined = GENERATE(false, true);
    sigset_t blocked;
    sigset_t before;
    ::sigemptyset(&blocked);
    ::sigaddset(&blocked, SIGUSR1);
    ::pthread_sigmask(SIG_BLOCK, &blocked, &before);
    Process::Start start{.command = {"bash", "-c", "pwd; echo $A$B; kill -USR1 $$; exit 4"},
                         .folder = "/",
                         .environment = {{"A=a", "PATH=/usr/bin:/bin"}},
                         .log = log};
    if (is_confined)
        start.confinement = {1000};
    Process child(start);
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    CHECK(child.wait() == (is_confined ? 128 + SIGUSR1 : 4));
    std::ifstream in(log);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    CHECK(text == "/\na\n");
}

TEST_CASE("a child that is let go is not ended", "[common][util][process]") {
    Process child({.command = {"sleep", "600"}, .may_outlive = true});
    const pid_t id = child.id();
    child.detach();
    CHECK(child.stop() == 0);
    CHECK(::kill(id, 0) == 0);
    ::kill(id, SIGKILL);
    ::waitpid(id, nullptr, 0);
}
