#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

using namespace terravox;
using namespace terravox::procedural;
using terravox::test::contains;

TEST_CASE("settings out of range are refused by name, value and range", "[raytracer][generated]") {
    struct Case {
        const char* name;
        std::function<void(Settings&)> set;
        const char* message;
    };
    const auto c = GENERATE(values<Case>({
        {"water too high", [](Settings& s) { s.water_level = 4097; },
         "water_level = 4097; allowed: -4096 to 4096"},
        {"flat", [](Settings& s) { s.world_height = 7; }, "world_height = 7; allowed: 8 to 4096"},
        {"no octave", [](Settings& s) { s.harmonics = 0; }, "harmonics = 0; allowed: 1 to 16"},
        {"too fine", [](Settings& s) { s.frequency = 0.2; },
         "frequency = 0.2; allowed: 1e-05 to 0.1"},
        {"no number", [](Settings& s) { s.frequency = std::nan(""); }, "frequency = nan"},
        {"rougher and rougher", [](Settings& s) { s.smoothness = 1.5; },
         "smoothness = 1.5; allowed: 0 to 1"},
        {"voxels without size", [](Settings& s) { s.voxel_m = 0; },
         "voxel_m = 0; allowed: above 0, up to 1000"},
        {"voxels without end",
         [](Settings& s) { s.voxel_m = std::numeric_limits<double>::infinity(); }, "voxel_m = inf"},
    }));
    DYNAMIC_SECTION(c.name) {
        Settings settings;
        CHECK_NOTHROW(check(settings));
        c.set(settings);
        CHECK_THROWS_AS(check(settings), util::UsageError);
        CHECK_THROWS_WITH(check(settings), contains(c.message));
    }
}

TEST_CASE("flags suit a kind by their whole names", "[voxelserver][worlds]") {
    struct Case {
        const char* name;
        const char* suitable;
        std::vector<std::string> given;
        const char* said;  ///< part of the refusal; empty: none
    };
    const auto c = GENERATE(values<Case>({
        {"none given", "", {}, ""},
        {"all suit", "--crs --voxel", {"--voxel", "--crs"}, ""},
        {"one does not",
         "--crs --voxel",
         {"--crs", "--classes"},
         "--classes with noise; allowed: --crs --voxel"},
        {"the beginning of another", "--voxel-m", {"--voxel"}, "--voxel with noise"},
        {"none would", "", {"--voxel"}, "allowed: none such"},
    }));
    DYNAMIC_SECTION(c.name) {
        std::string message;
        try {
            worlds::check_flags("generated:1", "noise", c.suitable, c.given);
        } catch (const util::UsageError& e) {
            message = e.what();
        }
        CHECK(message.empty() == std::string(c.said).empty());
        CHECK_THAT(message, contains(c.said));
    }
}
