// Which peers are admitted, and which are refused.

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <random>

#include "raytracer/farm/net/handshake.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/farm/net/farm.hpp"
#include "tests/raytracer/farm/net/raw_peer.hpp"
#include "tests/raytracer/farm/net/said.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace std::chrono_literals;

namespace {

net::Credentials token(const std::string& text) {
    return {.token = text, .ca = {}, .certificate = {}, .key = {}};
}

net::ListenerLimits handshake_within(std::chrono::milliseconds time) {
    net::ListenerLimits limits;
    limits.handshake = time;
    return limits;
}

std::string hear(RawPeer& peer, std::size_t size_bytes) {
    std::string out(size_bytes, '\0');
    sockets::read_exactly(peer.socket().fd(), out.data(), size_bytes,
                          std::chrono::steady_clock::now() + kLong);
    return out;
}

}  // namespace

TEST_CASE("a dialler with another token is refused for good, with the reason",
          "[common][net][strangers]") {
    const Said said;
    Farm farm;
    const auto dial = [&] {
        return net::dial(farm.address(), token("another-token-of-the-tests-5d81b07c"), kLong);
    };
    CHECK_THROWS_AS(dial(), net::RefusedError);
    CHECK_THROWS_WITH(dial(), contains("connect to " + farm.address().text() + ": wrong token"));
    CHECK(said.hears("farm: refused 127.0.0.1:"));
    CHECK(said.hears(": wrong token"));
    CHECK_FALSE(farm.arrivals().next(0ms));
    CHECK(farm.works());
}

TEST_CASE("a dialler waits no longer than its timeout", "[common][net][strangers]") {
    const auto silent = sockets::listen_at({.host = "127.0.0.1", .port = 0});
    CHECK_THROWS_WITH(net::dial(bound_address(silent.front()), token(kToken), 100ms),
                      contains("no answer in time"));
}

TEST_CASE("invalid credentials are reported before any attempt", "[common][net][strangers]") {
    struct Case {
        const char* name;
        net::Credentials credentials;
        const char* why;
        bool usage;
    };
    for (const Case& c :
         {Case{"none", {}, "there are none", true},
          Case{"both", {.token = kToken, .ca = "a", .certificate = "b", .key = "c"}, "both", true},
          Case{"two files",
               {.token = {}, .ca = "a", .certificate = {}, .key = "c"},
               "belong together",
               true},
          Case{"short", token("15-letters-and3"), "15 characters", true},
          Case{"no CA in it",
               {.token = {}, .ca = {}, .certificate = "b", .key = "c"},
               "belong together",
               true}}) {
        INFO(c.name);
        const auto listen = [&] {
            net::Listener({.host = "127.0.0.1", .port = 0}, c.credentials,
                          [](std::unique_ptr<net::Link>) {});
        };
        const auto dial = [&] {
            static_cast<void>(net::dial({.host = "127.0.0.1", .port = 1}, c.credentials, 1s));
        };
        CHECK_THROWS_WITH(listen(), contains(c.why));
        CHECK_THROWS_WITH(dial(), contains(c.why));
        if (c.usage)
            CHECK_THROWS_AS(dial(), util::UsageError);
    }
}

TEST_CASE("a port that is taken, and an address of another machine, are errors",
          "[common][net][strangers]") {
    Farm farm;
    const auto listen = [&](const sockets::Address& address) {
        net::Listener(address, token(kToken), [](std::unique_ptr<net::Link>) {});
    };
    CHECK_THROWS_WITH(listen(farm.address()),
                      contains("listen at " + farm.address().text() + ": Address already in use"));
    CHECK_THROWS_WITH(listen({.host = "192.0.2.7", .port = 0}), contains("listen at 192.0.2.7:0"));
}

TEST_CASE("a listener without a host is there for both families", "[common][net][strangers]") {
    net::Listener listener({.host = {}, .port = 0}, token(kToken),
                           [](std::unique_ptr<net::Link> link) {
                               if (link->receive())
                                   static_cast<void>(link->send(ping(9)));
                               link->close(kLong);
                           });
    int reached = 0;
    for (const char* host : {"127.0.0.1", "::1", "localhost"}) {
        INFO(host);
        std::unique_ptr<net::Link> link;
        try {
            link = net::dial({.host = host, .port = listener.port()}, token(kToken), kLong);
        } catch (const util::Error& e) {
            // A machine may have no IPv6.
            REQUIRE(std::string(host) == "::1");
            WARN(e.what());
            continue;
        }
        REQUIRE(link->send(ping(1)));
        CHECK(link->receive()->ping().stamp() == 9);
        ++reached;
    }
    CHECK(reached >= 2);
}

