// How links end.

#include <grpcpp/create_channel_posix.h>

#include <cstdlib>
#include <future>

#include "raytracer/farm/net/farm.grpc.pb.h"
#include "raytracer/farm/net/handshake.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm/net/farm.hpp"
#include "tests/raytracer/farm/net/raw_peer.hpp"
#include "tests/raytracer/farm/net/said.hpp"
#include "tests/raytracer/farm/net/wire.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace std::chrono_literals;

namespace {

/// A peer with the token that ignores all limits: gRPC's own channel after the handshake.
std::shared_ptr<grpc::Channel> make_channel(const sockets::Address& address) {
    auto socket = sockets::connect_to(sockets::resolve(address, false).front(),
                                      std::chrono::steady_clock::now() + kLong);
    const auto deadline = std::chrono::steady_clock::now() + kLong;
    net::DiallerHandshake handshake(kToken);
    const auto write = [&](const net::Bytes& bytes) {
        sockets::write_all(socket.fd(), bytes.data(), bytes.size(), deadline);
    };
    std::array<std::byte, net::kHello_bytes> hello{};
    std::array<std::byte, net::kAnswer_bytes> answer{};
    write(handshake.hello());
    sockets::read_exactly(socket.fd(), hello.data(), hello.size(), deadline);
    write(handshake.prove(hello));
    sockets::read_exactly(socket.fd(), answer.data(), answer.size(), deadline);
    handshake.check(answer);
    grpc::ChannelArguments arguments;
    arguments.SetMaxSendMessageSize(-1);
    return grpc::CreateCustomInsecureChannelFromFd("farm", socket.release(), arguments);
}

/// Short times for links that are opened meanwhile.
struct TestTimes {
    TestTimes() { ::setenv("TERRAVOX_FARM_TEST", "1", 1); }
    ~TestTimes() { ::unsetenv("TERRAVOX_FARM_TEST"); }
    TestTimes(const TestTimes&) = delete;
    TestTimes& operator=(const TestTimes&) = delete;
};

/// Reads until the end.
/// @return number of frames
std::size_t drain(net::Link& link) {
    std::size_t count = 0;
    while (link.receive())
        ++count;
    return count;
}

}  // namespace

TEST_CASE("a link that is closed delivers all that was sent before", "[common][net][ends]") {
    const bool by_dialler = GENERATE(true, false);
    INFO((by_dialler ? "by the dialler" : "by the listener's end"));
    Farm farm;
    auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    auto& from = by_dialler ? dialled : accepted;
    auto& to = by_dialler ? accepted : dialled;
    for (std::uint64_t i = 0; i < 20; ++i)
        REQUIRE(from->send(done(i, 1 << 20)));
    auto count = std::async(std::launch::async, [&] { return drain(*to); });
    from->close(kLong);
    CHECK(count.get() == 20);
    CHECK_FALSE(from->send(ping(1)));
    CHECK_FALSE(to->send(ping(1)));
    CHECK_FALSE(from->receive());
    CHECK(from->why_ended().empty());
    CHECK(to->why_ended() == "the other end closed it");
    from->close();
    to->close();
}

TEST_CASE("a peer that takes nothing does not keep a closing link", "[common][net][ends]") {
    Farm farm;
    auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    for (std::uint64_t i = 0; i < 30; ++i)
        REQUIRE(dialled->send(done(i, 1 << 20)));
    dialled->close(100ms);
    CHECK_FALSE(dialled->receive());
    CHECK(drain(*accepted) < 30);
}

TEST_CASE("an abort ends both ends, whatever they wait for", "[common][net][ends]") {
    const bool by_dialler = GENERATE(true, false);
    INFO((by_dialler ? "by the dialler" : "by the listener's end"));
    Farm farm;
    auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    auto& from = by_dialler ? dialled : accepted;
    auto& to = by_dialler ? accepted : dialled;
    auto receiving = std::async(std::launch::async, [&] { return drain(*from); });
    auto sending = std::async(std::launch::async, [&] {
        std::uint64_t sent = 0;
        while (from->send(done(sent, 1 << 20)))
            ++sent;
        return sent;
    });
    // The queue is full, as nothing is read from it.
    while (from->traffic().sent_bytes == 0)
        std::this_thread::yield();
    from->abort();
    from->abort();
    CHECK(receiving.get() == 0);
    CHECK(sending.get() >= 1);
    CHECK(from->why_ended().empty());
    drain(*to);
    CHECK_FALSE(to->why_ended().empty());
    CHECK_FALSE(to->send(ping(1)));
}

