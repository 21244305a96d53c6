#include "voxelserver/serve/module/load_module.hpp"

#include <dlfcn.h>

#include <fstream>
#include <new>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kImageBytes = std::size_t{8} << 20;

/// What main() would make of it: the exit code and the message; 0 when nothing is thrown.
struct Outcome {
    int code = 0;
    bool usage = false;
    std::string message;
};

template <class Body>
Outcome outcome(const Body& body) {
    try {
        body();
        return {};
    } catch (const util::UsageError& e) {
        return {static_cast<int>(e.exit_code()), true, e.what()};
    } catch (const util::Error& e) {
        return {static_cast<int>(e.exit_code()), false, e.what()};
    }
}

}  // namespace

TEST_CASE("errors come out of the module with their types", "[voxelserver][module]") {
    struct Case {
        const char* name;
        const char* file;
        const char* classes;
        int code;
        bool usage;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"no file", "", "asprs", 2, true, "no file or folder given"},
        {"a file that is not there", "none.laz", "asprs", 2, true, "none.laz"},
        {"no such class table", "text.laz", "none", 2, true, "none"},
        {"no point cloud", "text.laz", "asprs", 1, false, "text.laz"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        std::ofstream(folder.path() / "text.laz") << std::string(500, 'x');
        voxelize::LidarWorldOptions options;
        options.classes = c.classes;
        if (*c.file != '\0')
            options.files = {folder.path() / c.file};
        util::StageTimes times;
        const Outcome out =
            outcome([&] { (void)module::open_lidar_world(options, times, kImageBytes); });
        CHECK(out.code == c.code);
        CHECK(out.usage == c.usage);
        CHECK(out.message.find(c.said) != std::string::npos);
    }
}

TEST_CASE("a module of another version is refused", "[voxelserver][module]") {
    auto* open = reinterpret_cast<module::OpenLidarWorld*>(
        dlsym(util::open_module("terravox-worlds.so", "worlds module"), module::kOpenLidarWorld));
    REQUIRE(open != nullptr);
    util::StageTimes times;
    const Outcome out = outcome([&] { delete open("0.0.0-other", {}, times, 0); });
    CHECK(out.code == 1);
    CHECK(out.message.find("0.0.0-other") != std::string::npos);
}

TEST_CASE("the module gives away one name only", "[voxelserver][module]") {
    void* library = util::open_module("terravox-worlds.so", "worlds module");
    CHECK(dlsym(library, module::kOpenLidarWorld) != nullptr);
    // The program has this function, too: each keeps to its own.
    CHECK(dlsym(library, "_ZN8terravox4util10config_dirEv") == nullptr);
    CHECK(dlsym(library, "laszip_open_reader") == nullptr);
}

TEST_CASE("a library next to the program is found once", "[common][util]") {
    CHECK(util::module_file("terravox-worlds.so") == module::worlds_module());
    CHECK(fs::is_regular_file(module::worlds_module()));
    CHECK(util::open_module("terravox-worlds.so", "worlds module") ==
          util::open_module("terravox-worlds.so", "worlds module"));
    const Outcome out =
        outcome([] { (void)util::open_module("terravox-none.so", "worlds module"); });
    CHECK(out.code == 1);
    CHECK(out.message.find("load the worlds module") == 0);
    CHECK(out.message.find("terravox-none.so") != std::string::npos);
}
