// Links that authenticate with certificates.

#include <grpcpp/create_channel.h>
#include <grpcpp/server_builder.h>

#include <fstream>
#include <future>
#include <iterator>

#include "raytracer/farm/net/certificates.hpp"
#include "raytracer/farm/net/credentials.hpp"
#include "raytracer/farm/net/farm.grpc.pb.h"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/farm/net/expired.hpp"
#include "tests/raytracer/farm/net/farm.hpp"
#include "tests/raytracer/farm/net/raw_peer.hpp"
#include "tests/raytracer/farm/net/said.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

net::Credentials tls_credentials(const fs::path& folder, const std::string& name) {
    return {.token = {},
            .ca = folder / "ca.pem",
            .certificate = folder / (name + ".pem"),
            .key = folder / (name + ".key")};
}

std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

net::ListenerLimits quick() {
    net::ListenerLimits limits;
    limits.handshake = 500ms;
    return limits;
}

/// What becomes of a dialler of gRPC's own, which checks nothing beforehand.
grpc::Status join_with(const sockets::Address& address,
                       const grpc::SslCredentialsOptions& options) {
    grpc::ChannelArguments arguments;
    arguments.SetSslTargetNameOverride("terravox-farm");
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    auto stub = farm::Farm::NewStub(grpc::CreateCustomChannel(
        "ipv4:" + address.text(), grpc::SslCredentials(options), arguments));
    grpc::ClientContext context;
    auto stream = stub->Join(&context);
    farm::Frame none;
    CHECK_FALSE(stream->Read(&none));
    return stream->Finish();
}

struct Certs {
    TemporaryFolder folder;
    fs::path ours = folder.path() / "ours", theirs = folder.path() / "theirs";
    Certs() {
        net::make_certs(ours, {}, 30);
        net::make_certs(theirs, {}, 30);
    }
};

}  // namespace

