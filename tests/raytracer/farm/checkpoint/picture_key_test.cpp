#include "raytracer/farm/checkpoint/picture_key.hpp"

#include <functional>

#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

farm::PictureKey key_with(const std::function<void(scene::Scene&)>& change) {
    scene::Scene scene = small_scene();
    change(scene);
    return farm::to_key(scene, landscape()->info(), {"a.laz: 1 file", "generated:7"});
}

}  // namespace

TEST_CASE("a key survives conversion to text and back", "[raytracer][checkpoint][key]") {
    const farm::PictureKey key = key_with([](scene::Scene& s) {
        s.output.layers = core::PictureLayers::kAll;
        s.sun.zone = "Europe/Ljubljana";
        s.camera.position = {0.1, 1e-7, -3.25};
    });
    CHECK(farm::PictureKey::from_json(key.to_json(), "test") == key);
    CHECK(key.grid == farm::TileGrid{97, 53, 16});
    CHECK(key.with_layers);
    CHECK(farm::difference(key, key).empty());
    scene::Scene again;
    scene::parse_scene(key.scene, "test", again);
    CHECK(scene::to_toml(scene::what_shows(again)) == key.scene);
}

TEST_CASE("keys are equal for equal pixels, and describe what makes others",
          "[raytracer][checkpoint][key]") {
    const farm::PictureKey key = key_with([](scene::Scene&) {});
    CHECK(key == key_with([](scene::Scene& s) {
              s.processing.threads = 7;
              s.processing.memory_mib = 99;
              s.quality.tile_order = core::TileOrder::kRows;
              s.quality.coarse_step = 1;
          }));
    struct Case {
        const char* said;
        std::function<void(farm::PictureKey&)> change;
    };
    const auto with_scene = [](const std::function<void(scene::Scene&)>& change) {
        return [change](farm::PictureKey& k) { k = key_with(change); };
    };
    const std::vector<Case> cases = {
        {"camera.fov_deg = 50.0 there, 40.0 here",
         with_scene([](scene::Scene& s) { s.camera.fov_deg = 50; })},
        {"camera.position = [1.0, 2.0, 3.0] there, not set here",
         with_scene([](scene::Scene& s) { s.camera.position = {1, 2, 3}; })},
        {"quality.seed = 5 there, 0 here", with_scene([](scene::Scene& s) { s.quality.seed = 5; })},
        {"and 1 more", with_scene([](scene::Scene& s) {
             s.quality.seed = 5;
             s.camera.zoom = 2;
             s.sun.time_h = 3;
             s.sky.clouds = 0.5;
         })},
        {"tiles of 32 pixels there, 16 here",
         with_scene([](scene::Scene& s) { s.quality.tile = {32}; })},
        {"output.size", with_scene([](scene::Scene& s) { s.output.size_px = {96, 53}; })},
        {"made by terravox 0.0.1", [](farm::PictureKey& k) { k.software = "terravox 0.0.1"; }},
        {"build other", [](farm::PictureKey& k) { k.build = "other"; }},
        {"input 1 = b.laz: 1 file there",
         [](farm::PictureKey& k) { k.inputs[0] = "b.laz: 1 file"; }},
        {"input 3 = more there, not set here",
         [](farm::PictureKey& k) { k.inputs.push_back("more"); }},
        {"input 1 = b.laz: 1 file there",
         [](farm::PictureKey& k) {
             k.inputs[0] = "b.laz: 1 file";
             auto world = nlohmann::json::parse(k.world);
             world["bounds"] = "of b";
             k.world = world.dump();
         }},
        {"layers there, none here", [](farm::PictureKey& k) { k.with_layers = true; }},
        {"world.title = \"elsewhere\" there",
         [](farm::PictureKey& k) {
             auto world = nlohmann::json::parse(k.world);
             world["title"] = "elsewhere";
             k.world = world.dump();
         }},
    };
    for (const Case& c : cases) {
        farm::PictureKey there = key;
        c.change(there);
        INFO(c.said);
        CHECK_THAT(farm::difference(there, key), contains(c.said));
        CHECK(farm::difference(there, key).find('\n') == std::string::npos);
    }
}

TEST_CASE("a world of many brackets is another one", "[raytracer][checkpoint][key]") {
    const farm::PictureKey key = key_with([](scene::Scene&) {});
    farm::PictureKey there = key;
    const std::string title = R"("title":)";
    const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
    there.world.insert(there.world.find(title) + title.size(), deep + ',' + R"("was":)");
    const std::string said = farm::difference(there, key);
    CHECK_THAT(said, contains("world = {"));
    CHECK(said.size() < 300);
}

TEST_CASE("a checkpoint whose world is a million objects is read in one go",
          "[raytracer][checkpoint][key]") {
    // A parser that looks through all objects before it at the end of each takes an hour for this.
    const farm::PictureKey key = key_with([](scene::Scene&) {});
    farm::PictureKey there = key;
    std::string objects = "{}";
    for (int i = 0; i < 1'000'000; ++i)
        objects += ",{}";
    const std::string title = R"("title":)";
    there.world.insert(there.world.find(title) + title.size(), '[' + objects + R"(],"was":)");
    CHECK_THAT(farm::difference(there, key), contains("world.title = [{},{}"));
}

TEST_CASE("text that is no key is refused", "[raytracer][checkpoint][key]") {
    const auto good = nlohmann::json::parse(key_with([](scene::Scene&) {}).to_json());
    const auto with = [&](const char* name, nlohmann::json value) {
        auto out = good;
        out[name] = std::move(value);
        return out.dump();
    };
    CHECK_THROWS_WITH(farm::PictureKey::from_json("{", "x.tiles"),
                      contains("read the checkpoint x.tiles: what it is of cannot be understood"));
    CHECK_THROWS_AS(farm::PictureKey::from_json("[]", "x"), util::Error);
    CHECK_THROWS_AS(farm::PictureKey::from_json(with("scene", 5), "x"), util::Error);
    CHECK_THROWS_AS(farm::PictureKey::from_json(with("size_px", {1, 2, 3}), "x"), util::Error);
    for (const std::int64_t size :
         {std::int64_t{0}, std::int64_t{-1}, std::int64_t{65'537}, std::int64_t{1} << 40})
        CHECK_THROWS_WITH(farm::PictureKey::from_json(with("size_px", {size, 10}), "x"),
                          contains("allowed: 1 to 65536"));
    CHECK_THROWS_WITH(farm::PictureKey::from_json(with("tile_px", 0), "x"),
                      contains("allowed: 1 to 4096"));
    auto most = nlohmann::json::parse(with("size_px", {65'536, 65'536}));
    most["tile_px"] = 63;
    CHECK_THROWS_WITH(farm::PictureKey::from_json(most.dump(), "x"),
                      contains("tiles; allowed: up to 1048576"));
    most["tile_px"] = 64;
    CHECK(farm::PictureKey::from_json(most.dump(), "x").grid.cells() == 1 << 20);
}
