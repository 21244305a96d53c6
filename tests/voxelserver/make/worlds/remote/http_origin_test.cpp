#include "voxelserver/make/worlds/remote/http_access.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/un.h>
#include <sstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using terravox::test::contains;

namespace {

struct Number {
    explicit Number(const std::string& text) {
        const bool six = text.find(':') != std::string::npos;
        storage.ss_family = six ? AF_INET6 : AF_INET;
        void* to = six ? static_cast<void*>(&reinterpret_cast<sockaddr_in6&>(storage).sin6_addr)
                       : &reinterpret_cast<sockaddr_in&>(storage).sin_addr;
        REQUIRE(inet_pton(storage.ss_family, text.c_str(), to) == 1);
    }
    [[nodiscard]] const sockaddr& get() const { return reinterpret_cast<const sockaddr&>(storage); }
    sockaddr_storage storage{};
};

}  // namespace

TEST_CASE("an origin is scheme, host and port of an address, however that is written",
          "[raytracer][world][http]") {
    struct Case {
        const char *url, *origin;
    };
    const auto c = GENERATE(values<Case>({
        {"https://voxels.example", "https://voxels.example:443"},
        {"https://VOXELS.Example:443/", "https://voxels.example:443"},
        {"https://voxels.example/a/place.tvx", "https://voxels.example:443"},
        {"http://voxels.example", "http://voxels.example:80"},
        {"http://voxels.example:8080/v2", "http://voxels.example:8080"},
        {"http://127.0.0.1:1", "http://127.0.0.1:1"},
        {"http://2130706433/", "http://127.0.0.1:80"},
        {"http://0x7f.1/", "http://127.0.0.1:80"},
        {"http://[::1]:8888/", "http://[::1]:8888"},
        {"http://[fe80::1%25eth0]/", "http://[fe80::1%25eth0]:80"},
        {"https://voxels.example./", "https://voxels.example.:443"},
        {"https://voxels.example.evil.example", "https://voxels.example.evil.example:443"},
    }));
    CHECK(remote::HttpOrigin::of(c.url).text() == c.origin);
    CHECK(remote::HttpOrigin::parse(c.origin) == remote::HttpOrigin::of(c.url));
}

TEST_CASE("an address that may hold a secret is refused, and the secret is not shown",
          "[raytracer][world][http]") {
    struct Case {
        const char *url, *fault, *shown;
    };
    const auto c = GENERATE(values<Case>({
        {"http://host/a?hush", "a query in it", "'http://host/a'"},
        {"http://host?hush", "a query in it", "'http://host'"},
        {"http://host/a?", "a query in it", "'http://host/a'"},
        {"http://host/a#hush", "a fragment in it", "'http://host/a'"},
        {"http://host/#", "a fragment in it", "'http://host/'"},
        {"http://me:hush@host/a", "a user in it", "'http://host/a'"},
        {"http://hush@host", "a user in it", "'http://host'"},
        {"http://@host/", "a user in it", "'http://host/'"},
        {"http://me:hush@hush@host/", "a user in it", "'http://host/'"},
        {"http://me:hush@host:port/", "a user in it", "'http://host:port/'"},
        {"http://host:99999/?hush", "a query in it", "'http://host:99999/'"},
        {"ftp://me:hush@host/", "not an address", "'ftp://host/'"},
        {"http:///", "not an address", "'http:///'"},
        {"http://", "not an address", "'http://'"},
        {"http://a b/", "not an address", "'http://a b/'"},
        {"http://host\\@hush", "a user in it", "'http://hush'"},
        {"HTTP:host", "not an address", "'HTTP:host'"},
    }));
    INFO(c.url);
    CHECK_THROWS_AS(remote::HttpOrigin::of(c.url), util::UsageError);
    CHECK_THROWS_WITH(
        remote::HttpOrigin::of(c.url),
        contains(c.fault) && contains(c.shown) && contains("allowed: http(s)://host[:port]"));
    if (std::string(c.shown).find("hush") == std::string::npos)
        CHECK_THROWS_WITH(remote::HttpOrigin::of(c.url), !contains("hush"));
    CHECK_THROWS_AS(remote::HttpOrigin::parse(c.url), util::UsageError);
}

TEST_CASE("an origin has no path, and an address an end", "[raytracer][world][http]") {
    CHECK_NOTHROW(remote::HttpOrigin::parse("http://host/"));
    CHECK_THROWS_WITH(remote::HttpOrigin::parse("http://host/a"),
                      contains("a path in it") && contains("allowed: http(s)://host[:port]"));
    CHECK_NOTHROW(remote::HttpOrigin::of("http://host/" + std::string(2000, 'a')));
    CHECK_THROWS_WITH(remote::HttpOrigin::of("http://host/" + std::string(3000, 'a')),
                      contains("3012 bytes") && !contains(std::string(2100, 'a')));
}

TEST_CASE("a redirect leads to an address with or without a query, and never to clear text",
          "[raytracer][world][http]") {
    const auto from = remote::HttpOrigin::parse("https://old.example");
    const auto target = [&](const std::string& location) {
        return remote::redirect_target("fetch a", from, location).text();
    };
    CHECK(target("https://new.example/a") == "https://new.example:443");
    CHECK(target("https://new.example/a?b=http://c@d#e") == "https://new.example:443");
    CHECK(target("https://new.example:8443?b") == "https://new.example:8443");
    for (const char* bad :
         {"http://old.example/?hush", "http://new.example/a?hush", "ftp://new.example/?hush",
          "https://me:hush@new.example/", "/a?hush", "https://a b/?hush", ""}) {
        INFO(bad);
        CHECK_THROWS_WITH(target(bad), contains("fetch a: it leads ") && contains("allowed: ") &&
                                           !contains("hush"));
    }
    CHECK_NOTHROW(remote::redirect_target(
        "fetch a", remote::HttpOrigin::parse("http://old.example"), "http://new.example"));
}

