#include "raytracer/core/scene/scene_io.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <type_traits>

#include "common/util/error.hpp"
#include "raytracer/core/scene/scene_fields.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::TemporaryFolder;

namespace {

std::map<std::string, std::string> list_values(const scene::Scene& scene) {
    // The writer is not used here: it is what is tested.
    std::map<std::string, std::string> out;
    const auto text = [](const auto& v) {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, std::string>)
            return v;
        else if constexpr (std::is_same_v<T, scene::TileSize> ||
                           std::is_same_v<T, scene::PointList>)
            return v.text();
        else if constexpr (std::is_enum_v<T>)
            return std::to_string(static_cast<int>(v));
        else if constexpr (std::is_arithmetic_v<T>)
            return std::to_string(v) + "/" + std::to_string(static_cast<double>(v) * 1e6);
        else {
            std::string list;
            for (const auto x : v)
                list += std::to_string(x) + ",";
            return list;
        }
    };
    scene::visit_fields(scene,
                        [&](std::string_view path, const auto& field, const scene::FieldRule&) {
                            if constexpr (requires { field.has_value(); })
                                out[std::string(path)] = field ? text(*field) : "unset";
                            else
                                out[std::string(path)] = text(field);
                        });
    return out;
}

/// A value other than the default, as on the command line, for every field.
std::string other_value(std::string_view path, const scene::FieldRule& rule, const auto& field) {
    using T = std::decay_t<decltype(field)>;
    if constexpr (std::is_same_v<T, bool>)
        return field ? "no" : "yes";
    else if constexpr (std::is_same_v<T, std::string>) {
        for (const auto word : rule.words)
            if (word != field && !word.empty())
                return std::string(word);
        return path == "sun.date" ? "1999-12-31" : "some \"text\" č \\ '1'";
    } else if constexpr (core::WordEnum<T>) {
        return std::string(core::to_word(field == core::list_words(T{})[0].value
                                             ? core::list_words(T{})[1].value
                                             : core::list_words(T{})[0].value));
    } else if constexpr (std::is_same_v<T, scene::TileSize>)
        return "12.5%";
    else if constexpr (std::is_same_v<T, scene::PointList>)
        return "1,2,3;-4.5,6e8,0.1";
    else if constexpr (std::is_same_v<T, std::array<int, 2>>)
        return "321x123";
    else if constexpr (std::is_same_v<T, std::optional<std::array<double, 3>>>)
        return rule.min == 0 ? "0.125,1e3,2" : "461999.125,-101000.1,1e3";
    else if constexpr (std::is_same_v<T, int>)
        return path == "quality.coarse_step"
                   ? "4"
                   : std::to_string(static_cast<int>(rule.min) +
                                    (field == static_cast<int>(rule.min) + 5 ? 6 : 5));
    else if constexpr (std::is_same_v<T, std::optional<int>>)
        return std::to_string(static_cast<int>(rule.min) + 5);
    else
        return rule.max < 1.7 ? "0.1" : rule.min > 1.7 ? std::to_string(rule.min + 5) : "1.7";
}

class SceneFile {
public:
    explicit SceneFile(const std::string& text) : m_path(m_folder.path() / "test.toml") {
        std::ofstream(m_path) << text;
    }
    [[nodiscard]] const std::filesystem::path& path() const { return m_path; }
    [[nodiscard]] scene::Scene read() const {
        scene::Scene scene;
        scene::read_scene(m_path, scene);
        return scene;
    }

private:
    TemporaryFolder m_folder;
    std::filesystem::path m_path;
};

}  // namespace

TEST_CASE("the default scene survives writing and reading", "[raytracer][scene]") {
    const scene::Scene scene;
    CHECK(list_values(SceneFile(scene::to_toml(scene)).read()) == list_values(scene));
    CHECK(list_values(SceneFile("").read()) == list_values(scene));
    CHECK(list_values(SceneFile("version = 1\n").read()) == list_values(scene));
}