TEST_CASE("send blocks while the queue is full, and continues when there is room",
          "[common][net][ends]") {
    Farm farm;
    auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    std::atomic<int> sent{0};
    auto sending = std::async(std::launch::async, [&] {
        for (std::uint64_t i = 0; i < 100; ++i, ++sent)
            if (!dialled->send(done(i, 1 << 20)))
                return false;
        dialled->close(kLong);
        return true;
    });
    // 32 MiB queued, 4 MiB read ahead, and what gRPC and the kernel hold: it cannot get through.
    const auto deadline = std::chrono::steady_clock::now() + kLong;
    while (sent < 33 && std::chrono::steady_clock::now() < deadline)
        std::this_thread::yield();
    CHECK(sent < 100);
    CHECK(drain(*accepted) == 100);
    CHECK(sending.get());
}

TEST_CASE("a frame that is too large ends the link, and not the process", "[common][net][ends]") {
    Farm farm;
    SECTION("at the sender") {
        auto [dialled, accepted] = farm.pair();
        REQUIRE(accepted);
        REQUIRE(dialled->send(done(1, net::kMaxFrame_bytes - 64)));
        REQUIRE(accepted->receive());
        CHECK_FALSE(dialled->send(done(1, net::kMaxFrame_bytes)));
        CHECK_THAT(dialled->why_ended(), contains("allowed: at most 16777216"));
        CHECK_FALSE(dialled->receive());
        CHECK_FALSE(accepted->receive());
    }
    SECTION("at the receiver") {
        auto channel = make_channel(farm.address());
        auto stub = farm::Farm::NewStub(channel);
        grpc::ClientContext context;
        auto stream = stub->Join(&context);
        auto accepted = farm.arrivals().next();
        REQUIRE(accepted);
        CHECK(stream->Write(done(1, net::kMaxFrame_bytes - 64)));
        CHECK(accepted->receive());
        stream->Write(done(1, net::kMaxFrame_bytes));
        CHECK_FALSE(accepted->receive());
        CHECK_FALSE(accepted->why_ended().empty());
        farm::Frame none;
        CHECK_FALSE(stream->Read(&none));
        CHECK_FALSE(stream->Finish().ok());
    }
    const auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    REQUIRE(dialled->send(ping(7)));
    CHECK(accepted->receive()->ping().stamp() == 7);
}

TEST_CASE("frames of all sizes around a piece's arrive whole, and in order",
          "[common][net][ends]") {
    Farm farm;
    const auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    constexpr std::size_t kPiece_bytes = 64 << 10;
    std::vector<std::size_t> sizes{0, 1};
    for (const std::size_t pieces : {1, 2, 5})
        for (int more = -40; more <= 40; ++more)
            sizes.push_back(pieces * kPiece_bytes + static_cast<std::size_t>(more));
    auto sending = std::async(std::launch::async, [&link = *dialled, &sizes] {
        for (std::uint64_t i = 0; i < sizes.size(); ++i)
            if (!link.send(done(i, sizes[i])))
                return false;
        return true;
    });
    for (std::uint64_t i = 0; i < sizes.size(); ++i) {
        const auto frame = accepted->receive();
        INFO("frame " << i << " of " << sizes[i] << " bytes");
        REQUIRE(frame);
        REQUIRE(frame->done().id() == i);
        REQUIRE(frame->done().result() == std::string(sizes[i], static_cast<char>('a' + i % 26)));
    }
    CHECK(sending.get());
    CHECK(dialled->traffic().sent_bytes == accepted->traffic().received_bytes);
}