TEST_CASE("a redirect leads to no more private a network than the one that it comes from",
          "[raytracer][world][http]") {
    using enum remote::AddressRange;
    const auto origin = remote::HttpOrigin::parse("https://new.example");
    remote::HttpAccess access;
    CHECK(access.ranges(origin, kPublic) == remote::AddressRanges{kPublic});
    CHECK(access.ranges(origin, kPrivate) == remote::AddressRanges{kPublic, kPrivate});
    CHECK(access.ranges(origin, remote::AddressRange::kNoMachine) ==
          remote::AddressRanges{kPublic});
    CHECK(access.ranges(origin, kLoopback) == remote::kAnyRange);
    // Limits name each origin, and where it may be.
    access = remote::no_http_access();
    CHECK(access.ranges(origin, kLoopback).empty());
    access.limits->private_origins = {origin};
    CHECK(access.ranges(origin, kPublic) == access.ranges(origin));
}

TEST_CASE("a host has the ranges of its resolved addresses, and a number its own",
          "[raytracer][world][http]") {
    // What is this machine alone, in any writing: workers elsewhere would contact themselves.
    for (const char* url : {"http://localhost:1", "http://LOCALHOST", "http://127.0.0.1",
                            "http://127.1", "http://2130706433", "http://0.0.0.0:8888",
                            "http://[::1]", "http://[::]", "http://[::ffff:127.0.0.1]"}) {
        INFO(url);
        const remote::AddressRanges ranges = remote::ranges_of_host(remote::HttpOrigin::of(url));
        CHECK((ranges.holds(remote::AddressRange::kLoopback) ||
               ranges.holds(remote::AddressRange::kNoMachine)));
    }
    for (const char* url :
         {"http://10.1.2.3", "http://8.8.8.8", "http://[fe80::1%25lo]", "http://[2600::1]"}) {
        INFO(url);
        const remote::AddressRanges ranges = remote::ranges_of_host(remote::HttpOrigin::of(url));
        CHECK((ranges.holds(remote::AddressRange::kPublic) ||
               ranges.holds(remote::AddressRange::kPrivate)));
        CHECK_FALSE(ranges.holds(remote::AddressRange::kLoopback));
        CHECK_FALSE(ranges.holds(remote::AddressRange::kNoMachine));
    }
    CHECK(remote::range_of_number(remote::HttpOrigin::of("http://10.1.2.3")) ==
          remote::AddressRange::kPrivate);
    CHECK(remote::range_of_number(remote::HttpOrigin::of("http://[::1]")) ==
          remote::AddressRange::kLoopback);
    CHECK_FALSE(remote::range_of_number(remote::HttpOrigin::of("http://localhost")));
}

TEST_CASE("an address belongs to the range that its number lies in", "[raytracer][world][http]") {
    struct Case {
        remote::AddressRange range;
        const char* numbers;
    };
    for (const Case& c : {
             Case{remote::AddressRange::kPublic,
                  "1.1.1.1 8.8.8.8 9.255.255.255 11.0.0.0 100.63.255.255 100.128.0.0 "
                  "126.255.255.255 128.0.0.0 169.253.255.255 172.15.255.255 172.32.0.0 "
                  "192.167.255.255 192.169.0.0 198.17.255.255 198.20.0.0 223.255.255.255 "
                  "2001:4860:4860::8888 2001:200:: 2600::1 3ffe:ffff::1"},
             Case{remote::AddressRange::kPrivate,
                  "10.0.0.0 10.255.255.255 172.16.0.0 172.31.255.255 192.168.0.0 192.168.255.255 "
                  "169.254.169.254 100.64.0.1 100.127.255.255 fc00::1 fdff:ffff::1 fe80::1 "
                  "febf::1"},
             Case{remote::AddressRange::kLoopback, "127.0.0.1 127.0.1.1 127.255.255.255 ::1"},
             Case{remote::AddressRange::kNoMachine,
                  "0.0.0.0 0.1.2.3 192.0.0.1 192.0.2.1 192.88.99.1 198.18.0.1 198.19.255.255 "
                  "198.51.100.1 203.0.113.1 224.0.0.1 239.255.255.255 240.0.0.1 255.255.255.255 "
                  ":: ::2 ::ffff:127.0.0.1 ::ffff:8.8.8.8 ::127.0.0.1 64:ff9b::7f00:1 2001::1 "
                  "2001:db8::1 2002:7f00:1:: 3fff::1 fec0::1 ff02::1 4000::1 1fff::1"},
         }) {
        std::istringstream numbers(c.numbers);
        for (std::string number; numbers >> number;) {
            INFO(number);
            CHECK(remote::make_range(Number(number).get()) == c.range);
        }
    }
    CHECK(remote::to_text(Number("127.0.0.1").get()) == "127.0.0.1");
    CHECK(remote::to_text(Number("fe80::1").get()) == "fe80::1");
    sockaddr local{};
    local.sa_family = AF_UNIX;
    CHECK(remote::make_range(local) == remote::AddressRange::kNoMachine);
}
