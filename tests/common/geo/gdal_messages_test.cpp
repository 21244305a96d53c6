#include <gdal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include "common/geo/gdal.hpp"
#include "common/geo/gdal_messages.hpp"
#include "tests/catch.hpp"
#include "tests/common/child_process.hpp"
#include "tests/common/emulated.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;

namespace {

constexpr rlim_t kFewBytes = 1 << 20;  // less than the process has already

}  // namespace

TEST_CASE("where GDAL would abort, the program ends with one line and exit code 1",
          "[common][geo]") {
    struct Case {
        const char* name;
        std::function<void()> work;
    };
    const auto out_of_memory = [] {
        CPLError(CE_Fatal, CPLE_OutOfMemory, "Out of memory allocating %d bytes.", 24);
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"while its messages are dropped",
         [=] {
             const geo::GdalErrorScope errors;
             out_of_memory();
         }},
        {"while its messages are printed",
         [=] {
             geo::start_gdal();
             out_of_memory();
         }},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::ChildEnd end = test::run_in_child(c.work);
        CHECK(WIFEXITED(end.status));
        CHECK(WEXITSTATUS(end.status) == 1);
        CHECK(end.error_output ==
              "terravox: GDAL cannot go on: Out of memory allocating 24 bytes.\n");
    }
}

TEST_CASE("where GDAL aborts after a message that memory is missing, the program ends with a line",
          "[common][geo]") {
    const auto fail = [](CPLErrorNum number) {
        CPLError(CE_Failure, number, "cannot allocate 2x8 bytes");
    };
    const test::ChildEnd told = test::run_in_child([=] {
        const geo::GdalErrorScope errors;
        fail(CPLE_OutOfMemory);
        std::abort();
    });
    CHECK(WIFEXITED(told.status));
    CHECK(WEXITSTATUS(told.status) == 1);
    CHECK(told.error_output == "terravox: GDAL cannot go on: out of memory\n");

    const test::ChildEnd gone_on = test::run_in_child([=] {
        const geo::GdalErrorScope errors;
        fail(CPLE_OutOfMemory);
    });
    CHECK(WEXITSTATUS(gone_on.status) == 0);
    CHECK(gone_on.error_output.empty());

    // Of other reasons nothing is known here: a debugger or a core file tells more.
    for (const CPLErrorNum before : {CPLE_AppDefined, CPLE_OutOfMemory}) {
        const test::ChildEnd aborted = test::run_in_child([=] {
            {
                const geo::GdalErrorScope errors;
                fail(before);
            }
            const geo::GdalErrorScope errors;
            fail(CPLE_AppDefined);
            std::abort();
        });
        CHECK(WIFSIGNALED(aborted.status));
        CHECK(WTERMSIG(aborted.status) == SIGABRT);
    }
}

// Of the sanitizers, their own memory would be refused, too.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("what GDAL needs to write a file is missing before it begins, not on the way",
          "[common][geo]") {
    if (test::emulated()) {
        WARN("not tried: the emulator would be without memory, too");
        return;
    }
    geo::check_memory_for_gdal();
    // On a thread of its own, as the test framework would catch the exception.
    const test::ChildEnd end = test::run_in_child([] {
        std::thread([] {
            const rlimit none_left{kFewBytes, kFewBytes};
            ::setrlimit(RLIMIT_AS, &none_left);
            geo::check_memory_for_gdal();
        }).join();
    });
    CHECK(WIFEXITED(end.status));
    CHECK(WEXITSTATUS(end.status) == 1);
    CHECK(end.error_output ==
          "terravox: out of memory; lower memory limits or a smaller task may help\n");
}
#endif

TEST_CASE("errors of GDAL that do not end the program are dropped or printed", "[common][geo]") {
    const auto fail = [] { CPLError(CE_Failure, CPLE_AppDefined, "a file is damaged"); };
    CHECK(test::run_in_child([=] {
              const geo::GdalErrorScope errors;
              fail();
          }).error_output.empty());
    const std::string printed = test::run_in_child([=] {
                                    geo::start_gdal();
                                    fail();
                                }).error_output;
    CHECK(printed.find("a file is damaged") != std::string::npos);
}

TEST_CASE("a full disk is told by GDAL's messages, not by libtiff's own", "[common][geo]") {
    const test::TemporaryFolder folder;
    const std::string path = folder.path() / "full.tif";
    const test::ChildEnd end = test::run_in_child([&] {
        geo::start_gdal();
        const geo::GdalErrorScope errors;
        // Writes fail with EFBIG then.
        const rlimit few{kFewBytes / 2, kFewBytes / 2};
        ::setrlimit(RLIMIT_FSIZE, &few);
        std::signal(SIGXFSZ, SIG_IGN);
        constexpr int kSide = 2000;
        std::string row(kSide, 'x');
        GDALDatasetH file = GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), kSide, kSide, 1,
                                       GDT_Byte, nullptr);
        CPLErr worst = file != nullptr ? CE_None : CE_Failure;
        for (int y = 0; y < kSide && file != nullptr; ++y)
            worst = std::max(worst, GDALRasterIO(GDALGetRasterBand(file, 1), GF_Write, 0, y, kSide,
                                                 1, row.data(), kSide, 1, GDT_Byte, 0, 0));
        if (file != nullptr)
            GDALClose(file);
        if (std::max(worst, CPLGetLastErrorType()) != CE_Failure)
            throw std::runtime_error("it was written");
    });
    CHECK(end.error_output.empty());
    CHECK(end.status == 0);
}

TEST_CASE("what a file says in a message of GDAL does not speak to the terminal", "[common][geo]") {
    const std::string printed =
        test::run_in_child([] {
            geo::start_gdal();
            CPLError(CE_Warning, CPLE_AppDefined, "%s",
                     "field 'a\x1b[2J\r\xe2\x80\xae\nERROR 1: forged' is too long");
        }).error_output;
    CHECK(printed == "Warning 1: field 'a\\x1b[2J\\r\\u202e\\nERROR 1: forged' is too long\n");
}

TEST_CASE("GDAL keeps no more of images than its limit", "[common][geo][gdal]") {
    if (std::getenv("GDAL_CACHEMAX") != nullptr)
        return;  // the user's own limit takes precedence
    geo::start_gdal();
    geo::start_gdal();
    CHECK(GDALGetCacheMax64() == geo::kGdalCache_bytes);
    CHECK(GDALGetDriverByName("GTiff") != nullptr);
}
