#include <functional>
#include <future>
#include <set>

#include "common/geo/crs.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "raytracer/farm/wire/picture_spec.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm_bench.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::Job;
using terravox::test::small_scene;

namespace {

farm::Hello worker_hello() {
    farm::OwnHello own;
    own.role = farm::WORKER;
    own.threads = 2;
    own.capacity = 20;
    return farm::make_hello(own);
}

/// Reads the frames of its link as they arrive, as a peer does: the other end waits for that before
/// it closes.
class ReadingPeer {
public:
    explicit ReadingPeer(net::Link& link)
        : m_link(link), m_reason(std::async(std::launch::async, [&link] {
              std::string reason;
              while (auto frame = link.receive())
                  if (frame->has_refusal())
                      reason = frame->refusal().reason();
              return reason;
          })) {}
    /// A check that fails before the other end has closed must not wait for that.
    ~ReadingPeer() { m_link.abort(); }
    /// @return why this end is refused, once the other has closed; "": it is not
    std::string refusal() { return m_reason.get(); }

private:
    net::Link& m_link;
    std::future<std::string> m_reason;
};

struct Refused {
    std::string here;   ///< message that the coordinator throws
    std::string there;  ///< reason that it sends to its peer
};

/// How a coordinator refuses a peer whose first frame is this.
Refused refused(const farm::Frame& first) {
    auto [mine, theirs] = net::link_pair();
    theirs->send(first);
    ReadingPeer told(*theirs);
    Refused out;
    try {
        (void)farm::meet(*mine, farm::make_hello({}), {farm::WORKER, farm::OBSERVER},
                         std::chrono::milliseconds(2000));
    } catch (const farm::HelloError& e) {
        out.here = e.what();
    }
    mine->close();
    out.there = told.refusal();
    return out;
}

}  // namespace