TEST_CASE("pieces that are no frame end the link", "[common][net][ends]") {
    const auto piece = [](const std::string& part, bool last) {
        farm::Frame frame;
        frame.mutable_piece()->set_part(part);
        frame.mutable_piece()->set_last(last);
        return frame;
    };
    struct Case {
        const char* name;
        std::vector<farm::Frame> says;
        const char* why;
    };
    for (const Case& c :
         {Case{"an empty one", {piece("", false)}, "nothing in it"},
          Case{"an empty one at the end", {piece("ab", false), piece("", true)}, "nothing in it"},
          Case{"another frame between them", {piece("ab", false), ping(1)}, "cannot be read"},
          Case{"garbage", {piece("\xff\xff", false), piece("\xff", true)}, "cannot be read"},
          Case{"pieces of a piece",
               {piece(piece(ping(1).SerializeAsString(), true).SerializeAsString(), true)},
               "cannot be read"},
          Case{"more than a frame may have",
               std::vector<farm::Frame>(17, piece(std::string(1 << 20, 'x'), false)),
               "more than 16777216 bytes"}}) {
        INFO(c.name);
        Farm farm;
        auto stub = farm::Farm::NewStub(make_channel(farm.address()));
        grpc::ClientContext context;
        auto stream = stub->Join(&context);
        auto accepted = farm.arrivals().next();
        REQUIRE(accepted);
        auto received =
            std::async(std::launch::async, [&] { return accepted->receive().has_value(); });
        for (const auto& frame : c.says)
            if (!stream->Write(frame))
                break;
        CHECK_FALSE(received.get());
        CHECK_THAT(accepted->why_ended(), contains(c.why));
        context.TryCancel();
        CHECK_FALSE(stream->Finish().ok());
    }
}

TEST_CASE("a connection carries one call", "[common][net][ends]") {
    const Said said;
    Farm farm;
    auto channel = make_channel(farm.address());
    auto stub = farm::Farm::NewStub(channel);
    {
        grpc::ClientContext context;
        auto stream = stub->Join(&context);
        auto accepted = farm.arrivals().next();
        REQUIRE(accepted);
        stream->WritesDone();
        CHECK_FALSE(accepted->receive());
        CHECK(stream->Finish().ok());
    }
    grpc::ClientContext context;
    auto stream = stub->Join(&context);
    CHECK(stream->Finish().error_code() == grpc::StatusCode::PERMISSION_DENIED);
}

TEST_CASE("a link whose connection is reset ends at once", "[common][net][ends]") {
    Farm farm;
    Wire wire(farm.address());
    auto dialled = net::dial(wire.address(), farm.credentials(), kLong);
    auto accepted = farm.arrivals().next();
    REQUIRE(accepted);
    REQUIRE(dialled->send(ping(1)));
    REQUIRE(accepted->receive());
    wire.cut();
    CHECK_FALSE(accepted->receive());
    CHECK_FALSE(dialled->receive());
    CHECK_FALSE(accepted->send(ping(1)));
    CHECK_FALSE(dialled->send(ping(1)));
    CHECK_FALSE(accepted->why_ended().empty());
    CHECK_FALSE(dialled->why_ended().empty());
}

TEST_CASE("a peer behind a dead wire is found by its silence", "[common][net][ends]") {
    ::setenv("TERRAVOX_FARM_TEST", "1", 1);
    Farm farm;
    Wire wire(farm.address());
    auto dialled = net::dial(wire.address(), farm.credentials(), kLong);
    ::unsetenv("TERRAVOX_FARM_TEST");
    auto accepted = farm.arrivals().next();
    REQUIRE(accepted);
    wire.stop();
    auto other = std::async(std::launch::async, [&] { return drain(*dialled); });
    CHECK_FALSE(accepted->receive());
    CHECK(other.get() == 0);
    CHECK_FALSE(accepted->why_ended().empty());
    CHECK_FALSE(dialled->why_ended().empty());
}

