#include "raytracer/core/animate/animation.hpp"

#include <cmath>
#include <fstream>

#include "common/geo/lat_lon.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/scene_words_text.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
using Triple = std::array<double, 3>;

namespace {

class File {
public:
    explicit File(const std::string& text) : m_path(m_folder.path() / "film.toml") {
        std::ofstream(m_path) << text;
        std::filesystem::create_directory(m_folder.path() / "views");
        std::ofstream(m_folder.path() / "views/v.toml")
            << "[[view]]\nname = \"Start\"\n[view.camera]\nspace = \"latlon\"\nposition = [46, 14, "
               "500]\ntarget = [46.01, 14, 400]\n"
               "[[view]]\nname = \"End\"\n[view.camera]\nspace = \"latlon\"\nposition = [46.02, "
               "14.04, 700]\ntarget = [46.01, 14, 400]\n";
    }
    [[nodiscard]] animate::Animation read() const {
        return animate::Animation::read(m_path, m_folder.path() / "views");
    }
    [[nodiscard]] std::string path() const { return m_path.string(); }

private:
    TemporaryFolder m_folder;
    std::filesystem::path m_path;
};

}  // namespace

TEST_CASE("keys move numbers and places smoothly and switch words; what no key names stays",
          "[raytracer][animate]") {
    const File file(R"(
fps = 10
[output]
size = "100x50"
[[key]]
time_s = 0
[key.camera]
position = [0, 0, 10]
target = [100, 0, 0]
fov_deg = 40
[[key]]
frame = 10
[key.camera]
position = [50, 20, 30]
[key.quality]
samples = 9
colour = "true"
[[key]]
time_s = 3
[key.camera]
position = [80, 90, 10]
fov_deg = 20
[key.quality]
samples = 2
colour = "material"
)");
    const animate::Animation film = file.read();
    CHECK(film.fps() == 10);
    REQUIRE(film.frames() == 31);
    scene::Scene base;
    base.camera.zoom = 3;
    base.quality.shadows = false;
    film.apply_base(base);
    CHECK(base.output.size_px == std::array{100, 50});
    CHECK(film.at(0, base).camera.position == Triple{0, 0, 10});
    CHECK(film.at(10, base).camera.position == Triple{50, 20, 30});
    CHECK(film.at(30, base).camera.position == Triple{80, 90, 10});
    CHECK(film.at(0, base).camera.fov_deg == 40);
    CHECK(film.at(30, base).camera.fov_deg == 20);
    CHECK(film.at(15, base).camera.fov_deg == Approx(30));
    CHECK(film.at(17, base).camera.target == Triple{100, 0, 0});
    CHECK(film.at(5, base).quality.samples == 9);  // before its first key
    CHECK(film.at(29, base).quality.samples == 9);
    CHECK(film.at(30, base).quality.samples == 2);
    CHECK(film.at(29, base).quality.colour == core::VoxelColour::kTrue);
    CHECK(film.at(30, base).quality.colour == core::VoxelColour::kMaterial);
    for (int i = 0; i < film.frames(); ++i) {
        const scene::Scene scene = film.at(i, base);
        CHECK((scene.camera.zoom == 3 && !scene.quality.shadows &&
               scene.output.size_px == std::array{100, 50}));
        CHECK(scene::to_toml(film.at(i, base)) == scene::to_toml(scene));  // a pure function
        if (i == 0)
            continue;
        // No jump, and no sudden bend.
        for (std::size_t a = 0; a < 3; ++a) {
            const auto at = [&](int frame) { return (*film.at(frame, base).camera.position)[a]; };
            INFO("frame " << i << ", axis " << a);
            CHECK(std::abs(at(i) - at(i - 1)) < 8);
            if (i > 1)
                CHECK(std::abs(at(i) - 2 * at(i - 1) + at(i - 2)) < 1.5);
        }
    }
}

TEST_CASE("keys may be written in any way of TOML", "[raytracer][animate]") {
    struct Case {
        const char* name;
        const char* text;
    };
    const auto c = GENERATE(values<Case>({
        {"tables", "[[key]]\ntime_s = 0\nsun.time_h = 6\n[[key]]\ntime_s = 2\nsun.time_h = 12\n"},
        {"lines of DOS",
         "[[key]]\r\ntime_s = 0\r\nsun.time_h = 6\r\n[[key]]\r\ntime_s = "
         "2.0\r\nsun.time_h = 1.2e1\r\n"},
        {"a byte order mark",
         "\xef\xbb\xbf[[key]]\ntime_s = 0\nsun.time_h = 6\n[[key]]\ntime_s = 2\nsun.time_h = 12"},
        {"one line",
         "key = [{time_s = 0, sun = {time_h = 6}}, {\"time_s\" = 2, "
         "'sun'.\"time_h\" = 12}]"},
        {"the last part first",
         "[[key]]\nsun = {time_h = 6}\ntime_s = 0.0\n[[key]]\n[key.sun]\ntime_h = 12\n"
         "[key.output]\n[key.quality]\n"},
    }));
    DYNAMIC_SECTION(c.name) {
        const File file(c.text);
        if (std::string(c.name) == "the last part first") {
            CHECK_THROWS_WITH(file.read(), contains("key 2: no time"));
            return;
        }
        const animate::Animation film = file.read();
        CHECK(film.at(0, {}).sun.time_h == 6);
        CHECK(film.at(film.frames() - 1, {}).sun.time_h == 12);
        CHECK(film.at(film.frames() / 2, {}).sun.time_h == Approx(9).margin(0.1));
    }
}