TEST_CASE("unauthorised peers are refused before a byte is parsed, with the reason in the log",
          "[common][net][strangers]") {
    const Said said;
    Farm farm(token(kToken), handshake_within(300ms));
    struct Case {
        const char* name;
        std::string says;
        const char* why;
    };
    for (const Case& c :
         {Case{"connects and closes", "", "without sending anything"},
          Case{"garbage", std::string(1000, '\x7f'), "no peer of a Terravox farm"},
          Case{"HTTP", "GET / HTTP/1.1\r\nHost: farm\r\n\r\n", "no peer of a Terravox farm"},
          Case{"gRPC", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", "no peer of a Terravox farm"},
          Case{"TLS", std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11),
               "it begins TLS; a token is required here"}}) {
        INFO(c.name);
        RawPeer peer(farm.address());
        if (!c.says.empty()) {
            peer.say(c.says);
            const bool tls = c.name == std::string("TLS");
            CHECK(peer.hear_all() == (tls ? std::string("\x15\x03\x01\x00\x02\x02\x28", 7)
                                          : ""));  // an alert: handshake_failure
        } else {
            peer.socket().close();
        }
        CHECK(said.hears(c.why));
    }
    SECTION("one that sends nothing") {
        RawPeer peer(farm.address());
        CHECK(peer.hear_all().empty());
        CHECK(said.hears("it sent nothing within 300 ms"));
    }
    SECTION("one that sends a byte now and then, without end") {
        // Each byte arrives well within the time for all of them. A listener that has no processor
        // for as long as the whole hello takes may miss the end of that time, but not every time;
        // one that gives each byte new time never ends any of them.
        const auto hello = net::DiallerHandshake(kToken).hello();
        const auto is_cut_off = [&] {
            RawPeer peer(farm.address());
            for (std::size_t i = 0; i + 1 < hello.size(); ++i) {
                if (!peer.say(std::span(hello).subspan(i, 1)))
                    return true;
                std::this_thread::sleep_for(100ms);
            }
            return false;
        };
        bool cut_off = false;
        for (int i = 0; i < 10 && !cut_off; ++i)
            cut_off = is_cut_off();
        CHECK(cut_off);
        CHECK(said.hears("too slow"));
    }
    SECTION("one that stops in the middle") {
        RawPeer peer(farm.address());
        peer.say(net::DiallerHandshake(kToken).hello());
        CHECK(peer.hear_all().size() == net::kHello_bytes);
        CHECK(said.hears("too slow"));
    }
    SECTION("one that has the token and then sends nothing") {
        RawPeer peer(farm.address());
        net::DiallerHandshake handshake(kToken);
        peer.say(handshake.hello());
        const std::string hello = hear(peer, net::kHello_bytes);
        peer.say(handshake.prove(
            std::span<const std::byte, net::kHello_bytes>(std::as_bytes(std::span(hello)))));
        CHECK(hear(peer, net::kAnswer_bytes)[0] == '\0');
        static_cast<void>(peer.hear_all());
        CHECK(said.hears("after the handshake"));
    }
    CHECK_FALSE(farm.arrivals().next(0ms));
    CHECK(farm.works());
}

TEST_CASE("random bytes at any point of the handshake admit no peer", "[common][net][strangers]") {
    const Said said;
    Farm farm;
    const unsigned seed = 20'260'101;
    INFO("seed " << seed);
    std::minstd_rand random(seed);
    for (int i = 0; i < 300; ++i) {
        RawPeer peer(farm.address());
        const auto hello = net::DiallerHandshake(kToken).hello();
        std::string bytes(reinterpret_cast<const char*>(hello.data()), hello.size());
        bytes.resize(random() % (bytes.size() + 1));
        while (random() % 50 != 0)
            bytes += static_cast<char>(random());
        peer.say(bytes);
        ::shutdown(peer.socket().fd(), SHUT_WR);
        const std::string heard = peer.hear_all();
        REQUIRE((heard.size() <= net::kHello_bytes || heard[net::kHello_bytes] != '\0'));
    }
    CHECK_FALSE(farm.arrivals().next(0ms));
    CHECK(farm.works());
}