TEST_CASE("every field can be set by its flag, and survives writing and reading",
          "[raytracer][scene]") {
    scene::Scene all;
    std::size_t fields = 0;
    const auto flags = scene::scene_flags();
    const scene::Scene defaults;
    scene::visit_fields(defaults, [&](std::string_view path, const auto& field,
                                      const scene::FieldRule& rule) {
        ++fields;
        INFO(path);
        const std::string text = other_value(path, rule, field);
        scene::Scene one;
        REQUIRE_NOTHROW(scene::set_field(one, std::string(path), text));
        REQUIRE_NOTHROW(scene::set_field(all, std::string(path), text));
        const auto changed = list_values(one);
        CHECK(changed.at(std::string(path)) != list_values(defaults).at(std::string(path)));
        CHECK(list_values(SceneFile(scene::to_toml(one)).read()) == changed);
        const auto flag = std::find_if(flags.begin(), flags.end(),
                                       [&](const scene::SceneFlag& f) { return f.path == path; });
        REQUIRE(flag != flags.end());
        CHECK_THAT(flag->names, contains("--"));
        CHECK(flag->names.find_first_of("._") == std::string::npos);
        CHECK_THAT(flag->help, contains(std::string(rule.doc)));
    });
    CHECK(flags.size() == fields);
    CHECK(list_values(SceneFile(scene::to_toml(all)).read()) == list_values(all));
}

TEST_CASE("words and values of scenes lead to each other", "[raytracer][scene]") {
    const auto check = [](auto value) {
        using Enum = decltype(value);
        const auto words = core::list_words(value);
        CHECK(words.size() >= 2);
        for (std::size_t i = 0; i < words.size(); ++i) {
            INFO(words[i].text);
            CHECK(static_cast<std::size_t>(words[i].value) == i);
            CHECK(core::from_word<Enum>(core::to_word(words[i].value)) == words[i].value);
        }
        CHECK_FALSE(core::from_word<Enum>("zigzag"));
        CHECK_FALSE(core::from_word<Enum>(""));
        CHECK(core::to_word(static_cast<Enum>(99)).empty());
    };
    check(core::CameraProjection{});
    check(core::CoordinateSpace{});
    check(core::SkyModel{});
    check(core::ToneCurve{});
    check(core::PictureLayers{});
    check(core::TiffSamples{});
    check(core::Integrator{});
    check(core::TileOrder{});
    check(core::VoxelColour{});
}

TEST_CASE("a field's former name is still read", "[raytracer][scene]") {
    const scene::Scene read = SceneFile("[processing]\nbox_patience_s = 7\n").read();
    CHECK(read.processing.box_timeout_s == 7);
    const auto flags = scene::scene_flags();
    const auto flag = std::find_if(flags.begin(), flags.end(), [](const scene::SceneFlag& f) {
        return f.path == "processing.box_timeout_s";
    });
    REQUIRE(flag != flags.end());
    CHECK(flag->names == "--processing-box-timeout-s");
    CHECK(flag->former == "--processing-box-patience-s");
}

TEST_CASE("no two fields share a flag", "[raytracer][scene]") {
    std::set<std::string> seen;
    for (const scene::SceneFlag& flag : scene::scene_flags())
        for (std::size_t at = 0; at != std::string::npos;) {
            const auto comma = flag.names.find(',', at);
            const auto name =
                flag.names.substr(at, comma == std::string::npos ? comma : comma - at);
            INFO(name);
            CHECK(seen.insert(name).second);
            at = comma == std::string::npos ? comma : comma + 1;
        }
}

