#include "raytracer/farm/cluster/child.hpp"

#include <signal.h>

#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::cluster;

TEST_CASE("a program's status and output are returned whole", "[cluster][child]") {
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
    CHECK_THROWS_AS(run_to_end({"/nonexistent/program"}), util::Error);
}

TEST_CASE("a child is stopped, by force where need be, and does not outlive its owner",
          "[cluster][child]") {
    Child obeys({"sleep", "600"});
    CHECK_FALSE(obeys.wait(std::chrono::milliseconds(1)).has_value());
    CHECK(obeys.stop() == 128 + SIGTERM);
    CHECK(obeys.stop() == 128 + SIGTERM);
    CHECK(obeys.wait(std::chrono::milliseconds(0)) == 128 + SIGTERM);
    // Once the marker is there it is deaf.
    const terravox::test::TemporaryFolder folder;
    const auto marker = folder.path() / "deaf";
    Child deaf({"bash", "-c", "trap '' TERM; > \"$1\"; while :; do sleep 0.05; done", "bash",
                marker.string()});
    for (int tries = 0; tries < 600 && !std::filesystem::exists(marker); ++tries)
        REQUIRE_FALSE(deaf.wait(std::chrono::milliseconds(100)).has_value());
    CHECK(deaf.stop(std::chrono::milliseconds(100)) == 128 + SIGKILL);
    Child ends({"bash", "-c", "exit 2"});
    CHECK(ends.wait(std::chrono::seconds(30)) == 2);
    CHECK_THROWS_AS(Child({"/nonexistent/program"}), util::Error);
    std::ofstream(folder.path() / "no program") << "x";
    std::filesystem::permissions(folder.path() / "no program", std::filesystem::perms::owner_all);
    CHECK_THROWS_AS(Child({(folder.path() / "no program").string()}), util::Error);
}

TEST_CASE("a child's output goes to its log, from the start", "[cluster][child]") {
    const terravox::test::TemporaryFolder folder;
    const auto log = folder.path() / "log";
    std::ofstream(log) << "what was said before, at length";
    Child child({"bash", "-c", "echo out; echo err >&2"}, log);
    CHECK(child.wait(std::chrono::seconds(60)) == 0);
    std::ifstream in(log);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    CHECK(text == "out\nerr\n");
    CHECK_THROWS_AS(Child({"true"}, folder.path() / "none" / "log"), terravox::util::Error);
    std::filesystem::create_symlink("log", folder.path() / "link");
    CHECK_THROWS_AS(Child({"true"}, folder.path() / "link"), terravox::util::Error);
}