TEST_CASE("no more connections are admitted than allowed, and room is given back",
          "[common][net][strangers]") {
    const Said said;
    const bool of_address = GENERATE(true, false);
    net::ListenerLimits limits;
    (of_address ? limits.connections_of_address : limits.connections) = 3;
    Farm farm(token(kToken), limits);
    std::vector<Farm::Pair> pairs;
    for (int i = 0; i < 3; ++i) {
        pairs.push_back(farm.pair());
        REQUIRE(pairs.back().accepted);
    }
    std::string why;
    try {
        static_cast<void>(farm.dial());
    } catch (const net::RefusedError&) {
        FAIL("another time it may do");
    } catch (const util::Error& e) {
        why = e.what();
    }
    CHECK_THAT(why, contains("no room for another connection"));
    CHECK(said.hears(of_address ? "no room for more than 3 connections of one address"
                                : "no room for more than 3 connections"));
    pairs.pop_back();
    // The place is free once the listener has seen the end of the link.
    CHECK(test::eventually([&] {
        try {
            return farm.dial() != nullptr;
        } catch (const util::Error&) {
            return false;
        }
    }));
}

TEST_CASE("with too many pending peers the oldest is closed, and an authorised one is admitted",
          "[common][net][strangers]") {
    const Said said;
    net::ListenerLimits limits = handshake_within(kLong);
    limits.handshakes = 4;
    Farm farm(token(kToken), limits);
    std::vector<std::unique_ptr<RawPeer>> strangers;
    for (int i = 0; i < 20; ++i) {
        strangers.push_back(std::make_unique<RawPeer>(farm.address()));
        CHECK(farm.works());
    }
    for (int i = 0; i < 16; ++i)
        CHECK(strangers[static_cast<std::size_t>(i)]->hear_all().empty());
    CHECK(said.hears("too many unauthenticated connections at once"));
}

TEST_CASE("thousands of idle connections and few descriptors: a peer is still admitted",
          "[common][net][strangers]") {
    const Said said;
    // The unauthorised peers are another process with descriptors of its own. Only calls that are
    // safe after a fork.
    int port_pipe[2] = {-1, -1}, ready_pipe[2] = {-1, -1};
    REQUIRE(::pipe(port_pipe) == 0);
    REQUIRE(::pipe(ready_pipe) == 0);
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    constexpr int kStrangers = 2000;
    if (child == 0) {
        ::close(port_pipe[1]);
        rlimit many{kStrangers + 100, kStrangers + 100};
        ::setrlimit(RLIMIT_NOFILE, &many);
        std::uint16_t port = 0;
        if (::read(port_pipe[0], &port, sizeof port) != sizeof port)
            ::_exit(1);
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(port);
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        int connected = 0;
        for (int i = 0; i < kStrangers; ++i) {
            const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
            if (fd >= 0 && ::connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0)
                ++connected;
        }
        if (::write(ready_pipe[1], &connected, sizeof connected) < 0)
            ::_exit(1);
        char end = 0;
        [[maybe_unused]] const ssize_t got =
            ::read(port_pipe[0], &end, 1);  // until the test is over
        ::_exit(0);
    }
    ::close(port_pipe[0]);
    ::close(ready_pipe[1]);
    rlimit before{};
    REQUIRE(::getrlimit(RLIMIT_NOFILE, &before) == 0);
    const rlimit few{256, before.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &few) == 0);
    {
        Farm farm(token(kToken), handshake_within(kLong));
        REQUIRE(farm.works());
        std::vector<sockets::Socket> hoard;
        for (;;) {
            sockets::Socket one(::open("/dev/null", O_RDONLY | O_CLOEXEC));
            if (!one)
                break;
            hoard.push_back(std::move(one));
        }
        const std::uint16_t port = farm.listener().port();
        REQUIRE(::write(port_pipe[1], &port, sizeof port) == sizeof port);
        int connected = 0;
        REQUIRE(::read(ready_pipe[0], &connected, sizeof connected) == sizeof connected);
        CHECK(connected == kStrangers);
        CHECK(said.hears("the limit of open files is reached"));
        hoard.clear();
        CHECK(farm.works());
    }
    ::setrlimit(RLIMIT_NOFILE, &before);
    ::close(port_pipe[1]);
    ::close(ready_pipe[0]);
    int status = 0;
    CHECK(::waitpid(child, &status, 0) == child);
    CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
}