TEST_CASE("a peer that does not fit is refused, and both ends report why", "[raytracer][farm]") {
    struct Case {
        const char* name;
        std::function<void(farm::Hello&)> change;
        const char* says;
    };
    const auto c = GENERATE(values<Case>({
        {"protocol", [](farm::Hello& h) { h.set_protocol(99); }, "protocol 99; here: 1"},
        {"version", [](farm::Hello& h) { h.set_software("terravox 0.0.9"); },
         "version terravox 0.0.9; here: terravox"},
        {"build", [](farm::Hello& h) { h.set_build("0123"); }, "build 0123; here: "},
        {"processor", [](farm::Hello& h) { h.set_architecture("aarch64"); },
         "processor aarch64; here: "},
        {"role", [](farm::Hello& h) { h.set_role(farm::COORDINATOR); },
         "a coordinator, as is this end"},
        {"no role", [](farm::Hello& h) { h.set_role(farm::ROLE_UNKNOWN); },
         "neither coordinator nor worker"},
        {"no threads", [](farm::Hello& h) { h.set_threads(0); }, "a worker of 0 threads"},
        {"no room", [](farm::Hello& h) { h.set_capacity(0); }, "room for 0 tiles"},
        {"far too many", [](farm::Hello& h) { h.set_threads(4'000'000'000U); },
         "allowed: 1 to 1048576"},
    }));
    DYNAMIC_SECTION(c.name) {
        farm::Frame first;
        *first.mutable_hello() = worker_hello();
        c.change(*first.mutable_hello());
        const Refused said = refused(first);
        CHECK_THAT(said.here, contains(c.says));
        CHECK_THAT(said.there, contains(c.says));
    }
}

TEST_CASE("a peer has the role of its certificate only", "[raytracer][farm]") {
    /// A link whose peer has shown a certificate.
    class Certified final : public net::Link {
    public:
        Certified(std::unique_ptr<net::Link> link, std::string role)
            : m_link(std::move(link)), m_role(std::move(role)) {}
        bool send(farm::Frame frame) override { return m_link->send(std::move(frame)); }
        std::optional<farm::Frame> receive() override { return m_link->receive(); }
        void close(std::chrono::milliseconds timeout) noexcept override { m_link->close(timeout); }
        void abort() noexcept override { m_link->abort(); }
        const std::string& peer() const noexcept override { return m_link->peer(); }
        std::string certified_role() const override { return m_role; }
        std::string why_ended() const override { return m_link->why_ended(); }
        Traffic traffic() const noexcept override { return m_link->traffic(); }

    private:
        std::unique_ptr<net::Link> m_link;
        std::string m_role;
    };
    struct Case {
        const char* certified;
        farm::Role says;
        const char* refused;  ///< nullptr: it is admitted
    };
    for (const Case& c :
         {Case{"worker", farm::WORKER, nullptr}, Case{"coordinator", farm::OBSERVER, nullptr},
          Case{"", farm::WORKER, nullptr}, Case{"", farm::OBSERVER, nullptr},
          Case{"worker", farm::OBSERVER, "an observer with the certificate of a worker"},
          Case{"coordinator", farm::WORKER, "a worker with the certificate of a coordinator"}}) {
        INFO(c.certified << ", " << c.says);
        auto [mine, theirs] = net::link_pair();
        Certified link(std::move(mine), c.certified);
        farm::Frame first;
        *first.mutable_hello() = worker_hello();
        first.mutable_hello()->set_role(c.says);
        theirs->send(first);
        ReadingPeer told(*theirs);
        const auto meeting = [&] {
            return farm::meet(link, farm::make_hello({}), {farm::WORKER, farm::OBSERVER},
                              std::chrono::milliseconds(2000));
        };
        if (c.refused != nullptr)
            CHECK_THROWS_WITH(meeting(), contains(c.refused));
        else
            CHECK_NOTHROW(meeting());
        link.close(std::chrono::seconds(2));
        const std::string reason = told.refusal();
        CHECK(reason.empty() == (c.refused == nullptr));
        CHECK_THAT(reason, contains(c.refused != nullptr ? c.refused : ""));
    }
    // A worker that a worker's certificate would give orders to.
    auto [mine, theirs] = net::link_pair();
    Certified link(std::move(mine), "worker");
    farm::Frame first;
    *first.mutable_hello() = farm::make_hello({});
    theirs->send(first);
    ReadingPeer told(*theirs);
    CHECK_THROWS_WITH(farm::meet(link, worker_hello(), {farm::COORDINATOR}),
                      contains("a coordinator with the certificate of a worker"));
    link.close(std::chrono::seconds(2));
    CHECK_THAT(told.refusal(), contains("a coordinator with the certificate of a worker"));
}

TEST_CASE("what is no hello is none, a refusal is passed on, and silence has an end",
          "[raytracer][farm]") {
    farm::Frame other;
    other.mutable_ping()->set_stamp(1);
    CHECK_THAT(refused(other).here, contains("its first frame was no hello"));
    farm::Frame refusal;
    refusal.mutable_refusal()->set_reason("no\nroom \x1b[31m");
    CHECK_THAT(refused(refusal).here, contains("no\\nroom \\x1b[31m"));
    auto [mine, theirs] = net::link_pair();
    CHECK_THROWS_WITH(
        farm::meet(*mine, farm::make_hello({}), {farm::WORKER}, std::chrono::milliseconds(50)),
        contains("no answer within 50 ms"));
    auto [here, there] = net::link_pair();
    there->close();
    CHECK_THROWS_WITH(
        farm::meet(*here, farm::make_hello({}), {farm::WORKER}, std::chrono::milliseconds(2000)),
        contains("the link ended"));
}

TEST_CASE("a picture's specification names no path, and gives the same view", "[raytracer][farm]") {
    scene::Scene scene = small_scene();
    scene.camera.look = "somewhere";
    scene.world.settings = "/secret/settings.toml";
    scene.world.classes = "/secret/classes.toml";
    scene.sun.altitude_deg.reset();
    scene.sun.azimuth_deg.reset();
    scene.sun.zone = "Europe/Ljubljana";
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {1.0 / 3, 40.1, 60};
    scene.camera.target = {0, 0, 1e-17};
    Job job(scene);
    const farm::PictureSpec spec = farm::pack(scene, job.world->info());
    CHECK(spec.scene.find("secret") == std::string::npos);
    CHECK(spec.scene.find("somewhere") == std::string::npos);
    CHECK_THAT(spec.scene, contains("zone = ''"));
    const shade::View view = farm::unpack(spec, job.world->info());
    const core::Vec3 a = view.camera.position(), b = job.view.camera.position();
    CHECK((a.x == b.x && a.y == b.y && a.z == b.z));
    const core::Vec3 s = view.sky.to_sun(), t = job.view.sky.to_sun();
    CHECK((s.x == t.x && s.y == t.y && s.z == t.z));
    CHECK(view.exposure_ev == job.view.exposure_ev);
}

TEST_CASE("a worker gets no definition of a coordinate reference system, and takes none",
          "[raytracer][farm][hostile]") {
    Job job(small_scene());
    voxel::WorldInfo world = job.world->info();
    world.crs = "EPSG:4326";
    world.crs_wkt = geo::Crs::from_text("EPSG:4326").wkt();
    const farm::PictureSpec spec = farm::pack(small_scene(), world);
    CHECK_THAT(spec.world, !contains("GEOGCRS"));
    // A coordinator that sends one, and a camera whose place would have to be found with it.
    const voxel::WorldInfo told = farm::unpack_world(voxel::world_to_json(world));
    CHECK(told.crs == "EPSG:4326");
    CHECK(told.crs_wkt.empty());
    CHECK(farm::pack_world(told) == farm::pack_world(world));
    farm::PictureSpec bad = spec;
    bad.scene =
        "[camera]\nspace = 'latlon'\nposition = [46.05, 14.5, 400]\ntarget = [46.06, 14.5, 300]\n";
    CHECK_NOTHROW(farm::unpack(bad, world));
    CHECK_THROWS_WITH(farm::unpack(bad, told), contains("is no place that EPSG:4326 can tell"));
}

TEST_CASE("texts from anywhere are no view without an error", "[raytracer][farm]") {
    Job job(small_scene());
    const farm::PictureSpec good = farm::pack(small_scene(), job.world->info());
    farm::PictureSpec bad = good;
    bad.scene = "[quality]\nsamples = -5";
    CHECK_THROWS_WITH(farm::unpack(bad, job.world->info()), contains("quality.samples"));
    bad = good;
    bad.scene = std::string(2 << 20, '#');
    CHECK_THROWS_WITH(farm::unpack(bad, job.world->info()), contains("longer than 1 MiB"));
    bad = good;
    bad.materials = "[nonsense]";
    CHECK_THROWS_WITH(farm::unpack(bad, job.world->info()), contains("is no material"));
}
