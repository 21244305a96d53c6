#include "voxelserver/make/worlds/kind/world_options.hpp"

#include <vector>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using terravox::test::contains;

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