TEST_CASE("a key may name a view, and change it", "[raytracer][animate]") {
    const animate::Animation film =
        File(
            "fps = 2\n[[key]]\ntime_s = 0\ncamera.look = \"start\"\n[[key]]\ntime_s = "
            "4\n[key.camera]\nlook = \"End\"\ntarget = [46.02, 14.0, 450]\n")
            .read();
    const scene::Scene first = film.at(0, {});
    const scene::Scene last = film.at(8, {});
    CHECK(first.camera.space == core::CoordinateSpace::kLatLon);
    CHECK(first.camera.position == Triple{46, 14, 500});
    CHECK(last.camera.position == Triple{46.02, 14.04, 700});
    CHECK(last.camera.target == Triple{46.02, 14.0, 450});
    CHECK((*film.at(4, {}).camera.position)[0] == Approx(46.01));
    CHECK(first.camera.look.empty());
}

TEST_CASE("a turntable goes around its target at one distance and height, clockwise, and closes",
          "[raytracer][animate]") {
    const auto space = GENERATE(core::CoordinateSpace::kCrs, core::CoordinateSpace::kVoxel,
                                core::CoordinateSpace::kLatLon);
    scene::Scene base;
    base.camera.space = space;
    base.camera.target = space == core::CoordinateSpace::kLatLon ? Triple{46.36, 14.09, 480}
                                                                 : Triple{1000, 2000, 300};
    base.camera.position = space == core::CoordinateSpace::kLatLon ? Triple{46.37, 14.09, 700}
                           : space == core::CoordinateSpace::kCrs
                               ? Triple{1000, 2500, 450}
                               : Triple{1000, 2000, -200};  // in the north
    const animate::Animation film = File("fps = 10\n[turntable]\nseconds = 4\n").read();
    REQUIRE(film.frames() == 40);
    // East and north of the target, metres.
    const auto around = [&](const scene::Scene& scene) {
        const Triple &p = *scene.camera.position, &t = *scene.camera.target;
        if (space == core::CoordinateSpace::kLatLon) {
            const auto local = geo::LocalFrame({t[0], t[1]}, 0).to_local({p[0], p[1]}, 0);
            return std::array{local.east_m, local.north_m};
        }
        return space == core::CoordinateSpace::kCrs ? std::array{p[0] - t[0], p[1] - t[1]}
                                                    : std::array{p[0] - t[0], -(p[2] - t[2])};
    };
    const auto start = around(base);
    const double radius = std::hypot(start[0], start[1]);
    for (int i = 0; i < 40; ++i) {
        const scene::Scene scene = film.at(i, base);
        const auto [east, north] = around(scene);
        INFO(space << ", frame " << i << ": " << east << ", " << north);
        CHECK(std::hypot(east, north) == Approx(radius).epsilon(1e-6));
        CHECK(std::cos(std::atan2(east, north) - i * 9 * std::acos(-1.0) / 180) > 1 - 1e-9);
        CHECK(scene.camera.target == base.camera.target);
        const std::size_t height = space == core::CoordinateSpace::kVoxel ? 1 : 2;
        CHECK((*scene.camera.position)[height] == (*base.camera.position)[height]);
    }
    CHECK(film.at(0, base).camera.position == base.camera.position);
    SECTION("around another point the target goes along") {
        const Triple centre = space == core::CoordinateSpace::kLatLon ? Triple{46.365, 14.091, 0}
                                                                      : Triple{900, 2100, 0};
        std::string text = "fps = 10\n[turntable]\nturns = -0.5\nseconds = 4\ntarget = [";
        for (const double v : centre)
            text += std::to_string(v) + ", ";
        const animate::Animation other = File(text + "]\n").read();
        REQUIRE(other.frames() == 41);
        const scene::Scene half = other.at(40, base);
        CHECK(around(half)[0] == Approx(-start[0]).margin(radius * 1e-3));
        CHECK(around(half)[1] == Approx(-start[1]).margin(radius * 1e-3));
    }
    SECTION("a camera that frames the world goes around it") {
        scene::Scene framing;
        framing.camera.azimuth_deg = 350;
        CHECK(film.at(10, framing).camera.azimuth_deg == Approx(80));
        CHECK_FALSE(film.at(10, framing).camera.position);
    }
}

