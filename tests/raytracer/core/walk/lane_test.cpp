// Rays that are walked side by side must find what single rays find, to the last bit.
#include "raytracer/core/walk/lane_walk.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/core/walk/walk_fixture.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// A ray, what a single walk finds, and what the lanes find.
struct Sent {
    core::RayState state;
    double t_max = core::kFar;
    bool asks = false;
    std::optional<walk::Hit> wanted;
    walk::WalkEnd end = walk::WalkEnd::kWaits;
    walk::Hit hit;
};

enum class Kind { kAnywhere, kWhole, kLimited };

std::optional<Sent> random_ray(Fixture& f, Random& random, Kind kind) {
    core::Ray ray{
        {real(random, -120, 200), real(random, -25, 110), real(random, -130, 170)},
        core::normalized({real(random, -1, 1), real(random, -1, 1), real(random, -1, 1)})};
    if (kind == Kind::kWhole)
        ray = {{std::round(ray.origin.x), std::round(ray.origin.y), std::round(ray.origin.z)},
               {std::round(ray.direction.x * 3), -1, std::round(ray.direction.z * 3) / 2}};
    Sent out;
    out.state = core::RayState(ray);
    if (!out.state.enter(f.cut.entry_bounds()))
        return std::nullopt;
    if (kind == Kind::kLimited)
        out.t_max = out.state.t + real(random, 0, 90);
    out.asks = random() % 2 == 0;
    core::RayState single = out.state;
    out.wanted = f.finish(single, out.t_max);
    return out;
}

bool as_alone(Fixture& f, Sent& ray) {
    std::optional<walk::Hit> found =
        ray.end == walk::WalkEnd::kHit ? std::optional(ray.hit) : std::nullopt;
    if (ray.end == walk::WalkEnd::kWaits)
        found = f.finish(ray.state, ray.t_max);
    if (ray.asks && ray.end != walk::WalkEnd::kWaits)
        return (ray.end == walk::WalkEnd::kHit) == ray.wanted.has_value();
    return same(found, ray.wanted);
}

void check(Fixture& f, double detail, std::size_t pinned_bytes, Kind kind, bool boxes_at_hand) {
    Fixture other(detail, pinned_bytes);
    walk::LaneWalk lanes(other.reader, other.cut, *walk::packet_steps());
    Random random(23);
    int wrong = 0;
    int hits = 0;
    int alongside = 0;
    int all = 0;
    for (const int count : {1, 5, 16, 17, 200, 2000}) {
        std::vector<Sent> rays;
        while (rays.size() < static_cast<std::size_t>(count))
            if (auto ray = random_ray(f, random, kind))
                rays.push_back(*ray);
        // All boxes are in memory; else those that the rays of previous rounds have requested at
        // their ends.
        if (boxes_at_hand)
            for (const Sent& ray : rays) {
                core::RayState copy = ray.state;
                (void)other.finish(copy);
            }
        std::vector<walk::LaneRay> sent;
        for (Sent& ray : rays)
            sent.push_back({&ray.state, &ray.end, ray.t_max, ray.asks ? nullptr : &ray.hit});
        lanes.trace(sent);
        for (Sent& ray : rays) {
            ++all;
            hits += ray.wanted ? 1 : 0;
            alongside += ray.end != walk::WalkEnd::kWaits ? 1 : 0;
            wrong += as_alone(other, ray) ? 0 : 1;
        }
    }
    CHECK(!other.reader.holds_much());
    CHECK(wrong == 0);
    CHECK(hits > all / 6);
    CHECK(hits < all * 19 / 20);
    if (boxes_at_hand && kind != Kind::kWhole)
        CHECK(alongside > all / 2);
}

}  // namespace

TEST_CASE("rays side by side find the voxel, face and time that single rays find",
          "[raytracer][lanes]") {
    if (walk::packet_steps() == nullptr) {
        WARN("skipped: neither AVX2 nor AVX-512");
        return;
    }
    struct Case {
        const char* name;
        Kind kind;
    };
    for (const double detail : {0.0, 1.0, 4.0}) {
        Fixture f(detail);
        for (const Case& c :
             {Case{"every way", Kind::kAnywhere}, Case{"whole coordinates", Kind::kWhole},
              Case{"only so far", Kind::kLimited}})
            for (const bool at_hand : {true, false}) {
                INFO(c.name << ", detail " << detail
                            << (at_hand ? "" : ", boxes that are missing"));
                check(f, detail, std::size_t{64} << 20, c.kind, at_hand);
            }
    }
}
