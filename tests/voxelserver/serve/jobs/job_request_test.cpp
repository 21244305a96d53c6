#include "voxelserver/serve/jobs/job_queue.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/small_stack.hpp"

using namespace terravox;

namespace {

voxel::WorldInfo placed_world() {
    voxel::WorldInfo world;
    world.bounds = {{0, 0, -1000}, {1000, 100, 0}};
    world.voxel_m = 0.5;
    world.crs = "EPSG:3794";
    world.crs_units_per_voxel = 0.5;
    return world;
}

std::vector<std::string> list_words(const std::string& body) {
    return jobs::read_job_request(body, placed_world(), {}).words;
}

}  // namespace

TEST_CASE("a request becomes options of the command, each a word of its own",
          "[voxelserver][jobs]") {
    struct Case {
        const char* name;
        const char* body;
        std::vector<std::string> words;
    };
    const auto c = GENERATE(values<Case>({
        {"terrain",
         R"({"kind": "terrain", "area": [10, 20.5, 30, 1e2], "resolution_m": 2})",
         {"--area=10,20.5,30,100", "--resolution=2"}},
        {"a day",
         R"({"kind": "sun", "area": [-1, 0, 1, 1], "date": "2026-06-21", "step_min": 30,
             "zone": "America/Port-au-Prince", "surface": "ground"})",
         {"--area=-1,0,1,1", "--resolution=0.5", "--surface=ground", "--date=2026-06-21",
          "--step-min=30", "--zone=America/Port-au-Prince"}},
        {"months",
         R"({"kind": "sun", "area": [0, 0, 1, 1], "from": "2026-01-01", "to": "2026-12-31",
             "monthly": true})",
         {"--area=0,0,1,1", "--resolution=0.5", "--from=2026-01-01", "--to=2026-12-31",
          "--monthly"}},
        {"sky",
         R"({"kind": "sky", "area": [0, 0, 1, 1], "directions": 64, "range_m": 50.5})",
         {"--area=0,0,1,1", "--resolution=0.5", "--directions=64", "--range-m=50.5"}},
        {"grass that blocks",
         R"({"kind": "sky", "area": [0, 0, 1, 1], "surface": "ground", "thin_blocks": true})",
         {"--area=0,0,1,1", "--resolution=0.5", "--surface=ground", "--thin-blocks=yes"}},
        {"energy",
         R"({"kind": "energy", "area": [0, 0, 1, 1], "linke": 3.5})",
         {"--area=0,0,1,1", "--resolution=0.5", "--linke=3.5"}},
        {"sight",
         R"({"kind": "sight", "area": [0, 0, 1, 1], "observers": [[0.5, 0.25, 1.6]],
             "target_m": 2})",
         {"--area=0,0,1,1", "--resolution=0.5", "--observer=0.5,0.25,+1.6", "--target-height=2"}},
        {"clearance",
         R"({"kind": "clearance", "area": [0, 0, 1, 1]})",
         {"--area=0,0,1,1", "--resolution=0.5"}},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(list_words(c.body) == c.words);
    }
}

TEST_CASE("values in many brackets are refused on the stack of a web server's thread",
          "[voxelserver][jobs]") {
    const std::string deep = std::string(2000, '[') + std::string(2000, ']');
    for (const char* name :
         {"kind", "area", "resolution_m", "surface", "zone", "date", "monthly"}) {
        const std::string kind =
            std::string(name) == "kind" ? "" : R"("kind": "sun", "area": [0, 0, 1, 1], )";
        const std::string body = "{" + kind + "\"" + name + "\": " + deep + "}";
        std::string message;
        test::on_small_stack([&] {
            try {
                (void)list_words(body);
            } catch (const util::UsageError& e) {
                message = e.what();
            }
        });
        INFO(name);
        CHECK(!message.empty());
        CHECK(message.size() < 300);
    }
}

TEST_CASE("very small numbers stay numbers", "[voxelserver][jobs]") {
    for (const std::string& word : list_words(R"({"kind": "sky", "area": [1e-60, 0, 1, 1]})"))
        CHECK(word.find("nan") == std::string::npos);
}