TEST_CASE("a day goes from one clock hour to another", "[raytracer][animate]") {
    const animate::Animation film = File("fps = 4\nseconds = 5\n[day]\nfrom = 5\nto = 21\n").read();
    REQUIRE(film.frames() == 21);
    for (int i = 0; i <= 20; ++i)
        CHECK(film.at(i, {}).sun.time_h == Approx(5 + 0.8 * i));
    CHECK(film.at(20, {}).sun.time_h <= 21);
    scene::Scene fixed;
    fixed.sun.altitude_deg = 30;
    fixed.sun.azimuth_deg = 100;
    CHECK_THROWS_WITH(film.at(0, fixed), contains("[day] and sun.altitude_deg"));
    const animate::Animation back = File("[day]\nfrom = 21\nto = 20\nseconds = 2\n").read();
    CHECK(back.at(50, {}).sun.time_h == Approx(20));
}

TEST_CASE("an animation that cannot be is refused in one line that names file, key and field",
          "[raytracer][animate]") {
    struct Case {
        const char* name;
        std::string text;
        std::string said;
    };
    const std::string key = "[[key]]\ntime_s = 0\n";
    const auto c = GENERATE_COPY(values<Case>({
        {"nothing", "", "nothing moves; give [[key]], [turntable] or [day]"},
        {"no frames in a second", "fps = 0\n" + key, "fps = 0; allowed: 0.01 to 1000"},
        {"a key without a time", "[[key]]\nsun.time_h = 3",
         "key 1: no time; allowed: one of time_s, frame"},
        {"a key with two", "[[key]]\ntime_s = 1\nframe = 2", "key 1: time_s and frame"},
        {"half a frame", "[[key]]\nframe = 2.5", "key 1: frame = 2.5; allowed: whole numbers"},
        {"keys out of order", "[[key]]\ntime_s = 2\n" + key,
         "key 2: its time, 0 s, is not after that of the key before, 2 s"},
        {"an unknown field", key + "[key.camera]\nfov = 3", "key 1: unknown field 'camera.fov'"},
        {"a field out of range", key + "sun.time_h = 99",
         "key 1: sun.time_h = 99; allowed: 0 to 24"},
        {"an unknown view", key + "camera.look = \"Atlantis\"", "names no view"},
        {"a size that changes", key + "output.size = \"3x3\"", "key 1: output.size stays the same"},
        {"spaces that change",
         key + "camera.space = \"crs\"\n[[key]]\ntime_s = 1\ncamera.space = \"voxel\"",
         "camera.space changes between keys"},
        {"key as a value", "key = 3", "key = 3; allowed: [[key]]"},
        {"a field of no scene", "title = \"x\"\n" + key, "unknown field 'title'"},
        {"a turntable without a length", "[turntable]\nturns = 2",
         "[turntable] has no length; give seconds"},
        {"a turntable around half a point", "[turntable]\ntarget = [1, 2]\nseconds = 2",
         "turntable: camera.target = 2 numbers"},
        {"half a day", "[day]\nfrom = 3\nseconds = 2", "day.to is missing"},
        {"a long day", "[day]\nfrom = 3\nto = 25\nseconds = 2", "day.to = 25; allowed: 0 to 24"},
        {"two times of day", key + "sun.time_h = 3\n[day]\nfrom = 1\nto = 2\nseconds = 1",
         "key 1: sun.time_h, and [day]"},
        {"shorter than its keys", "seconds = 1\n[[key]]\ntime_s = 2",
         "seconds = 1; allowed: 2 and more"},
        {"longer than life", "seconds = 1e7\n" + key, "allowed: up to 1000000 frames"},
        {"another version", "version = 7\n" + key, "version = 7; allowed: 1"},
        {"no TOML", "[[key", "line 1"},
    }));
    DYNAMIC_SECTION(c.name) {
        const File file(c.text);
        std::string said;
        try {
            (void)file.read();
        } catch (const util::UsageError& e) {
            said = e.what();
        }
        CHECK_THAT(said, contains(c.said));
        CHECK(said.find('\n') == std::string::npos);
        if (std::string(c.name) != "an unknown view")
            CHECK_THAT(said, contains(file.path()));
    }
}

TEST_CASE("a turntable around a point of its own needs a camera that stands somewhere",
          "[raytracer][animate]") {
    const animate::Animation film = File("[turntable]\nseconds = 1\ntarget = [1, 2, 3]\n").read();
    CHECK_THROWS_AS(film.at(0, {}), util::UsageError);
    scene::Scene map;
    map.camera.projection = core::CameraProjection::kOrthographic;
    CHECK(film.at(3, map).camera.target == Triple{1, 2, 3});
    CHECK_THROWS_WITH(animate::Animation::read("/nowhere/film.toml"),
                      contains("/nowhere/film.toml"));
}
