#include "raytracer/farm/net/certificates.hpp"

#include <sys/stat.h>

#include <fstream>
#include <iterator>
#include <map>

#include "raytracer/farm/net/credentials.hpp"
#include "raytracer/farm/net/openssl.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
namespace fs = std::filesystem;

namespace {

std::map<std::string, std::string> files_in(const fs::path& folder) {
    std::map<std::string, std::string> out;
    for (const auto& one : fs::directory_iterator(folder)) {
        if (!one.is_regular_file())
            continue;
        std::ifstream in(one.path(), std::ios::binary);
        out[one.path().filename().string()] = {std::istreambuf_iterator<char>(in), {}};
    }
    return out;
}

std::vector<std::string> list_names(const std::map<std::string, std::string>& files) {
    std::vector<std::string> out;
    for (const auto& [name, text] : files)
        out.push_back(name);
    return out;
}

net::Credentials credentials(const fs::path& folder, const std::string& name) {
    return {.token = {},
            .ca = folder / "ca.pem",
            .certificate = folder / (name + ".pem"),
            .key = folder / (name + ".key")};
}

mode_t read_mode(const fs::path& path) {
    struct stat facts{};
    REQUIRE(::stat(path.c_str(), &facts) == 0);
    return facts.st_mode & 0777;
}

}  // namespace

TEST_CASE("certificates for a farm are made at once", "[common][net][certs]") {
    const test::TemporaryFolder folder;
    const fs::path place = folder.path() / "farm" / "keys";
    net::make_certs(place, {}, 365);
    CHECK(list_names(files_in(place)) ==
          std::vector<std::string>{"ca.key", "ca.pem", "coordinator.key", "coordinator.pem",
                                   "worker.key", "worker.pem"});
    CHECK(read_mode(place) == 0700);
    for (const char* name : {"ca.key", "coordinator.key", "worker.key"})
        CHECK(read_mode(place / name) == 0600);
    for (const char* name : {"coordinator", "worker"}) {
        INFO(name);
        CHECK_NOTHROW(net::read_pem(credentials(place, name)));
        const auto chain = net::parse_certificates(files_in(place)[std::string(name) + ".pem"]);
        REQUIRE(chain.size() == 1);
        X509* certificate = chain.front().get();
        for (const char* host : {"terravox-farm", name})
            CHECK(X509_check_host(certificate, host, 0, 0, nullptr) == 1);
        CHECK(X509_check_host(certificate, "elsewhere", 0, 0, nullptr) == 0);
        CHECK(X509_check_ca(certificate) == 0);
        int days = 0, seconds = 0;
        REQUIRE(ASN1_TIME_diff(&days, &seconds, nullptr, X509_get0_notAfter(certificate)) == 1);
        CHECK((days == 364 || days == 365));
    }
}

TEST_CASE("a name can be added later, and nothing that is there is touched",
          "[common][net][certs]") {
    const test::TemporaryFolder folder;
    net::make_certs(folder.path(), {"a"}, 30);
    auto before = files_in(folder.path());
    net::make_certs(folder.path(), {"node-7.example.org"}, 30);
    auto after = files_in(folder.path());
    for (const auto& [name, text] : before)
        CHECK(after[name] == text);
    CHECK(after.size() == before.size() + 2);
    CHECK_NOTHROW(net::read_pem(credentials(folder.path(), "node-7.example.org")));
    before = after;
    CHECK_THROWS_WITH(net::make_certs(folder.path(), {"b", "a"}, 30), contains("a.pem is there"));
    CHECK(files_in(folder.path()) == before);
    fs::remove(folder.path() / "a.pem");
    CHECK_THROWS_WITH(net::make_certs(folder.path(), {"a"}, 30), contains("a.key is there"));
    fs::remove(folder.path() / "ca.key");
    CHECK_THROWS_WITH(net::make_certs(folder.path(), {"c"}, 30), contains("ca.pem without ca.key"));
}

TEST_CASE("a certificate that cannot be made leaves nothing behind", "[common][net][certs]") {
    const test::TemporaryFolder folder;
    // A folder of that name appears to be no file until it is written.
    std::ofstream(folder.path() / "ca.pem") << "no certificate\n";
    std::ofstream(folder.path() / "ca.key") << "no key\n";
    CHECK_THROWS_WITH(net::make_certs(folder.path(), {"a"}, 30),
                      contains("do not belong together"));
    CHECK(list_names(files_in(folder.path())) == std::vector<std::string>{"ca.key", "ca.pem"});
    CHECK_THROWS_WITH(net::make_certs(folder.path() / "ca.pem", {"a"}, 30),
                      contains("make the folder") || contains("write"));
}