TEST_CASE("a peer that reads nothing ends a link whose queue is full", "[common][net][ends]") {
    const TestTimes times;
    Farm farm;
    const auto [dialled, accepted] = farm.pair();
    REQUIRE(accepted);
    std::uint64_t sent = 0;
    while (sent < 1000 && dialled->send(done(sent, 1 << 20)))
        ++sent;
    CHECK(sent >= 32);
    CHECK(sent < 1000);
    CHECK(dialled->traffic().queued_bytes <= 1 << 20);  // data that gRPC has not released yet
    CHECK(dialled->why_ended() == "it took nothing for 2 s");
}

TEST_CASE("a slow peer ends no link, however long a frame takes", "[common][net][ends]") {
    const TestTimes times;
    Farm farm;
    Wire wire(farm.address());
    auto dialled = net::dial(wire.address(), farm.credentials(), kLong);
    auto accepted = farm.arrivals().next();
    REQUIRE(accepted);
    wire.slow(3 << 20);
    // Until the queue has room again 13 MiB must be on their way, one frame nearly: more than twice
    // as long as a stuck peer is given.
    for (std::uint64_t i = 0; i < 4; ++i) {
        INFO("frame " << i << ": " << dialled->why_ended());
        if (i == 3) {
            CHECK(dialled->traffic().queued_bytes > 32 << 20);
            auto reading = std::async(std::launch::async, [&] { return drain(*accepted); });
            const bool went = dialled->send(done(i, 15 << 20));
            dialled->abort();
            CHECK(reading.get() <= 1);
            REQUIRE(went);
        } else {
            REQUIRE(dialled->send(done(i, 15 << 20)));
        }
    }
}

TEST_CASE("a listener stops while links live", "[common][net][ends]") {
    std::atomic<int> ended{0};
    std::vector<std::unique_ptr<net::Link>> dialled;
    {
        net::Listener listener({.host = "127.0.0.1", .port = 0},
                               {.token = kToken, .ca = {}, .certificate = {}, .key = {}},
                               [&](std::unique_ptr<net::Link> link) {
                                   drain(*link);
                                   ++ended;
                               });
        for (int i = 0; i < 20; ++i)
            dialled.push_back(net::dial({.host = "127.0.0.1", .port = listener.port()},
                                        {.token = kToken, .ca = {}, .certificate = {}, .key = {}},
                                        kLong));
        for (auto& link : dialled)
            REQUIRE(link->send(ping(1)));
        listener.stop();
        CHECK(ended == 20);
        listener.stop();
        CHECK_THROWS_WITH(
            net::dial({.host = "127.0.0.1", .port = listener.port()},
                      {.token = kToken, .ca = {}, .certificate = {}, .key = {}}, kLong),
            contains("Connection refused"));
    }
    for (auto& link : dialled) {
        CHECK_FALSE(link->receive());
        CHECK_FALSE(link->send(ping(2)));
    }
}

TEST_CASE("an error of a link's user ends this link alone", "[common][net][ends]") {
    const Said said;
    int links = 0;
    net::Listener listener({.host = "127.0.0.1", .port = 0},
                           {.token = kToken, .ca = {}, .certificate = {}, .key = {}},
                           [&](std::unique_ptr<net::Link> link) {
                               if (++links == 1)
                                   throw util::Error("serve this one: no");
                               if (link->receive())
                                   static_cast<void>(link->send(ping(8)));
                               link->close(kLong);
                           });
    const auto dial = [&] {
        return net::dial({.host = "127.0.0.1", .port = listener.port()},
                         {.token = kToken, .ca = {}, .certificate = {}, .key = {}}, kLong);
    };
    bool ended = false;
    try {
        const auto first = dial();
        ended = !first->receive();
    } catch (const net::RefusedError&) {
    } catch (const util::Error&) {
        ended = true;  // before the dialler had heard of its beginning
    }
    CHECK(ended);
    CHECK(said.hears("serve this one: no"));
    auto second = dial();
    REQUIRE(second->send(ping(1)));
    CHECK(second->receive()->ping().stamp() == 8);
}