TEST_CASE("numbers survive to the last bit", "[raytracer][scene]") {
    scene::Scene scene;
    scene.camera.position = {461'999.123456789012, -1.0 / 3, 5e-324};
    scene.camera.target = {1e22, -0.1, 2864};
    scene.camera.fov_deg = 33.333333333333336;
    const scene::Scene back = SceneFile(scene::to_toml(scene)).read();
    CHECK(back.camera.position == scene.camera.position);
    CHECK(back.camera.target == scene.camera.target);
    CHECK(back.camera.fov_deg == scene.camera.fov_deg);
}

TEST_CASE("a scene file changes what it names and nothing else", "[raytracer][scene]") {
    scene::Scene scene;
    scene.camera.fov_deg = 77;
    scene.quality.samples = 9;
    scene::read_scene(SceneFile("[quality]\nsamples = 2\n").path(), scene);
    CHECK(scene.camera.fov_deg == 77);
    CHECK(scene.quality.samples == 2);
}

TEST_CASE("sizes are text or lists in a file", "[raytracer][scene]") {
    CHECK(SceneFile("[output]\nsize = \"640x480\"").read().output.size_px == std::array{640, 480});
    CHECK(SceneFile("[output]\nsize = [640, 480]").read().output.size_px == std::array{640, 480});
    CHECK(SceneFile("[quality]\ntile = 32").read().quality.tile == scene::TileSize{32, 0});
    CHECK(SceneFile("[quality]\ntile = \"32\"").read().quality.tile == scene::TileSize{32, 0});
    CHECK(SceneFile("[quality]\ntile = \"2.5%\"").read().quality.tile == scene::TileSize{64, 2.5});
    CHECK(SceneFile("[quality]\nsamples = 3.0").read().quality.samples == 3);
    CHECK(SceneFile("[camera]\nfov_deg = 50").read().camera.fov_deg == 50);
}

TEST_CASE("a scene file that cannot be is refused, naming file, field, value and what is allowed",
          "[raytracer][scene]") {
    struct Case {
        const char* name;
        std::string text;
        std::string said;
    };
    const auto c = GENERATE(values<Case>({
        {"unknown field", "[camera]\nfov = 40", "unknown field 'camera.fov'"},
        {"unknown section", "[lens]\nfov_deg = 40", "unknown field 'lens.fov_deg'"},
        {"unknown section without a field", "[foo]", "unknown section 'foo'"},
        {"a section given as a list of tables", "[[camera]]\nfov_deg = 40",
         "unknown field 'camera'"},
        {"text for a number", "[camera]\nfov_deg = \"wide\"",
         "camera.fov_deg = 'wide'; allowed: a number"},
        {"a number for text", "[camera]\nspace = 3", "camera.space = 3; allowed: text"},
        {"a number for yes or no", "[quality]\nshadows = 1",
         "quality.shadows = 1; allowed: true, false"},
        {"too high", "[camera]\nfov_deg = 361", "camera.fov_deg = 361; allowed: 1 to 360"},
        {"not a number", "[camera]\nfov_deg = nan", "camera.fov_deg = nan"},
        {"a broken whole number", "[quality]\nsamples = 2.5",
         "quality.samples = 2.5; allowed: whole numbers from 1 to 65536"},
        {"another word", "[quality]\ncolour = \"red\"",
         "quality.colour = 'red'; allowed: material, true, mix"},
        {"a mistyped word", "[quality]\nintegrator = \"pahts\"",
         "quality.integrator = 'pahts'; did you mean path? allowed: direct, path"},
        {"a mistyped field", "[camera]\nfov_dge = 40",
         "unknown field 'camera.fov_dge'; did you mean camera.fov_deg?"},
        {"a mistyped section", "[camra]", "unknown section 'camra'; did you mean camera?"},
        {"another order", "[quality]\ntile_order = \"zigzag\"",
         "allowed: spiral, vertical, vertical-split, hilbert, rows"},
        {"a tile of no size", "[quality]\ntile = 0",
         "quality.tile = '0'; allowed: 1 to 4096 pixels, or 0.1% to 100%"},
        {"no time", "[processing]\nbox_timeout_s = 0",
         "processing.box_timeout_s = 0; allowed: 1 to 86400"},
        {"both names", "[processing]\nbox_timeout_s = 1\nbox_patience_s = 2",
         "processing.box_timeout_s and processing.box_patience_s, which is its former name"},
        {"two coordinates", "[camera]\nposition = [1, 2]",
         "camera.position = 2 numbers; allowed: three finite numbers"},
        {"a coordinate that is text", "[camera]\nposition = [1, \"2\", 3]",
         "camera.position = a list with other values than numbers"},
        {"an infinite coordinate", "[camera]\nposition = [1, inf, 3]", "camera.position"},
        {"half a size", "[output]\nsize = \"640\"",
         "output.size = '640'; allowed: WIDTHxHEIGHT in pixels"},
        {"a size with a fraction", "[output]\nsize = [640.5, 480]", "output.size = 640.5"},
        {"another version", "version = 2\n", "version = 2; allowed: 1"},
        {"no TOML", "[camera\nfov_deg = 40", "line 1"},
        {"a field twice", "[camera]\nfov_deg = 40\nfov_deg = 41", "line 3"},
        {"no UTF-8", "title = \"\xff\xfe\"", "line 1"},
    }));
    DYNAMIC_SECTION(c.name) {
        const SceneFile file(c.text);
        std::string said;
        try {
            (void)file.read();
        } catch (const util::UsageError& e) {
            said = e.what();
        }
        CHECK_THAT(said, contains(file.path().string()) && contains(c.said));
        CHECK(said.find('\n') == std::string::npos);
    }
}

TEST_CASE("a version that is no whole number is no version", "[raytracer][scene]") {
    const std::string text = GENERATE("version = \"1\"", "version = \"2\"", "version = 1.5",
                                      "version = [1]", "[version]\nmajor = 2");
    INFO(text);
    CHECK_THROWS_WITH(SceneFile(text).read(), contains("version"));
}

TEST_CASE("a scene file that is not there is named", "[raytracer][scene]") {
    const TemporaryFolder folder;
    scene::Scene scene;
    CHECK_THROWS_AS(scene::read_scene(folder.path() / "none.toml", scene), util::UsageError);
    CHECK_THROWS_WITH(scene::read_scene(folder.path() / "none.toml", scene),
                      contains("none.toml") && contains("no such file"));
    CHECK_THROWS_AS(scene::read_scene(folder.path(), scene), util::UsageError);
}

TEST_CASE(
    "a value on the command line that cannot be is refused, naming field, value and what is "
    "allowed",
    "[raytracer][scene]") {
    struct Case {
        const char *path, *text, *said;
    };
    const auto c = GENERATE(values<Case>({
        {"camera.fov_deg", "", "allowed: a number"},
        {"camera.fov_deg", " 40", "' 40'"},
        {"output.size", "640x480x", "WIDTHxHEIGHT"},
        {"camera.position", "1,2,3,", "numbers with"},
        {"camera.position", "1,2", "three"},
        {"quality.tile", "", "0.1% to 100%"},
        {"quality.tile", "5 %", "'5 %'"},
        {"quality.shadows", "maybe", "allowed: yes, no"},
        {"output.size", "0x0", "allowed: whole numbers from 1 to 65536"},
        {"camera.position", "1,2,x", "'x'"},
        {"camera.position", "1,,3", "''"},
        {"world.vertical_unit", "feet", "allowed: m, ft, us-ft"},
        {"no.such", "1", "no such field"},
    }));
    DYNAMIC_SECTION(c.path << " = '" << c.text << "'") {
        scene::Scene scene;
        CHECK_THROWS_AS(scene::set_field(scene, c.path, c.text), util::UsageError);
        CHECK_THROWS_WITH(scene::set_field(scene, c.path, c.text),
                          contains(c.path) && contains(c.said));
        CHECK(list_values(scene) == list_values(scene::Scene{}));
    }
}

TEST_CASE("a fault of a value is told by the name of its flag", "[raytracer][scene]") {
    CHECK(scene::find_fault("camera.fov_deg", "wide", "--camera-fov-deg") ==
          "--camera-fov-deg = 'wide'; allowed: a number");
    CHECK(scene::find_fault("quality.integrator", "pth", "--quality-integrator") ==
          "--quality-integrator = 'pth'; did you mean path? allowed: direct, path");
    CHECK(scene::find_fault("camera.fov_deg", "40", "--camera-fov-deg").empty());
}
