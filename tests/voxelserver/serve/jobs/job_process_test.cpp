#include "voxelserver/serve/jobs/job_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <thread>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/voxelserver/serve/jobs/script.hpp"

using namespace terravox;

namespace {

constexpr std::uint64_t kMax_bytes = 100'000;

int find_status(jobs::JobProcess& process) {
    std::optional<int> status;
    REQUIRE(test::eventually([&] {
        status = process.look();
        return status.has_value();
    }));
    return *status;
}

}  // namespace

TEST_CASE(
    "a process has its folder, its words, and neither the server's secrets nor its open files",
    "[voxelserver][jobs]") {
    const test::Script script(R"(pwd; echo "$#:$2"; ls /proc/self/fd | wc -l
        echo "<$TERRAVOX_SERVER_TOKEN$TERRAVOX_SERVER_ORIGIN$http_proxy$HTTPS_PROXY$no_proxy>" >&2
        echo "$TMPDIR"; exit 3)");
    const test::TemporaryFolder folder;
    const int open_file = ::open("/dev/null", O_RDONLY);  // without O_CLOEXEC
    constexpr std::array kWithheld{"TERRAVOX_SERVER_TOKEN", "TERRAVOX_SERVER_ORIGIN", "http_proxy",
                                   "HTTPS_PROXY", "no_proxy"};
    for (const char* name : kWithheld)
        ::setenv(name, "of the server", 1);
    jobs::JobProcess process(
        {script.file(), {"a", "b c; $(exit)"}, folder.path(), {{"X", "y"}}, kMax_bytes});
    for (const char* name : kWithheld)
        ::unsetenv(name);
    CHECK(find_status(process) == 3);
    ::close(open_file);
    const std::string path = folder.path().string();
    // The open files are those of `ls`: input, output, errors and the folder.
    CHECK(process.said() == path + "\n2:b c; $(exit)\n4\n<>\n" + path + "\n");
}

TEST_CASE("a process that somebody else has waited for has ended", "[voxelserver][jobs]") {
    const test::Script script("exit 0");
    const test::TemporaryFolder folder;
    const auto before = ::signal(SIGCHLD, SIG_IGN);
    jobs::JobProcess process({script.file(), {}, folder.path(), {}, kMax_bytes});
    CHECK(find_status(process) == 127);
    ::signal(SIGCHLD, before);
}

TEST_CASE("a process cannot write more than it may", "[voxelserver][jobs]") {
    const test::Script script("head -c 300000 /dev/zero > big || exit 9; exit 0");
    const test::TemporaryFolder folder;
    jobs::JobProcess process({script.file(), {}, folder.path(), {}, kMax_bytes});
    CHECK(find_status(process) == 9);
    CHECK(std::filesystem::file_size(folder.path() / "big") <= kMax_bytes);
}

TEST_CASE("a process ends with the thread that has started it", "[voxelserver][jobs]") {
    const test::Script script(
        "trap 'echo ended > \"$1\"; exit' TERM; echo $$ > \"$1\";"
        " while :; do sleep 0.05; done");
    const test::TemporaryFolder folder;
    std::unique_ptr<jobs::JobProcess> process;
    std::thread([&] {
        process = std::make_unique<jobs::JobProcess>(jobs::ProcessStart{
            script.file(), {script.note().string()}, folder.path(), {}, kMax_bytes});
        CHECK(test::eventually([&] { return !script.noted().empty(); }));
    }).join();
    CHECK(test::eventually([&] { return script.noted() == "ended\n"; }));
}

TEST_CASE("a process is nicer than the server, however nice that is", "[voxelserver][jobs]") {
    const int more = GENERATE(0, 3, 15);
    const test::Script script("nice");
    const test::TemporaryFolder folder;
    // Linux keeps the niceness of each thread by itself.
    std::thread([&] {
        const int own = ::getpriority(PRIO_PROCESS, 0) + more;
        CHECK(::setpriority(PRIO_PROCESS, 0, own) == 0);
        jobs::JobProcess process({script.file(), {}, folder.path(), {}, kMax_bytes});
        CHECK(find_status(process) == 0);
        CHECK(process.said() == std::to_string(std::min(own + 10, 19)) + "\n");
    }).join();
}

TEST_CASE("what it says is kept to some kilobytes, and read", "[voxelserver][jobs]") {
    const test::Script script(
        "i=0; while [ $i -lt 2000 ]; do echo \"line $i\" >&2;"
        " i=$((i + 1)); done");
    const test::TemporaryFolder folder;
    jobs::JobProcess process({script.file(), {}, folder.path(), {}, kMax_bytes});
    CHECK(find_status(process) == 0);
    CHECK(process.said().size() <= 4096);
    CHECK(process.said().ends_with("line 1999\n"));
    CHECK(jobs::progress_in("") == std::nullopt);
    CHECK(jobs::progress_in("  7 %  tile 3 of 44  1.00 Mray/s\n 45 %  tile 20 of 44") == 0.45);
    CHECK(jobs::progress_in("100 %  tile 44 of 44") == 1);
    CHECK(jobs::progress_in("999999999999 %  tile 44 of 44") == 1);
    CHECK(jobs::reason_in("  7 %  tile 3\nterravox: no room\n") == "no room");
    CHECK(jobs::reason_in("\n\n").empty());
    CHECK(jobs::reason_in("terravox: no \x1b[31mred\r world\n") == "no \\x1b[31mred\\r world");
    CHECK(jobs::reason_in(std::string(4000, 'x')) == std::string(300, 'x'));
}
