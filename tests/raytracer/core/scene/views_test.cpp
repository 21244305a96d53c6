#include "raytracer/core/scene/views.hpp"

#include <fstream>
#include <map>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::TemporaryFolder;

namespace {

const std::filesystem::path kConfig = std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config";

std::filesystem::path write(const TemporaryFolder& folder, const std::string& name,
                            const std::string& text) {
    std::ofstream(folder.path() / name) << text;
    return folder.path() / name;
}

const char* const kTwo = R"(
version = 1
[[view]]
name = "High Tower"
aliases = ["Škofja Loka", "the_top"]
[view.camera]
space = "voxel"
position = [1, 2, 3]
target = [4, 5, 6]
fov_deg = 20
[view.sun]
time_h = 7
[[view]]
name = "Low Bridge"
)";

}  // namespace

TEST_CASE("names are compared without case, and with any blank between words",
          "[raytracer][views]") {
    CHECK(scene::folded("Bled  Island") == scene::folded("bled-island"));
    CHECK(scene::folded(" BLED_island ") == "bled island");
    CHECK(scene::folded("KÖLN ČŠŽ ŽABA Đ") == scene::folded("köln čšž žaba đ"));
    CHECK(scene::folded("Ÿ × ÷") == scene::folded("Ÿ × ÷"));
    CHECK(scene::folded("\xC3") == "\xC3");  // cut off: as it is
    CHECK(scene::folded(" - ").empty());
    CHECK(scene::near_names("bled iland", {"Piran", "Bled island", "Bled castle"}) ==
          std::vector<std::string>{"Bled island"});
    CHECK(scene::near_names("castle", {"Piran", "Bled castle"}) ==
          std::vector<std::string>{"Bled castle"});
    CHECK(scene::near_names("", {"Piran"}).empty());
    CHECK(scene::near_names(std::string(100'000, 'x'), {"Piran"}).empty());
}

TEST_CASE("a view is found by name or alias", "[raytracer][views]") {
    const TemporaryFolder folder;
    write(folder, "views.toml", kTwo);
    for (const char* look :
         {"High Tower", "high tower", "HIGH-TOWER", "škofja loka", "ŠKOFJA_LOKA", "The Top"}) {
        INFO(look);
        CHECK(scene::find_view(look, folder.path()).name == "High Tower");
    }
    CHECK_THROWS_WITH(
        scene::find_view("high towr", folder.path()),
        contains("camera.look = 'high towr' names no view; did you mean High Tower?"));
    CHECK_THROWS_WITH(scene::find_view("Atlantis", folder.path()),
                      contains("allowed: High Tower, Low Bridge"));
    CHECK_THROWS_AS(scene::find_view("Atlantis", folder.path()), util::UsageError);
    CHECK_THROWS_WITH(scene::find_view("Atlantis", folder.path() / "none"),
                      contains("there is none in"));
    const auto one = write(folder, "one.toml", "[[view]]\nname = \"low bridge\"");
    CHECK(scene::find_view(one.string(), folder.path()).name == "low bridge");
    CHECK_THROWS_WITH(scene::find_view("Low Bridge", folder.path()), contains("names two views") &&
                                                                         contains("one.toml") &&
                                                                         contains("views.toml"));
    CHECK_THROWS_WITH(scene::find_view((folder.path() / "views.toml").string(), folder.path()),
                      contains("holds 2 views; allowed: a file with one"));
    CHECK_THROWS_WITH(scene::find_view((folder.path() / "absent.toml").string(), folder.path()),
                      contains("absent.toml"));
}

TEST_CASE("a scene comes out of defaults, view, file and flags, the later over the earlier",
          "[raytracer][views]") {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder.path() / "views");
    std::ofstream(folder.path() / "views/a.toml") << kTwo;
    const auto views = folder.path() / "views";
    const auto file =
        write(folder, "scene.toml",
              "[camera]\nlook = \"low bridge\"\nfov_deg = 30\n[sun]\ndate = \"2020-01-01\"");

    const scene::Scene by_flag =
        scene::compose_scene({scene::fields_layer({{"camera.look", "high tower"}})}, views);
    CHECK(by_flag.camera.position == std::array<double, 3>{1, 2, 3});
    CHECK(by_flag.camera.fov_deg == 20);
    CHECK(by_flag.sun.time_h == 7);
    CHECK(by_flag.quality.samples == scene::Scene{}.quality.samples);

    const scene::Scene by_file = scene::compose_scene({scene::file_layer(file)}, views);
    CHECK_FALSE(by_file.camera.position);

    const scene::Scene all = scene::compose_scene(
        {scene::file_layer(file),
         scene::fields_layer({{"camera.look", "high tower"}, {"sun.time_h", "9"}})},
        views);
    CHECK(all.camera.position ==
          std::array<double, 3>{1, 2, 3});  // the flag's view, not the file's
    CHECK(all.camera.fov_deg == 30);        // the file over the view
    CHECK(all.sun.time_h == 9);             // the flag over the view
    CHECK(all.sun.date == "2020-01-01");

    const scene::Scene none = scene::compose_scene({scene::file_layer({}), scene::fields_layer({})},
                                                   folder.path() / "absent");
    CHECK(scene::to_toml(none) == scene::to_toml(scene::Scene{}));
    CHECK_THROWS_WITH(
        scene::compose_scene({scene::fields_layer({{"camera.look", "nowhere"}})}, views),
        contains("names no view"));
    // What is written down says the same again.
    CHECK(scene::to_toml(scene::compose_scene(
              {scene::file_layer(write(folder, "saved.toml", scene::to_toml(all)))}, views)) ==
          scene::to_toml(all));
}

TEST_CASE("fields that a file or a view states are known, whatever their values",
          "[raytracer][views]") {
    const TemporaryFolder folder;
    write(folder, "two.toml", kTwo);
    const TemporaryFolder elsewhere;
    const auto file = write(elsewhere, "scene.toml", "version = 1\n[sun]\ntime_h = 16\nsize = 1\n");
    using Paths = std::vector<std::string>;
    CHECK(scene::stated_fields({}, "", folder.path()).empty());
    CHECK(scene::stated_fields(file, "") == Paths{"sun.size", "sun.time_h"});
    CHECK(
        scene::stated_fields({}, "high tower", folder.path()) ==
        Paths{"camera.fov_deg", "camera.position", "camera.space", "camera.target", "sun.time_h"});
}

TEST_CASE("a file of views that cannot be is refused, naming file, view and field",
          "[raytracer][views]") {
    struct Case {
        const char* name;
        std::string text;
        std::string said;
    };
    const auto c = GENERATE(values<Case>({
        {"no name", "[[view]]\ntitle = \"x\"", "name = nothing; allowed: text in quotes"},
        {"an empty name", "[[view]]\nname = \" \"", "name = no name"},
        {"aliases that are text", "[[view]]\nname = \"a\"\naliases = \"b\"",
         "view 'a': aliases = 'b'"},
        {"an unknown field", "[[view]]\nname = \"a\"\n[view.camera]\nfov = 3",
         "view 'a': unknown field 'camera.fov'"},
        {"a field out of range", "[[view]]\nname = \"a\"\n[view.sun]\ntime_h = 25",
         "view 'a': sun.time_h = 25; allowed: 0 to 24"},
        {"a view upon a view", "[[view]]\nname = \"a\"\n[view.camera]\nlook = \"b\"",
         "view 'a': camera.look = 'b'; allowed: none"},
        {"a view that is a value", "view = 3", "unknown field 'view'"},
        {"another field", "views = []", "unknown field 'views'"},
        {"another version", "version = 2", "version = 2; allowed: 1"},
        {"no TOML", "[[view", "line 1"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = write(folder, "bad.toml", c.text);
        CHECK_THROWS_AS(scene::read_views(file), util::UsageError);
        CHECK_THROWS_WITH(scene::read_views(file), contains(file.string()) && contains(c.said));
        CHECK_THROWS_AS(scene::find_view("a", folder.path()), util::UsageError);
    }
}

TEST_CASE("the shipped views are distinguishable, have areas, and cameras that can be placed",
          "[raytracer][views]") {
    const auto views = scene::read_view_folder(kConfig / "views");
    CHECK(views.size() >= 12);
    std::map<std::string, std::string> seen;
    for (const scene::NamedView& view : views) {
        INFO(view.name << " in " << view.file);
        std::vector<std::string> names = view.aliases;
        names.push_back(view.name);
        for (const auto& name : names) {
            INFO(name);
            CHECK(seen.emplace(scene::folded(name), view.name).second);
            CHECK(scene::find_view(name, kConfig / "views").name == view.name);
        }
        CHECK_FALSE(view.title.empty());
        if (!view.area.empty())
            CHECK(std::filesystem::exists(kConfig / "areas" / (view.area + ".toml")));
        const scene::Scene scene = scene::compose_scene(
            {scene::fields_layer({{"camera.look", view.name}})}, kConfig / "views");
        if (view.name == "plain") {  // a look, which any camera may have
            CHECK(scene.world.plane == "none");
            continue;
        }
        REQUIRE((scene.camera.position && scene.camera.target));
        voxel::WorldInfo world;
        const auto crs = geo::Crs::from_text(
            scene.camera.space == core::CoordinateSpace::kCrs ? "EPSG:3794" : "EPSG:3857");
        world.crs = crs.name();
        world.crs_wkt = crs.wkt();
        const scene::Camera camera = scene::make_camera(scene, world, {{0, 0, 0}, {100, 100, 100}});
        CHECK(std::isfinite(core::length(camera.position())));
        // Within a few kilometres, looking down a little or straight.
        const core::Vec3 to = scene::to_voxels(*scene.camera.target, scene.camera.space, world) -
                              scene::to_voxels(*scene.camera.position, scene.camera.space, world);
        CHECK(core::length(to) > 100);
        CHECK(core::length(to) < 8000);
        CHECK(to.y < 400);
    }
}