TEST_CASE("what is no request is refused, and says what is allowed", "[voxelserver][jobs]") {
    struct Case {
        const char* name;
        const char* body;
        const char* part;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing", "", "JSON object"},
        {"a list", "[]", "JSON object"},
        {"cut short", R"({"kind": "sky")", "JSON object"},
        {"no kind", R"({"area": [0, 0, 1, 1]})", "no 'kind'"},
        {"another kind", R"({"kind": "noise", "area": [0, 0, 1, 1]})", "terrain, sky"},
        {"an option as a kind", R"({"kind": "--help", "area": [0, 0, 1, 1]})", "terrain, sky"},
        {"no area", R"({"kind": "sky"})", "no 'area'"},
        {"three sides", R"({"kind": "sky", "area": [0, 0, 1]})", "no 'area'"},
        {"words", R"({"kind": "sky", "area": ["0", 0, 1, 1]})", "'area' is \"0\""},
        {"far away", R"({"kind": "sky", "area": [0, 0, 1, 1e30]})", "'area' is 1e+30"},
        {"inside out", R"({"kind": "sky", "area": [1, 0, 0, 1]})", "empty"},
        {"too many cells", R"({"kind": "sky", "area": [0, 0, 1001, 1001]})", "up to 4000000"},
        {"too long", R"({"kind": "sky", "area": [0, 0, 40000, 1]})", "cells"},
        {"finer than voxels", R"({"kind": "sky", "area": [0, 0, 1, 1], "resolution_m": 0.1})",
         "0.5 to"},
        {"another name", R"({"kind": "sky", "area": [0, 0, 1, 1], "o": "/etc/passwd"})", "'o' of"},
        {"of another kind", R"({"kind": "sky", "area": [0, 0, 1, 1], "linke": 3})", "'linke' of"},
        {"a surface of the ground alone",
         R"({"kind": "clearance", "area": [0, 0, 1, 1], "surface": "top"})", "'surface' of"},
        {"a file", R"({"kind": "energy", "area": [0, 0, 1, 1], "weather": "/etc/passwd"})",
         "'weather' of"},
        {"a day that is none", R"({"kind": "sun", "area": [0, 0, 1, 1], "date": "21. 6. 2026"})",
         "YYYY-MM-DD"},
        {"a day and an option",
         R"({"kind": "sun", "area": [0, 0, 1, 1], "date": "2026-06-21 --report=a"})", "YYYY-MM-DD"},
        {"a zone that is a path",
         R"({"kind": "sun", "area": [0, 0, 1, 1], "zone": "../../etc/passwd"})", "'zone' is"},
        {"a zone that is absolute", R"({"kind": "sun", "area": [0, 0, 1, 1], "zone": "/etc/x"})",
         "'zone' is"},
        {"a zone with a newline", R"({"kind": "sun", "area": [0, 0, 1, 1], "zone": "a\nb"})",
         "'zone' is"},
        {"half a direction", R"({"kind": "sky", "area": [0, 0, 1, 1], "directions": 64.5})",
         "whole"},
        {"too many directions", R"({"kind": "sky", "area": [0, 0, 1, 1], "directions": 4096})",
         "16 to 1024"},
        {"no observer", R"({"kind": "sight", "area": [0, 0, 1, 1]})", "no 'observers'"},
        {"an observer of two", R"({"kind": "sight", "area": [0, 0, 1, 1], "observers": [[0, 1]]})",
         "three numbers"},
        {"a word for a surface", R"({"kind": "sky", "area": [0, 0, 1, 1], "surface": "-o"})",
         "top, ground"},
        {"grass of heights", R"({"kind": "terrain", "area": [0, 0, 1, 1], "thin_blocks": true})",
         "'thin_blocks'"},
        {"yes", R"({"kind": "sun", "area": [0, 0, 1, 1], "monthly": "yes"})", "true, false"},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK_THROWS_AS(list_words(c.body), util::UsageError);
        CHECK_THROWS_WITH(list_words(c.body), test::contains(c.part));
    }
}

TEST_CASE("cells are counted in a world without a CRS, too", "[voxelserver][jobs]") {
    voxel::WorldInfo world = placed_world();
    world.crs.clear();
    const auto cells = [&](const char* body) {
        return jobs::read_job_request(body, world, {}).cells;
    };
    CHECK(cells(R"({"kind": "terrain", "area": [0, 0, 100, 50]})") == 101 * 51);
    CHECK(cells(R"({"kind": "terrain", "area": [0, 0, 100, 50], "resolution_m": 5})") == 11 * 6);
}
