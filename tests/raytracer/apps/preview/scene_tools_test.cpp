#include <algorithm>
#include <sstream>

#include "common/util/error.hpp"
#include "raytracer/apps/preview/camera_path.hpp"
#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/final_render.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using terravox::test::contains;

namespace {

scene::Scene changed() {
    scene::Scene out;
    out.camera.space = core::CoordinateSpace::kVoxel;
    out.camera.position = {{-1.5, 80.25, 1e6}};
    out.camera.target = {{50, -10, 50.125}};
    out.camera.fov_deg = 33.3;
    out.sun.altitude_deg = -12.5;
    out.sun.azimuth_deg = 200;
    out.sun.zone = "Europe/Ljubljana";
    out.output.size_px = {333, 222};
    out.quality.shadows = false;
    out.quality.tile = {0, 5};
    out.quality.tile.px = scene::TileSize{}.px;
    out.quality.materials = "a folder/it's.toml";
    return out;
}

}  // namespace

TEST_CASE("fields as text set the same scene again", "[preview][scene]") {
    const scene::Scene scene = changed();
    scene::Scene again;
    for (const scene::FieldText& field : scene::changed_fields(scene, scene::Scene{})) {
        REQUIRE(field.text);
        scene::set_field(again, field.path, *field.text);
    }
    CHECK(again == scene);
    CHECK(scene::changed_fields(scene, scene).empty());
    const auto back = scene::changed_fields(scene::Scene{}, scene);
    CHECK(std::count_if(back.begin(), back.end(),
                        [](const scene::FieldText& f) { return !f.text; }) == 4);
}

TEST_CASE("the command line names what is not as usual, quoted for a shell", "[preview]") {
    const std::string line =
        preview::render_command_line(changed(), {"a world.laz", "--ortho", "p.tif"}, "out.png");
    CHECK(line.starts_with("terravox render 'a world.laz' --ortho p.tif "));
    CHECK_THAT(line, contains(" --camera-position=-1.5,80.25,1000000 "));
    CHECK_THAT(line, contains(" --sun-altitude-deg=-12.5 "));
    CHECK_THAT(line, contains(" --quality-shadows=no "));
    CHECK_THAT(line, contains(" --quality-materials='a folder/it'\\''s.toml' "));
    CHECK_THAT(line, !contains("--sky-"));
    CHECK(line.ends_with(" -o out.png"));
}

TEST_CASE("undo goes back step by step, redo forward; a new change forgets what was undone",
          "[preview]") {
    preview::SceneHistory history{scene::Scene{}};
    const auto at = [](double time_h) {
        scene::Scene out;
        out.sun.time_h = time_h;
        return out;
    };
    history.note(scene::Scene{});  // nothing has changed
    CHECK_FALSE(history.can_undo());
    for (const double t : {1.0, 2.0, 3.0})
        history.note(at(t));
    CHECK(history.undo().sun.time_h == 2);
    CHECK(history.undo().sun.time_h == 1);
    CHECK(history.redo().sun.time_h == 2);
    history.note(at(9));
    CHECK_FALSE(history.can_redo());
    CHECK(history.undo().sun.time_h == 2);
    CHECK(history.undo().sun.time_h == 1);
    CHECK(history.undo() == scene::Scene{});
    CHECK(history.undo() == scene::Scene{});
    for (std::size_t i = 0; i < 2 * preview::SceneHistory::kMax; ++i)
        history.note(at(static_cast<double>(i % 24) + 0.5));
    std::size_t steps = 0;
    while (history.can_undo()) {
        (void)history.undo();
        ++steps;
    }
    CHECK(steps == preview::SceneHistory::kMax - 1);
}

TEST_CASE("a camera path is an animation that goes through its keys", "[preview][animate]") {
    scene::Scene base;
    base.camera.space = core::CoordinateSpace::kVoxel;
    base.quality.samples = 7;
    const auto at = [&](double x, double time_h) {
        scene::Scene out = base;
        out.camera.position = {{x, 50, 0}};
        out.camera.target = {{x, 0, -50}};
        out.sun.time_h = time_h;
        return out;
    };
    preview::CameraPath path;
    CHECK_THROWS_AS(path.animation(base), util::UsageError);
    path.put(2, at(20, 12));
    path.put(0, at(0, 10));
    path.put(4, at(80, 14));
    path.put(2.001, at(30, 12));  // in the place of the one at 2 s
    REQUIRE(path.keys().size() == 3);
    CHECK(path.seconds() == 4);
    const animate::Animation film = path.animation(base);
    CHECK(film.frames() == 101);
    scene::Scene shared;
    film.apply_base(shared);
    CHECK(shared.quality.samples == 7);
    for (const preview::CameraPath::Key& key : path.keys()) {
        const scene::Scene scene = film.at(static_cast<int>(key.time_s * 25 + 0.5), shared);
        for (std::size_t i = 0; i < 3; ++i)
            CHECK((*scene.camera.position)[i] ==
                  Approx((*key.scene.camera.position)[i]).margin(0.05));
        CHECK(scene.sun.time_h == Approx(key.scene.sun.time_h).margin(0.01));
    }
}

TEST_CASE("a key frame can be moved between its neighbours, and none is lost",
          "[preview][animate]") {
    preview::CameraPath path;
    for (const double t : {0.0, 1.0, 1.5}) {
        const std::size_t place = path.put(t, scene::Scene{});
        CHECK(place == path.keys().size() - 1);
    }
    const auto at = [&](const std::vector<double>& wanted) {
        REQUIRE(path.keys().size() == wanted.size());
        for (std::size_t i = 0; i < wanted.size(); ++i)
            CHECK(path.keys()[i].time_s == Approx(wanted[i]).margin(1e-9));
    };
    path.move(1, 0.25);
    at({0, 0.25, 1.5});
    path.move(1, 9);
    at({0, 1.46, 1.5});
    path.move(1, -1);
    at({0, 0.04, 1.5});
    path.move(0, 5);
    at({0, 0.04, 1.5});  // there is no room
    path.move(2, 0);
    at({0, 0.04, 0.08});
    path.move(2, 7);
    at({0, 0.04, 7});
    path.fps = 1;
    CHECK(path.put(0.3, scene::Scene{}) ==
          0);  // takes the place of both that are within half a frame
    at({0.3, 7});
    path.remove(1);
    CHECK(path.keys().size() == 1);
}