TEST_CASE("certificates of one CA make a link", "[common][net][tls]") {
    const Certs certs;
    Farm farm(tls_credentials(certs.ours, "coordinator"));
    auto dialled = net::dial({.host = "localhost", .port = farm.address().port},
                             tls_credentials(certs.ours, "worker"), kLong);
    auto accepted = farm.arrivals().next();
    REQUIRE(accepted);
    CHECK(dialled->peer() == farm.address().text());
    CHECK_THAT(accepted->peer(), contains("127.0.0.1:"));
    for (std::uint64_t i = 0; i < 50; ++i) {
        const bool sent = dialled->send(done(i, 1 << 20)) && accepted->send(done(i + 7, 100'000));
        const auto there = accepted->receive(), back = dialled->receive();
        INFO("frame " << i << ": " << dialled->why_ended() << " / " << accepted->why_ended());
        REQUIRE(sent);
        REQUIRE((there && back));
        REQUIRE((there->done().id() == i && back->done().id() == i + 7));
    }
    auto rest = std::async(std::launch::async, [&] { return accepted->receive().has_value(); });
    dialled->close(kLong);
    CHECK_FALSE(rest.get());
    CHECK(accepted->why_ended() == "the other end closed it");
    // Each link has a connection of its own.
    auto second = farm.pair(), third = farm.pair();
    REQUIRE((second.accepted && third.accepted));
    CHECK(second.accepted->peer() != third.accepted->peer());
}

TEST_CASE("a listener refuses a peer without a certificate of its CA", "[common][net][tls]") {
    const Said said;
    const Certs certs;
    Farm farm(tls_credentials(certs.ours, "coordinator"));
    const std::string ca = read(certs.ours / "ca.pem");
    SECTION("none at all") {
        const auto status = join_with(
            farm.address(), {.pem_root_certs = ca, .pem_private_key = {}, .pem_cert_chain = {}});
        CHECK_FALSE(status.ok());
        CHECK(said.hears("it showed no certificate of this farm"));
    }
    SECTION("one of another CA") {
        const auto status =
            join_with(farm.address(), {.pem_root_certs = ca,
                                       .pem_private_key = read(certs.theirs / "worker.key"),
                                       .pem_cert_chain = read(certs.theirs / "worker.pem")});
        CHECK_FALSE(status.ok());
        CHECK(said.hears("it showed no certificate of this farm"));
    }
    SECTION("one that has expired") {
        const auto [certificate, key] = made_by(certs.ours, "terravox-farm", -1);
        const auto status = join_with(
            farm.address(),
            {.pem_root_certs = ca, .pem_private_key = key, .pem_cert_chain = certificate});
        CHECK_FALSE(status.ok());
        CHECK(said.hears("it showed no certificate of this farm"));
    }
    SECTION("one for something else") {
        const auto [certificate, key] = made_by(certs.ours, "mail.example.org", 30);
        const auto status = join_with(
            farm.address(),
            {.pem_root_certs = ca, .pem_private_key = key, .pem_cert_chain = certificate});
        CHECK(status.error_code() == grpc::StatusCode::PERMISSION_DENIED);
        CHECK(said.hears("its certificate does not carry the name terravox-farm"));
    }
    CHECK_FALSE(farm.arrivals().next(0ms));
    const auto [dialled, accepted] = farm.pair();
    CHECK(accepted);
}

TEST_CASE("a dialler whose certificate the listener refuses gets the reason",
          "[common][net][tls]") {
    const Said said;
    const Certs certs;
    Farm farm(tls_credentials(certs.ours, "coordinator"));
    // It trusts both CAs, and has a certificate of the wrong one.
    const auto both = certs.folder.path() / "both.pem";
    std::ofstream(both) << read(certs.ours / "ca.pem") << read(certs.theirs / "ca.pem");
    auto some = tls_credentials(certs.theirs, "worker");
    some.ca = both;
    const auto dial = [&] { static_cast<void>(net::dial(farm.address(), some, kLong)); };
    CHECK_THROWS_AS(dial(), util::Error);
    CHECK_THROWS_WITH(dial(),
                      contains("it closed the connection when it had seen the certificate"));
    CHECK(said.hears("it showed no certificate of this farm"));
    // One that has expired is not even tried.
    const auto [certificate, key] = made_by(certs.ours, "terravox-farm", -1);
    std::ofstream(certs.ours / "old.pem") << certificate;
    std::ofstream(certs.ours / "old.key") << key;
    some = tls_credentials(certs.ours, "old");
    CHECK_THROWS_AS(dial(), net::RefusedError);
    CHECK_THROWS_WITH(dial(), contains("old.pem: certificate has expired"));
}

TEST_CASE("a dialler refuses a listener with an invalid certificate", "[common][net][tls]") {
    const Said said;
    const Certs certs;
    struct Case {
        const char* name;
        const char* host;
        int days;
        const char* why;
    };
    for (const Case c : {Case{"expired", "terravox-farm", -1, "certificate verify failed"},
                         Case{"for something else", "mail.example.org", 30, "terravox-farm"}}) {
        INFO(c.name);
        const auto [certificate, key] = made_by(certs.ours, c.host, c.days);
        grpc::SslServerCredentialsOptions options;
        options.pem_root_certs = read(certs.ours / "ca.pem");
        options.pem_key_cert_pairs.push_back({key, certificate});
        farm::Farm::Service service;
        grpc::ServerBuilder builder;
        int port = 0;
        builder.AddListeningPort("127.0.0.1:0", grpc::SslServerCredentials(options), &port);
        builder.RegisterService(&service);
        const auto server = builder.BuildAndStart();
        REQUIRE(server);
        const auto dial = [&] {
            static_cast<void>(
                net::dial({.host = "127.0.0.1", .port = static_cast<std::uint16_t>(port)},
                          tls_credentials(certs.ours, "worker"), kLong));
        };
        CHECK_THROWS_AS(dial(), net::RefusedError);
        CHECK_THROWS_WITH(dial(), contains(c.why));
        server->Shutdown();
    }
}

TEST_CASE("each end checks the role in the other's certificate, and refuses one without a role",
          "[common][net][tls]") {
    const Said said;
    const Certs certs;
    Farm farm(tls_credentials(certs.ours, "coordinator"));
    const auto dialled = net::dial(farm.address(), tls_credentials(certs.ours, "worker"), kLong);
    const auto accepted = farm.arrivals().next();
    REQUIRE(accepted);
    CHECK(dialled->certified_role() == "coordinator");
    CHECK(accepted->certified_role() == "worker");
    const auto [certificate, key] = made_by(certs.ours, "terravox-farm", 30);
    const std::string ca = read(certs.ours / "ca.pem");
    const auto status =
        join_with(farm.address(),
                  {.pem_root_certs = ca, .pem_private_key = key, .pem_cert_chain = certificate});
    CHECK(status.error_code() == grpc::StatusCode::PERMISSION_DENIED);
    CHECK(said.hears("its certificate names no role"));
    std::ofstream(certs.ours / "old.pem") << certificate;
    std::ofstream(certs.ours / "old.key") << key;
    CHECK_THROWS_WITH(net::dial(farm.address(), tls_credentials(certs.ours, "old"), kLong),
                      contains("old.pem: it names no role"));
    Farm plain;
    CHECK(plain.pair().accepted->certified_role().empty());
}

TEST_CASE("a certificate that is revoked is refused from then on, at both ends",
          "[common][net][tls]") {
    const Said said;
    const Certs certs;
    Farm farm(tls_credentials(certs.ours, "coordinator"));
    net::make_certs(certs.ours, {"second"}, 30);
    const auto dial = [&](const char* name) {
        return net::dial(farm.address(), tls_credentials(certs.ours, name), kLong);
    };
    CHECK(dial("worker"));
    net::revoke_certs(certs.ours, {"worker"});
    CHECK_THROWS_AS(dial("worker"), net::RefusedError);
    CHECK_THROWS_WITH(dial("worker"), contains("its certificate is revoked"));
    CHECK(said.hears("its certificate is revoked"));
    CHECK(dial("second"));
    SECTION("a listener's") {
        net::revoke_certs(certs.ours, {"coordinator"});
        CHECK_THROWS_AS(dial("second"), net::RefusedError);
        CHECK_THROWS_WITH(dial("second"), contains("its certificate is revoked"));
        CHECK_THROWS_WITH(dial("worker"),
                          contains("its certificate is revoked"));  // the list has both
    }
    SECTION("with a list that cannot be read no peer is admitted") {
        std::ofstream(certs.ours / "ca.crl") << "nonsense";
        CHECK_THROWS_WITH(dial("second"), contains("no PEM of an X.509 CRL"));
    }
    SECTION("with a list of another CA no peer is admitted") {
        net::revoke_certs(certs.theirs, {"worker"});
        fs::copy_file(certs.theirs / "ca.crl", certs.ours / "ca.crl",
                      fs::copy_options::overwrite_existing);
        CHECK_THROWS_WITH(dial("second"), contains("has not signed it"));
    }
}

TEST_CASE("each end of a link that is there sees that the other's certificate is revoked",
          "[common][net][tls]") {
    const Said said;
    const Certs certs;
    Farm farm(tls_credentials(certs.ours, "coordinator"));
    net::make_certs(certs.ours, {"second"}, 30);
    const fs::path list = certs.ours / "ca.crl";
    const auto dial = [&](const char* name) {
        Farm::Pair out;
        out.dialled = net::dial(farm.address(), tls_credentials(certs.ours, name), kLong);
        out.accepted = farm.arrivals().next();
        REQUIRE(out.accepted);
        return out;
    };
    const auto first = dial("worker"), second = dial("second");
    CHECK(first.accepted->certified_name() == "worker");
    CHECK(first.dialled->certified_name() == "coordinator");
    CHECK_FALSE((first.dialled->is_revoked() || first.accepted->is_revoked()));
    SECTION("a dialler's") {
        net::revoke_certs(certs.ours, {"worker"});
        CHECK(first.accepted->is_revoked());
        CHECK_FALSE((first.dialled->is_revoked() || second.accepted->is_revoked() ||
                     second.dialled->is_revoked()));
        // The list is looked at again each time that it changes.
        net::revoke_certs(certs.ours, {"second"});
        CHECK((first.accepted->is_revoked() && second.accepted->is_revoked()));
        CHECK_FALSE((first.dialled->is_revoked() || second.dialled->is_revoked()));
    }
    SECTION("a listener's") {
        net::revoke_certs(certs.ours, {"coordinator"});
        CHECK((first.dialled->is_revoked() && second.dialled->is_revoked()));
        CHECK_FALSE((first.accepted->is_revoked() || second.accepted->is_revoked()));
    }
    SECTION("after a list that could not be read, as while it is copied") {
        net::revoke_certs(certs.ours, {"worker"});
        const std::string whole = read(list);
        std::ofstream(list) << whole.substr(0, whole.size() / 2);
        CHECK_FALSE(first.accepted->is_revoked());
        CHECK_FALSE(first.accepted->is_revoked());
        CHECK_THAT(said.all(), contains("no PEM of an X.509 CRL; links that are there go on"));
        std::ofstream(list) << whole;
        CHECK(first.accepted->is_revoked());
        CHECK_FALSE(second.accepted->is_revoked());
    }
    SECTION("by no list of another CA") {
        net::revoke_certs(certs.theirs, {"worker"});
        fs::copy_file(certs.theirs / "ca.crl", list);
        CHECK_FALSE(first.accepted->is_revoked());
        CHECK_THAT(said.all(), contains("has not signed it; links that are there go on"));
    }
}

TEST_CASE("a token and certificates do not match, and both sides report that",
          "[common][net][tls]") {
    const Said said;
    const Certs certs;
    SECTION("a dialler with a token") {
        Farm farm(tls_credentials(certs.ours, "coordinator"));
        const auto dial = [&] {
            static_cast<void>(net::dial(
                farm.address(), {.token = kToken, .ca = {}, .certificate = {}, .key = {}}, kLong));
        };
        CHECK_THROWS_AS(dial(), net::RefusedError);
        CHECK_THROWS_WITH(dial(), contains("it takes certificates, and no token"));
        CHECK(said.hears("it has a token; certificates are required here"));
    }
    SECTION("a dialler with certificates") {
        Farm farm;
        const auto dial = [&] {
            static_cast<void>(
                net::dial(farm.address(), tls_credentials(certs.ours, "worker"), kLong));
        };
        CHECK_THROWS_AS(dial(), net::RefusedError);
        CHECK_THROWS_WITH(dial(),
                          contains("connect to " + farm.address().text()) && contains("handshake"));
        CHECK(said.hears("it begins TLS; a token is required here"));
    }
}

TEST_CASE("no listener, or no answer: not a refusal", "[common][net][tls]") {
    const Certs certs;
    sockets::Address gone;
    {
        Farm farm(tls_credentials(certs.ours, "coordinator"));
        gone = farm.address();
    }
    const auto fails_for_now = [&](const sockets::Address& address,
                                   std::chrono::milliseconds timeout) {
        try {
            static_cast<void>(net::dial(address, tls_credentials(certs.ours, "worker"), timeout));
        } catch (const net::RefusedError& e) {
            FAIL(e.what());
        } catch (const util::Error& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    CHECK_THAT(fails_for_now(gone, kLong),
               contains("connect to " + gone.text()) && contains("refused"));
    const auto silent = sockets::listen_at({.host = "127.0.0.1", .port = 0});
    CHECK_THAT(fails_for_now(bound_address(silent.front()), 200ms), contains("connect to "));
}

TEST_CASE("strangers at a listener with certificates", "[common][net][tls]") {
    const Said said;
    const Certs certs;
    Farm farm(tls_credentials(certs.ours, "coordinator"), quick());
    const std::string begun("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11);
    struct Case {
        const char* name;
        std::string says;
        const char* why;
    };
    for (const Case& c :
         {Case{"HTTP", "GET / HTTP/1.1\r\n\r\n", "no peer of a Terravox farm"},
          Case{"nothing", "", "it sent nothing within 500 ms"},
          Case{"TLS that is begun and no more", begun, "it showed no certificate of this farm"},
          Case{"garbage behind a good beginning", begun + std::string(5000, '\x7f'),
               "it showed no certificate"}}) {
        INFO(c.name);
        RawPeer peer(farm.address());
        if (!c.says.empty())
            peer.say(c.says);
        CHECK(peer.hear_all() != "(still open)");
        CHECK(said.hears(c.why));
    }
    CHECK(farm.works());
}