TEST_CASE("names and days have their ranges", "[common][net][certs]") {
    const test::TemporaryFolder folder;
    for (const char* name :
         {"", "ca", "../a", "a/b", "A", "a b", ".", "..", "a..b", "-a", ".a", "a.", "ä",
          "a,DNS:evil", "0123456789012345678901234567890123456789012345678901234567890123"}) {
        INFO(name);
        CHECK_THROWS_AS(net::make_certs(folder.path(), {name}, 30), util::UsageError);
    }
    for (const int days : {0, -1, 3651})
        CHECK_THROWS_AS(net::make_certs(folder.path(), {"a"}, days), util::UsageError);
    CHECK_THROWS_WITH(net::make_certs(folder.path(), {"a", "a"}, 30), contains("twice"));
    CHECK(files_in(folder.path()).empty());
}

TEST_CASE("unusable certificates are reported with their file", "[common][net][certs]") {
    const test::TemporaryFolder folder;
    const auto ours = folder.path() / "ours", theirs = folder.path() / "theirs";
    net::make_certs(ours, {"a", "b"}, 30);
    net::make_certs(theirs, {"a"}, 30);
    auto some = credentials(ours, "a");
    SECTION("a missing file") {
        some.certificate = ours / "c.pem";
        CHECK_THROWS_WITH(net::read_pem(some), contains("c.pem"));
    }
    SECTION("no PEM") {
        std::ofstream(ours / "text.pem") << "hello\n";
        some.ca = ours / "text.pem";
        CHECK_THROWS_WITH(net::read_pem(some),
                          contains("text.pem: it holds no certificate; allowed: PEM"));
    }
    SECTION("a folder") {
        some.key = ours;
        CHECK_THROWS_WITH(net::read_pem(some), contains(ours.string()));
    }
    SECTION("the key of another one") {
        some.key = ours / "b.key";
        CHECK_THROWS_WITH(net::read_pem(some),
                          contains("b.key: it belongs to another certificate"));
    }
    SECTION("another CA") {
        some.ca = theirs / "ca.pem";
        CHECK_THROWS_AS(net::read_pem(some), net::RefusedError);
        CHECK_THROWS_WITH(net::read_pem(some), contains("a.pem: "));
    }
    SECTION("the CA itself, which does not carry the farm's name") {
        some.certificate = ours / "ca.pem";
        some.key = ours / "ca.key";
        CHECK_THROWS_AS(net::read_pem(some), net::RefusedError);
    }
}

TEST_CASE("certificates name their role, and lists of revoked ones grow", "[common][net][certs]") {
    const test::TemporaryFolder folder;
    const auto& place = folder.path();
    net::make_certs(place, {}, 30);
    net::make_certs(place, {"office"}, 30, "coordinator");
    net::make_certs(place, {"node-7"}, 30);
    const auto files = files_in(place);
    const auto role = [&](const std::string& name) {
        return net::find_role(net::parse_certificates(files.at(name + ".pem")).front().get());
    };
    CHECK(role("coordinator") == "coordinator");
    CHECK(role("worker") == "worker");
    CHECK(role("office") == "coordinator");
    CHECK(role("node-7") == "worker");
    CHECK(role("ca").empty());
    CHECK_THROWS_WITH(net::make_certs(place, {"other"}, 30, "king"),
                      contains("allowed: worker, coordinator"));
    net::revoke_certs(place, {"worker"});
    net::revoke_certs(place, {"office", "node-7"});
    const auto list = net::parse_crl(files_in(place).at("ca.crl"));
    REQUIRE(list);
    CHECK(sk_X509_REVOKED_num(X509_CRL_get_REVOKED(list.get())) == 3);
    const auto before = files_in(place);
    CHECK_THROWS_WITH(net::revoke_certs(place, {"worker"}), contains("revoked already"));
    CHECK_THROWS_WITH(net::revoke_certs(place, {"nobody"}), contains("nobody.pem"));
    CHECK_THROWS_AS(net::revoke_certs(place, {"ca"}), util::UsageError);
    net::make_certs(place / "another", {}, 30);
    std::filesystem::copy_file(place / "another" / "worker.pem", place / "foreign.pem");
    CHECK_THROWS_WITH(net::revoke_certs(place, {"foreign"}), contains("has not signed it"));
    CHECK(files_in(place).at("ca.crl") == before.at("ca.crl"));
}
