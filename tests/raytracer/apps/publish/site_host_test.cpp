#include "raytracer/apps/publish/site_host.hpp"

#include <sys/stat.h>

#include <fstream>
#include <memory>
#include <vector>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/serve/host/http_client.hpp"

using namespace terravox;
using publish::SiteFiles;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

void put_file(const fs::path& file, const std::string& bytes) {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
}

/// A site in a folder, beside a file that is none of its business.
struct Site {
    Site() {
        put_file(path / "index.html", "page");
        put_file(path / "viewer" / "viewer.js", "code");
        put_file(path / "two words.txt", "words");
        put_file(path / "sub" / "index.html", "below");
        put_file(path / "place.tvx", "0123456789");
        put_file(folder.path() / "secret.txt", "secret");
    }
    TemporaryFolder folder;
    fs::path path = folder.path() / "site";
};

http::Response asked(const fs::path& folder, const std::string& path,
                     std::vector<http::Header> headers = {{"Host", "127.0.0.1:8080"}},
                     std::string_view method = "GET") {
    SiteFiles files(folder);
    return files.handle({method, path, std::move(headers)});
}

std::string to_body(const http::Response& reply) {
    if (!reply.file)
        return std::string(reply.bytes());
    std::string out(reply.file->bytes, '\0');
    const auto read = ::pread(*reply.file->descriptor, out.data(), out.size(),
                              static_cast<off_t>(reply.file->offset));
    out.resize(read < 0 ? 0 : static_cast<std::size_t>(read));
    return out;
}

}  // namespace

TEST_CASE("the files of a site are served with their types", "[publish][view]") {
    const Site site;
    struct Case {
        const char* path;
        const char* type;
        const char* bytes;
    };
    for (const Case& c : std::vector<Case>{
             {"/", "text/html; charset=utf-8", "page"},
             {"/index.html", "text/html; charset=utf-8", "page"},
             {"/sub/", "text/html; charset=utf-8", "below"},
             {"/viewer/viewer.js", "text/javascript; charset=utf-8", "code"},
             {"/two%20words.txt", "text/plain; charset=utf-8", "words"},
             {"/place.tvx", "application/vnd.terravox.archive", "0123456789"},
         }) {
        INFO(c.path);
        const http::Response reply = asked(site.path, c.path);
        CHECK(reply.status == 200);
        CHECK(reply.header("Content-Type") == c.type);
        CHECK(to_body(reply) == c.bytes);
        CHECK_FALSE(reply.header("ETag").empty());
    }
    const auto part =
        asked(site.path, "/place.tvx", {{"Host", "localhost"}, {"Range", "bytes=2-4"}});
    CHECK(part.status == 206);
    CHECK(part.header("Content-Range") == "bytes 2-4/10");
    CHECK(to_body(part) == "234");
}

TEST_CASE("no link in a site leads out of it, or anywhere", "[publish][view]") {
    const Site site;
    fs::create_symlink("../secret.txt", site.path / "out.txt");
    fs::create_symlink(site.folder.path() / "secret.txt", site.path / "absolute.txt");
    fs::create_symlink("..", site.path / "up");
    fs::create_symlink("index.html", site.path / "inside.html");
    fs::create_symlink("sub", site.path / "inside");
    ::mkfifo((site.path / "pipe").c_str(), 0600);
    for (const char* path :
         {"/out.txt", "/absolute.txt", "/up/secret.txt", "/up/", "/inside.html", "/inside/",
          "/inside/index.html", "/../secret.txt", "/%2e%2e/secret.txt", "/sub/../../secret.txt",
          "/..%2fsecret.txt", "//secret.txt"}) {
        INFO(path);
        const http::Response reply = asked(site.path, path);
        CHECK(reply.status == 404);
        CHECK_THAT(to_body(reply), !contains("secret\n") && !contains("below"));
    }
    CHECK_THAT(to_body(asked(site.path, "/out.txt")), contains("symbolic link"));
}

TEST_CASE("a folder is redirected to within its own host, and never listed", "[publish][view]") {
    const Site site;
    fs::create_directories(site.path / "\\\\evil.example");
    fs::create_directories(site.path / "http:evil.example");
    CHECK(asked(site.path, "/sub").status == 308);
    CHECK(asked(site.path, "/sub").header("Location") == "./sub/");
    CHECK(asked(site.path, "/http:evil.example").header("Location") == "./http:evil.example/");
    CHECK(asked(site.path, "/viewer").header("Location") == "./viewer/");
    CHECK(asked(site.path, "/viewer/").status == 404);
    for (const char* path :
         {"//evil.example", "//evil.example/..", "/\\\\evil.example", "/%5c%5cevil.example",
          "/%2f%2fevil.example", "/sub//", "/%zz", "*", "/a%00b", "/%0d%0aX: y"}) {
        INFO(path);
        const http::Response reply = asked(site.path, path);
        CHECK(reply.status == 404);
        CHECK(reply.header("Location").empty());
    }
}

TEST_CASE("a site hears only its own page", "[publish][view]") {
    const Site site;
    struct Case {
        const char* name;
        int status;
        const char* path;
        std::vector<http::Header> headers;
        const char* method;
    };
    for (const Case& c : std::vector<Case>{
             {"its name", 200, "/", {{"Host", "localhost:1"}}, "HEAD"},
             {"another name", 421, "/", {{"Host", "evil.example"}}, "GET"},
             {"another page",
              403,
              "/",
              {{"Host", "127.0.0.1:8080"}, {"Origin", "http://evil.example"}},
              "GET"},
             {"another method", 405, "/", {{"Host", "localhost"}}, "DELETE"},
             {"a body", 413, "/", {{"Host", "localhost"}, {"Content-Length", "3"}}, "GET"},
         }) {
        INFO(c.name);
        CHECK(asked(site.path, c.path, c.headers, c.method).status == c.status);
    }
    const std::string most(SiteFiles::kMaxAddress_bytes - 1, 'a');
    CHECK(asked(site.path, "/" + most).status == 404);
    CHECK(asked(site.path, "/a" + most).status == 414);
}

TEST_CASE("whatever a site is asked, its pages are told to ask nobody else", "[publish][view]") {
    const Site site;
    for (const char* path : {"/", "/viewer/viewer.js", "/none", "/sub"}) {
        INFO(path);
        const std::string policy = asked(site.path, path).header("Content-Security-Policy");
        CHECK_THAT(policy, contains("default-src 'none'") && contains("connect-src 'self';") &&
                               contains("frame-ancestors 'none'"));
        CHECK_THAT(policy, !contains("https:") && !contains("unsafe") && !contains("*"));
    }
    SiteFiles files(site.path, "https://files.example:8443");
    CHECK_THAT(
        files.handle({"GET", "/", {{"Host", "localhost"}}}).header("Content-Security-Policy"),
        contains("connect-src 'self' https://files.example:8443;"));
}
