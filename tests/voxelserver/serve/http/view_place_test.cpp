#include "voxelserver/serve/http/route_answers.hpp"

#include <nlohmann/json.hpp>

#include "tests/catch.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"

using namespace terravox;

namespace {

/// Bounds and levels of choice; all of it may be solid.
class WideWorld final : public voxel::ProvenanceWorld {
public:
    explicit WideWorld(std::int32_t side, int levels) {
        m_info.title = "wide";
        m_info.bounds = {{0, 0, -side}, {side, 256, 0}};
        m_info.levels = levels;
    }
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] voxel::WorldInfo& info() noexcept { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey&) override {
        return nullptr;
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        const auto range = voxel::boxes_over(m_info.bounds, level);
        if (bx < range.min.bx || bx >= range.max.bx || bz < range.min.bz || bz >= range.max.bz)
            return {};
        return {range.min.by, range.max.by};
    }
    [[nodiscard]] voxel::BoxWithInputs box_with_inputs(const voxel::BoxKey& key) override {
        return {box(key), {}};
    }
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent&) const override {
        return {1, 2};
    }

private:
    voxel::WorldInfo m_info;
};

struct Place {
    explicit Place(voxel::ProvenanceWorld& world, bool downsample = true)
        : boxes(world, times, {.downsample = downsample, .ahead = false}),
          service{world, times, boxes} {}
    util::StageTimes times;
    boxes::BoxCache boxes;
    http::Service service;

    nlohmann::json json() { return nlohmann::json::parse(http::view_place(service)); }
};

}  // namespace

TEST_CASE("the place of a server names it as the source, with the facts of its world",
          "[voxelserver][http][view_place]") {
    test::FakeWorld world;
    const auto json = Place(world).json();
    CHECK(json["version"] == 1);
    CHECK(json["title"] == world.info().title);
    CHECK_FALSE(json.contains("squares"));
    CHECK(json["attribution"] == "nobody & nothing");
    CHECK(json["licence"] == "CC0");
    CHECK(json["archive"] == nlohmann::json{{"server", "../"}, {"coarsest", 2}});
    REQUIRE(json["views"].size() == 1);
    CHECK(json["views"][0]["name"] == "Whole place");
    CHECK(json["views"][0]["target"] == nlohmann::json{64.0, 128.0, 0.0});
}

TEST_CASE("the first view of a wide world is close to its middle, and above the ground",
          "[voxelserver][http][view_place]") {
    WideWorld world(8192, 8);
    const auto views = Place(world).json()["views"];
    REQUIRE(views.size() == 2);
    CHECK(views[0]["name"] == "Start");
    CHECK(views[1]["name"] == "Whole place");
    for (const auto& view : views) {
        CHECK(view["target"] == nlohmann::json{4096.0, 128.0, -4096.0});
        CHECK(view["position"][1] >= 266);
        CHECK(view["position"][2] > view["target"][2]);  // from the south
    }
    CHECK(views[0]["position"][1] < views[1]["position"][1]);
    CHECK_FALSE(views[0].contains("frame"));
    CHECK(views[1]["frame"] == nlohmann::json{{"min", {0, 0, -8192}}, {"max", {8192, 256, 0}}});
}

TEST_CASE("an empty world has nothing that must be shown whole",
          "[voxelserver][http][view_place]") {
    WideWorld world(0, 1);
    CHECK_FALSE(Place(world).json()["views"][0].contains("frame"));
}

TEST_CASE("a world without end is shown where it is framed", "[voxelserver][http][view_place]") {
    WideWorld world(1 << 20, 15);
    world.info().framed = {{100, 10, -300}, {300, 20, -100}};
    const auto views = Place(world).json()["views"];
    REQUIRE(views.size() == 1);
    CHECK(views[0]["frame"] == nlohmann::json{{"min", {100, 10, -300}}, {"max", {300, 20, -100}}});
    CHECK(views[0]["target"][0] == 200);
    CHECK(views[0]["target"][2] == -200);
}

TEST_CASE("what flies far above a place moves none of its views",
          "[voxelserver][http][view_place]") {
    WideWorld clean(8192, 8);
    WideWorld with_bird(8192, 8);
    with_bird.info().bounds.max[1] = 2000;
    with_bird.info().typical_heights = voxel::HeightRange{0, 256};
    CHECK(Place(with_bird).json()["views"] == Place(clean).json()["views"]);
}

TEST_CASE("it is afternoon where the world lies", "[voxelserver][http][view_place]") {
    WideWorld world(64, 1);
    constexpr std::int64_t kFour = 1'782'057'600'000;  // 2026-06-21, 16:00 UTC
    CHECK(Place(world).json()["time_ms"] == kFour);
    world.info().centre = geo::MapPlace{46, 14.5};
    CHECK(Place(world).json()["time_ms"] == kFour - 3'600'000);
}

TEST_CASE("texts that the page would refuse are shortened between characters",
          "[voxelserver][http][view_place]") {
    WideWorld world(64, 1);
    world.info().attribution = std::string(4096, 'x');
    CHECK(Place(world).json()["attribution"] == world.info().attribution);
    world.info().attribution = std::string(4091, 'x') + "č" + std::string(100, 'x');
    CHECK(Place(world).json()["attribution"] == std::string(4091, 'x') + " …");
}

TEST_CASE("where coarse boxes take as long as all of the world, fewer levels are requested",
          "[voxelserver][http][view_place]") {
    struct Case {
        const char* name;
        std::int32_t side;
        int levels;
        bool downsample;
        int coarsest;
    };
    const auto c = GENERATE(values<Case>({
        {"small", 128, 2, true, 1},
        {"a square of a kilometre", 1024, 5, true, 2},
        {"at most 1024 columns", 64 << 7, 8, true, 2},
        {"more would be too many", (64 << 7) + 1, 9, true, 3},
        {"a country", 1 << 20, 15, true, 9},
        {"coarse boxes are made at once", 1 << 20, 15, false, 14},
    }));
    DYNAMIC_SECTION(c.name) {
        WideWorld world(c.side, c.levels);
        Place place(world, c.downsample);
        CHECK(http::coarsest_for_viewer(place.service) == c.coarsest);
    }
}

TEST_CASE("what is kept makes two levels more come soon", "[voxelserver][http][view_place]") {
    WideWorld world(2048, 6);
    Place place(world);
    const auto keep_all = [&](int level) {
        const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, level);
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
            for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz) {
                CHECK(http::coarsest_for_viewer(place.service) == level);
                (void)place.boxes.find_or_make({level, bx, 0, bz});
            }
    };
    keep_all(2);
    keep_all(4);
    CHECK(http::coarsest_for_viewer(place.service) == 5);
}

TEST_CASE("the page asks a server for squares only where there are some",
          "[voxelserver][http][view_place]") {
    test::FakeWorld world;
    Place place(world);
    place.service.squares = [] { return std::vector<http::SquareEntry>(1); };
    CHECK(place.json()["squares"] == "../v2/squares");
}
