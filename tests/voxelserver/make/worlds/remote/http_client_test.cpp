#include <algorithm>
#include <cstdlib>
#include <random>

#include "common/util/secret.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/worlds/remote/served_boxes.hpp"
#include "voxelserver/make/worlds/remote/http_client.hpp"
#include "voxelserver/make/worlds/remote/retry.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using terravox::test::BadServer;
using terravox::test::contains;
using terravox::test::Deed;
using terravox::test::problem;

namespace {

const std::string kToken = "a-token-of-a-server-93e1b7a05c2f";

BadServer::Script always(const Deed& deed) {
    return [deed](const std::string&, int) { return deed; };
}

Deed to(const std::string& location, int status = 302) {
    return {.status = status, .headers = "Location: " + location + "\r\n"};
}

/// The Authorization of each request, "" where it has none.
std::vector<std::string> shown_to(const BadServer& server) {
    std::vector<std::string> out;
    for (const std::string& head : server.heads()) {
        const auto at = head.find("\r\nAuthorization: ");
        out.push_back(at == std::string::npos
                          ? ""
                          : head.substr(at + 17, head.find("\r\n", at + 2) - at - 17));
    }
    return out;
}

remote::HttpAccess with_token(const std::string& origin) {
    return {remote::BoundToken(remote::HttpOrigin::parse(origin), kToken), std::nullopt};
}

/// "http://localhost:PORT" for "http://127.0.0.1:PORT".
std::string by_name(const BadServer& server) {
    return "http://localhost" + server.url().substr(server.url().rfind(':'));
}

/// A variable of the environment for as long as this lives.
class Variable {
public:
    Variable(const char* name, const std::string& value) : m_name(name) {
        ::setenv(name, value.c_str(), 1);
    }
    ~Variable() { ::unsetenv(m_name); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    const char* m_name;
};

const remote::Retry::Clock::time_point kStart{1000s};

}  // namespace

TEST_CASE("a token goes to the origin that it is bound to, with GET and POST, and to no other",
          "[raytracer][world][http]") {
    BadServer bound(always({}));
    BadServer other(always({}));
    remote::HttpClient client(with_token(bound.url()));
    for (const std::string& url : {bound.url(), other.url(), by_name(bound), by_name(other)}) {
        (void)client.get(url + "/a", {});
        (void)client.post(url + "/b", "{}", "text/none", {}, [](auto) {});
    }
    const std::string bearer = "Bearer " + kToken;
    CHECK(shown_to(bound) == std::vector<std::string>{bearer, bearer, "",
                                                      ""});  // by another name it is another origin
    CHECK(shown_to(other) == std::vector<std::string>(4));
    remote::HttpClient none;
    (void)none.get(bound.url(), {});
    CHECK(shown_to(bound).back().empty());
}

TEST_CASE("a token follows a redirect within its origin alone, and is not sent again when refused",
          "[raytracer][world][http]") {
    BadServer other(always({}));
    BadServer bound([&](const std::string& path, int) {
        if (path == "/away")
            return to(other.url() + "/here");
        return path == "/near" ? to("there") : problem(401, "WWW-Authenticate: Bearer\r\n");
    });
    remote::HttpClient client(with_token(bound.url()));
    const remote::HttpReply away = client.get(bound.url() + "/away", {});
    CHECK(away.status == 200);
    CHECK_FALSE(away.showed_token);
    CHECK(shown_to(other) == std::vector<std::string>{""});
    const remote::HttpReply refused = client.get(bound.url() + "/near", {});
    CHECK(refused.status == 401);
    CHECK(refused.showed_token);
    CHECK(bound.requests("/there") == 1);
    CHECK(shown_to(bound) == std::vector<std::string>(3, "Bearer " + kToken));
}

TEST_CASE("redirects are followed where they say a new address, up to a number of them",
          "[raytracer][world][http]") {
    BadServer other(always({.body = "the file"}));
    const std::string new_url = other.url() + "/new.tvx";
    struct Case {
        const char* name;
        Deed reply;
        int status;        ///< 0: an error
        std::string says;  ///< of the error, or the address that answered
    };
    const std::vector<Case> cases{
        {"301", to(new_url, 301), 200, new_url},
        {"302", to(new_url, 302), 200, new_url},
        {"303", to(new_url, 303), 200, new_url},
        {"307", to(new_url, 307), 200, new_url},
        {"308", to(new_url, 308), 200, new_url},
        {"a signature", to(new_url + "?hush=1"), 200, new_url},
        {"a choice of several", to(new_url, 300), 300, ""},
        {"a proxy", to(new_url, 305), 305, ""},
        {"nowhere", {.status = 302}, 0, "HTTP status 302: it leads nowhere"},
        {"a file", to("file:///etc/passwd"), 0, "it leads to 'file:///etc/passwd', not an address"},
        {"a user", to("http://me:hush@127.0.0.1/a"), 0, "'http://127.0.0.1/a', an address with a"},
        {"a circle", to("/old.tvx"), 0, "more than 5 redirects, the last to"},
        {"no server", to("http://127.0.0.1:1/a?hush"), 0, "redirected to http://127.0.0.1:1/a: "},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        BadServer server(always(c.reply));
        remote::HttpClient client;
        const std::string old_url = server.url() + "/old.tvx";
        if (c.status == 0) {
            CHECK_THROWS_WITH(client.get(old_url, {}),
                              contains(old_url) && contains(c.says) && !contains("hush"));
            CHECK(server.requests("/old.tvx") <= 1 + remote::HttpClient::kMaxRedirects);
            continue;
        }
        const remote::HttpReply reply = client.get(old_url, {});
        CHECK(reply.status == c.status);
        CHECK(reply.redirected_to == c.says);
    }
}

TEST_CASE("a redirect is judged like an address that is given, and its text does not count",
          "[raytracer][world][http]") {
    BadServer other(always({.body = "the file"}));
    BadServer server([&](const std::string&, int) {
        Deed out = to(other.url() + "/new.tvx");
        out.body = std::string(500, 'x');
        return out;
    });
    const remote::HttpLimits few{.bytes = 8};
    const remote::FilePart part{.range = "0-7", .condition = ""};
    CHECK(remote::HttpClient().get(server.url(), few, part).status == 200);
    CHECK(other.heads().back().find("Range: bytes=0-7") != std::string::npos);
    remote::HttpAccess access = remote::no_http_access();
    access.limits->private_origins = {remote::HttpOrigin::parse(server.url())};
    CHECK_THROWS_WITH(remote::HttpClient(access).get(server.url(), few, part),
                      contains("redirected to " + other.url()) && contains("allow_origins"));
    CHECK(other.heads().size() == 1);
    access.limits->private_origins.push_back(remote::HttpOrigin::parse(other.url()));
    CHECK(remote::HttpClient(access).get(server.url(), few, part).status == 200);
}

TEST_CASE("a token is bound to no origin that it would reach in clear text",
          "[raytracer][world][http]") {
    for (const char* good :
         {"https://voxels.example", "https://10.0.0.1:8443", "http://localhost:1",
          "http://127.0.0.1", "http://127.9.9.9:1", "http://[::1]:1"}) {
        INFO(good);
        CHECK(remote::BoundToken(remote::HttpOrigin::parse(good), kToken).origin() ==
              remote::HttpOrigin::parse(good));
    }
    for (const char* bad :
         {"http://voxels.example", "http://10.0.0.1:8080", "http://0.0.0.0:1",
          "http://localhost.example", "http://[::ffff:127.0.0.1]", "http://127.0.0.1.example"}) {
        INFO(bad);
        CHECK_THROWS_AS(remote::BoundToken(remote::HttpOrigin::parse(bad), kToken),
                        util::UsageError);
        CHECK_THROWS_WITH(remote::BoundToken(remote::HttpOrigin::parse(bad), kToken),
                          contains(remote::HttpOrigin::parse(bad).text()) &&
                              contains("clear text") && !contains(kToken));
    }
}

TEST_CASE("a token in clear text passes no proxy", "[raytracer][world][http]") {
    BadServer server(always({}));
    BadServer proxy(always({}));
    const Variable http_proxy("http_proxy", proxy.url()), no_proxy("no_proxy", "none.example");
    (void)remote::HttpClient(with_token(server.url())).get(server.url() + "/a", {});
    CHECK(proxy.heads().empty());
    CHECK(shown_to(server) == std::vector<std::string>{"Bearer " + kToken});
    // The proxy counts where nothing is secret, and nothing limits where it leads.
    (void)remote::HttpClient().get(server.url() + "/b", {});
    CHECK(shown_to(proxy) == std::vector<std::string>{""});
}

TEST_CASE("the environment binds a token to one origin, or to none", "[raytracer][world][http]") {
    ::unsetenv("TERRAVOX_TOKEN");
    ::unsetenv(util::kServerTokenVariable);
    ::unsetenv("TERRAVOX_SERVER_ORIGIN");
    CHECK_FALSE(remote::access_of_environment().token);
    const Variable farm(util::kFarmTokenVariable, "a-token-of-the-farm");
    CHECK_FALSE(remote::access_of_environment().token);
    {
        const Variable token(util::kServerTokenVariable, kToken);
        CHECK_FALSE(remote::access_of_environment().token);
        const Variable origin("TERRAVOX_SERVER_ORIGIN", "https://voxels.example");
        const remote::HttpAccess access = remote::access_of_environment();
        REQUIRE(access.token);
        CHECK(access.token->text() == kToken);
        CHECK(access.token->origin().text() == "https://voxels.example:443");
        CHECK_FALSE(access.limits);
        const Variable clear("TERRAVOX_SERVER_ORIGIN", "http://voxels.example");
        CHECK_THROWS_WITH(remote::access_of_environment(),
                          contains("TERRAVOX_SERVER_ORIGIN") && contains("clear text"));
        const Variable nonsense("TERRAVOX_SERVER_ORIGIN", "voxels.example");
        CHECK_THROWS_WITH(remote::access_of_environment(),
                          contains("TERRAVOX_SERVER_ORIGIN") && contains("'voxels.example'"));
    }
    const Variable origin("TERRAVOX_SERVER_ORIGIN", "https://voxels.example");
    CHECK_THROWS_AS(remote::access_of_environment(), util::UsageError);
    CHECK_THROWS_WITH(remote::access_of_environment(),
                      contains("TERRAVOX_SERVER_TOKEN is not set"));
    const Variable old("TERRAVOX_TOKEN", kToken);
    CHECK_THROWS_WITH(remote::access_of_environment(), contains("TERRAVOX_FARM_TOKEN"));
}

TEST_CASE(
    "a client with limits contacts the origins that they name, at the addresses that they allow",
    "[raytracer][world][http]") {
    BadServer server(always({}));
    const std::string number = server.url();
    const std::string name = by_name(server);
    const std::string port = number.substr(number.rfind(':'));
    const std::string of_none = "http://0.0.0.0" + port;
    const std::string within = "http://[::ffff:127.0.0.1]" + port;
    struct Case {
        const char* what;
        std::string url;
        std::string origin;  ///< "": none
        std::string private_origin;
        const char* refused;  ///< "": it is not
    };
    const std::vector<Case> cases{
        {"no origin", number, "", "",
         "may not be contacted from here; allowed: origins of allow_origins"},
        {"another port", number, "http://127.0.0.1:1", "http://127.0.0.1:2",
         "may not be contacted"},
        {"another scheme", number, "", "https" + number.substr(4), "may not be contacted"},
        {"another name of the same machine", name, "", number, "may not be contacted"},
        {"a name that leads to this machine", name, name, "", "it leads to "},
        {"a number of this machine", number, number, "", "it leads to 127.0.0.1"},
        {"a name that may lead to this machine", name, "", name, ""},
        {"a number that may be this machine's", number, "", number, ""},
        {"this machine by an address of none", of_none, "", of_none, "it leads to 0.0.0.0"},
        {"IPv4 within IPv6", within, "", within, "it leads to ::ffff:127.0.0.1"},
    };
    const Variable http_proxy("http_proxy", "http://127.0.0.1:1"),
        no_proxy("no_proxy", "none.example");  // no server is there
    for (const Case& c : cases) {
        INFO(c.what);
        remote::HttpAccess access = remote::no_http_access();
        if (!c.origin.empty())
            access.limits->origins.push_back(remote::HttpOrigin::parse(c.origin));
        if (!c.private_origin.empty())
            access.limits->private_origins.push_back(remote::HttpOrigin::parse(c.private_origin));
        const std::size_t before = server.heads().size();
        remote::HttpClient client(access);
        if (*c.refused == '\0') {
            CHECK(client.get(c.url, {}).status == 200);
            CHECK(server.heads().size() == before + 1);
        } else {
            CHECK_THROWS_WITH(client.get(c.url, {}), contains(c.refused));
            CHECK(server.heads().size() == before);
            // Another try would not help.
            try {
                (void)client.get(c.url, {});
            } catch (const util::Error& e) {
                CHECK(dynamic_cast<const remote::LostError*>(&e) == nullptr);
            }
        }
    }
}

TEST_CASE("each kind of failure is retried as often as is useful", "[raytracer][retry]") {
    struct Case {
        const char* name;
        remote::FailureKind kind;
        int tries;
        int hopeless_tries;
    };
    const auto c = GENERATE(values<Case>({
        {"lost", remote::FailureKind::kLost, 5, 1},
        {"failed", remote::FailureKind::kFailed, 3, 1},
        {"damaged", remote::FailureKind::kDamaged, 4, 1},
        {"busy", remote::FailureKind::kBusy, 1000, 1000},
    }));
    DYNAMIC_SECTION(c.name) {
        for (const bool is_reachable : {true, false}) {
            remote::Retry retry(kStart, 24h, is_reachable);
            int tries = 1;
            while (tries < 1000 && retry.wait_after(c.kind, kStart, std::nullopt, 0.5))
                ++tries;
            CHECK(tries == (is_reachable ? c.tries : c.hopeless_tries));
            CHECK(retry.tries() == (tries == 1000 ? 999 : tries));
        }
    }
}

TEST_CASE("waits grow up to a limit, and are spread", "[raytracer][retry]") {
    remote::Retry low(kStart, 24h), middle(kStart, 24h), high(kStart, 24h);
    remote::Retry::Milliseconds before{0};
    for (int i = 0; i < 20; ++i) {
        const auto a = *low.wait_after(remote::FailureKind::kBusy, kStart, std::nullopt, 0);
        const auto b = *middle.wait_after(remote::FailureKind::kBusy, kStart, std::nullopt, 0.5);
        const auto c = *high.wait_after(remote::FailureKind::kBusy, kStart, std::nullopt, 0.999);
        CHECK(a < b);
        CHECK(b < c);
        CHECK((b > before || b == 10s));
        CHECK(c <= 15s);
        before = b;
    }
    CHECK(before == 10s);
}

TEST_CASE("a server's wish is heeded, within reason", "[raytracer][retry]") {
    struct Case {
        const char* name;
        std::chrono::seconds wish;
        remote::Retry::Milliseconds least;
        remote::Retry::Milliseconds most;
    };
    const auto c = GENERATE(values<Case>({
        {"at once", 0s, 50ms, 150ms},
        {"a second", 1s, 1s, 1250ms},
        {"half a minute", 30s, 30s, 37500ms},
        {"an hour", 3600s, 60s, 75s},
        {"for ever", std::chrono::seconds::max(), 60s, 75s},
        {"in the past", std::chrono::seconds::min(), 50ms, 150ms},
    }));
    DYNAMIC_SECTION(c.name) {
        for (const double chance : {0.0, 0.3, 0.999999}) {
            remote::Retry retry(kStart, 24h);
            const auto wait = retry.wait_after(remote::FailureKind::kBusy, kStart, c.wish, chance);
            REQUIRE(wait);
            CHECK(*wait >= c.least);
            CHECK(*wait <= c.most);
        }
    }
}

TEST_CASE("no plan outlasts its timeout", "[raytracer][retry]") {
    std::mt19937 random(20260621);
    for (int run = 0; run < 2000; ++run) {
        const auto timeout = remote::Retry::Milliseconds(1 + static_cast<int>(random() % 400'000));
        INFO("run " << run << ", timeout " << timeout.count() << " ms");
        remote::Retry retry(kStart, timeout);
        auto now = kStart;
        int tries = 0;
        while (true) {
            const auto left = retry.time_left(now);
            CHECK(left >= 1ms);
            CHECK((now + left <= kStart + timeout || left == 1ms));
            now += std::min(left, remote::Retry::Milliseconds(static_cast<int>(random() % 20'000)));
            const auto wish = random() % 2 == 0
                                  ? std::nullopt
                                  : std::optional(std::chrono::seconds(random() % 100));
            const auto wait = retry.wait_after(remote::FailureKind::kBusy, now, wish,
                                               static_cast<double>(random() % 1000) / 1000);
            if (!wait)
                break;
            now += *wait;
            CHECK(now < kStart + timeout);
            REQUIRE(++tries < 10'000);
        }
    }
}
