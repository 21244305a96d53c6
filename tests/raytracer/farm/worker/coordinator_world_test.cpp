#include "raytracer/farm/worker/coordinator_world.hpp"

#include <functional>
#include <thread>

#include "common/thread/stop.hpp"
#include "common/voxel/box.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// A coordinator that answers at once.
struct Answering {
    std::unique_ptr<ArrayWorld> world = landscape();
    farm::BoxShelf shelf{std::size_t{16} << 20, 2};
    std::vector<voxel::BoxKey> asked;
    std::function<void(farm::BoxReply&)> change = [](farm::BoxReply&) {};
    farm::CoordinatorWorld far{world->info(), 7,
                               [this](farm::Frame frame) {
                                   for (const auto& k : frame.need_box().keys()) {
                                       const voxel::BoxKey key = farm::from_frame(k);
                                       asked.push_back(key);
                                       farm::BoxReply reply;
                                       reply.set_world_id(7);
                                       *reply.mutable_key() = k;
                                       const auto box = world->box(key);
                                       if (box) {
                                           const auto bytes = voxel::compress(*box);
                                           reply.set_frame(bytes.data(), bytes.size());
                                       } else {
                                           reply.set_air(true);
                                       }
                                       change(reply);
                                       CHECK(far.on_reply(reply));
                                   }
                                   return true;
                               },
                               shelf};
};

const voxel::BoxKey kSolid{0, 0, 0, 0}, kAir{0, 0, 5, 0};

}  // namespace

TEST_CASE("a coordinator's boxes are those of its world, requested once and kept for the next link",
          "[raytracer][farm]") {
    Answering a;
    const auto box = a.far.box(kSolid);
    REQUIRE(box);
    CHECK(voxel::compress(*box) == voxel::compress(*a.world->box(kSolid)));
    CHECK_FALSE(a.far.box(kAir));
    (void)a.far.box(kSolid);
    CHECK(a.asked == std::vector{kSolid, kAir});
    int n = 0;
    const std::vector<voxel::BoxKey> keys{kSolid, kAir, {0, -1, 0, 0}};
    a.far.boxes(
        keys, [&](const voxel::BoxKey&, const voxel::BoxOutcome& o) { n += o.failure ? 100 : 1; });
    CHECK(n == 3);
    CHECK(a.asked.size() == 3);
}

TEST_CASE("a box that the coordinator lacks, or sends wrong, is an error, and is not kept",
          "[raytracer][farm]") {
    Answering a;
    a.change = [](farm::BoxReply& r) { r.set_hole("the file is gone"); };
    CHECK_THROWS_WITH(a.far.box(kSolid), contains("the file is gone"));
    a.change = [](farm::BoxReply& r) { r.set_frame("no box"); };
    CHECK_THROWS_AS(a.far.box({0, -1, 0, 0}), util::Error);
    a.change = [](farm::BoxReply&) {};
    CHECK(a.far.box(kSolid));
}

TEST_CASE("a box of another key is refused", "[raytracer][farm]") {
    Answering a;
    const auto other = voxel::compress(*a.world->box({0, -1, 0, 0}));
    a.change = [&](farm::BoxReply& r) { r.set_frame(other.data(), other.size()); };
    CHECK_THROWS_WITH(a.far.box(kSolid), contains("the coordinator sent box 0/-1/0/0"));
}

TEST_CASE("the end of a link ends waits for boxes", "[raytracer][farm]") {
    const auto world = landscape();
    farm::BoxShelf shelf(1 << 20, 2);
    farm::CoordinatorWorld far(world->info(), 7, [](farm::Frame) { return true; }, shelf);
    std::thread stopper([&] { far.stop(); });
    CHECK_THROWS_AS(far.box(kSolid), thread::StoppedError);  // not reported as a hole
    stopper.join();
    farm::CoordinatorWorld dead(world->info(), 7, [](farm::Frame) { return false; }, shelf);
    CHECK_THROWS_AS(dead.box(kSolid), thread::StoppedError);
}

TEST_CASE("an unrequested reply is detected, unless it is of an earlier world",
          "[raytracer][farm]") {
    const auto world = landscape();
    farm::BoxShelf shelf(1 << 20, 2);
    farm::CoordinatorWorld far(world->info(), 7, [](farm::Frame) { return true; }, shelf);
    farm::BoxReply reply;
    reply.set_world_id(7);
    reply.set_air(true);
    CHECK_FALSE(far.on_reply(reply));
    reply.set_world_id(8);
    CHECK(far.on_reply(reply));
}

TEST_CASE("a world that lacks a box requests it from its fallback", "[raytracer][farm]") {
    class Broken final : public voxel::World {
    public:
        explicit Broken(const voxel::WorldInfo& info) : m_info(info) {}
        const voxel::WorldInfo& info() const noexcept override { return m_info; }
        std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
            if (key.bx < 0)
                throw util::Error("broken");
            return nullptr;
        }
        voxel::ColumnExtent column(int, std::int32_t, std::int32_t) override { return {}; }

    private:
        voxel::WorldInfo m_info;
    };
    const auto world = landscape();
    farm::FallbackWorld helped(std::make_unique<Broken>(world->info()), *world);
    CHECK_FALSE(helped.box(kSolid));
    CHECK(helped.box({0, -1, 0, 0}));
    int boxes = 0;
    const std::vector<voxel::BoxKey> keys{kSolid, {0, -1, 0, 0}};
    helped.boxes(keys,
                 [&](const voxel::BoxKey&, const voxel::BoxOutcome& o) { boxes += o.box ? 1 : 0; });
    CHECK(boxes == 1);
}

TEST_CASE("boxes of the latest worlds alone stay on the shelf", "[raytracer][farm]") {
    const auto world = landscape();
    farm::BoxShelf shelf(1 << 20, 2);
    const auto frame = std::make_shared<const farm::BoxShelf::Frame>(10);
    const auto open = [&](std::uint64_t id) {
        farm::CoordinatorWorld far(world->info(), id, [](farm::Frame) { return true; }, shelf);
        shelf.put({id, kSolid}, frame);
    };
    open(1);
    open(2);
    open(1);
    open(3);
    CHECK(shelf.find({1, kSolid}));
    CHECK_FALSE(shelf.find({2, kSolid}));
    CHECK(shelf.find({3, kSolid}));
}
