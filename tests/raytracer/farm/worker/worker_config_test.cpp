#include "raytracer/farm/worker/worker_config.hpp"

#include <sys/stat.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;

namespace {

/// Arguments as the command line gives them.
farm::WorkerArguments parsed(std::vector<std::string> flags) {
    CLI::App app;
    farm::WorkerArguments out;
    farm::add_worker_options(app, out);
    std::reverse(flags.begin(), flags.end());
    app.parse(flags);
    return out;
}

struct Folder {
    test::TemporaryFolder folder;
    [[nodiscard]] std::filesystem::path file(const std::string& text) const {
        std::ofstream(folder.path() / "worker.toml") << text;
        return folder.path() / "worker.toml";
    }
    [[nodiscard]] farm::WorkerConfig load(const std::string& text,
                                          std::vector<std::string> flags = {}) const {
        flags.insert(flags.begin(), {"--config", file(text).string()});
        return farm::load_worker_config(parsed(flags));
    }
};

farm::WorkerConfig listening() {
    farm::WorkerConfig c;
    c.listen = sockets::Address{"", 7878};
    return c;
}

}  // namespace

TEST_CASE("the shipped file has the defaults", "[raytracer][worker][config]") {
    const farm::WorkerConfig shipped =
        farm::load_worker_config({std::string(TERRAVOX_SOURCE_DIR) + "/config/worker.toml", {}});
    CHECK(farm::difference(listening(), shipped) == farm::WorkerConfigChange{});
    // It names every field: each that is taken out of it is one fewer.
    std::ifstream in(std::string(TERRAVOX_SOURCE_DIR) + "/config/worker.toml");
    std::size_t lines = 0;
    for (std::string line; std::getline(in, line);)
        lines += line.find(" = ") != std::string::npos && line.front() != '#';
    CLI::App app;
    farm::WorkerArguments ignored;
    farm::add_worker_options(app, ignored);
    // --help, --config and the removed --announce are no fields, version is no flag.
    CHECK(lines == app.get_options().size() - 3 + 1);
}

TEST_CASE("addresses, origins and files are read as what they name",
          "[raytracer][worker][config]") {
    const Folder f;
    const farm::WorkerConfig c = f.load(R"(version = 1
listen = "192.0.2.7:1000"
join = ["one", "[::1]:2000"]
tls_ca = "ca.pem"
tls_cert = "/etc/cert.pem"
tls_key = "keys/key.pem"
allow_origins = ["https://Voxels.example", "http://8.8.8.8:8080"]
drain_s = 0.5
)");
    REQUIRE(c.listen);
    CHECK(c.listen->text() == "192.0.2.7:1000");
    REQUIRE(c.join.size() == 2);
    CHECK(c.join[0].text() == "one:7879");
    CHECK(c.join[1].text() == "[::1]:2000");
    CHECK(c.tls_ca == f.folder.path() / "ca.pem");
    CHECK(c.tls_cert == "/etc/cert.pem");
    CHECK(c.tls_key == f.folder.path() / "keys/key.pem");
    REQUIRE(c.allow_origins.size() == 2);
    CHECK(c.allow_origins[0].text() == "https://voxels.example:443");
    CHECK(c.allow_origins[1].text() == "http://8.8.8.8:8080");
    CHECK(c.drain_s == 0.5);
    CHECK(f.load("version = 1\nlisten = \":1\"\ntoken_file = \"token\"\n").token_file ==
          f.folder.path() / "token");
}

TEST_CASE("flags override the file", "[raytracer][worker][config]") {
    const Folder f;
    const std::string text =
        "version = 1\nlisten = \":1000\"\njoin = [\"one:1\", \"two:2\"]\nthreads = 3\nlog = "
        "\"warn\"\ntoken_file = \"token\"\n";
    const farm::WorkerConfig c = f.load(
        text, {"--threads", "5", "--join", "three:3", "--join", "four", "--log-json",
               "--token-file", "other", "--memory-mib", "4096", "--idle-s", "1.5",
               "--allow-origins", "https://one.example", "--allow-origins", "https://two.example"});
    REQUIRE(c.allow_origins.size() == 2);
    CHECK(c.allow_origins[1].text() == "https://two.example:443");
    CHECK(c.threads == 5);
    CHECK(c.memory_mib == 4096);
    CHECK(c.idle_s == 1.5);
    REQUIRE(c.join.size() == 2);
    CHECK(c.join[0].text() == "three:3");
    CHECK(c.join[1].text() == "four:7879");
    CHECK(c.log_json);
    CHECK(c.log == "warn");
    CHECK(c.token_file == "other");
    CHECK(c.listen->port == 1000);
    CHECK_FALSE(f.load(text, {"--listen", ""}).listen);
    const farm::WorkerConfig alone = farm::load_worker_config(parsed({"--listen", ":0"}));
    CHECK(alone.listen->port == 0);
    CHECK(alone.memory_mib == farm::WorkerConfig().memory_mib);
}

TEST_CASE("an invalid file is refused with what is allowed", "[raytracer][worker][config]") {
    struct Case {
        const char *text, *message;
    };
    const auto c = GENERATE(values<Case>({
        {"listen = \":1\"", "version is missing; allowed: 1"},
        {"version = 2\nlisten = \":1\"", "version = 2; allowed: 1"},
        {"version = 1\nlisten = \":1\"\nthread = 4",
         "unknown field 'thread'; allowed: version, listen, join, name,"},
        {"version = 1\nlisten = 7878", "listen = 7878; allowed: a text"},
        {"version = 1\nlisten = \":70000\"", "listen: read the address ':70000'"},
        {"version = 1\njoin = \"one:1\"", "join = 'one:1'; allowed: a list of texts"},
        {"version = 1\njoin = [\"one:0\"]", "join = 'one:0'; allowed: HOST:PORT, port 1 to 65535"},
        {"version = 1\nlisten = \":1\"\nthreads = -1",
         "threads = -1; allowed: whole numbers, 0 to 1024"},
        {"version = 1\nlisten = \":1\"\nmemory_mib = 9223372036854775807",
         "memory_mib = 9223372036854775807; allowed: whole numbers, 16 to 1048576"},
        {"version = 1\nlisten = \":1\"\ndrain_s = nan", "drain_s = nan; allowed: 0 to 3600"},
        {"version = 1\nlisten = \":1\"\nonce = 1", "once = 1; allowed: true, false"},
        {"version = 1\nlisten = \":1\"\nlog = \"loud\"",
         "log = 'loud'; allowed: trace, debug, info, warn, error, off"},
        {"version = 1\nlisten = \":1\"\nname = \"a\\nb\"",
         "name = a text with a control character; allowed: one line"},
        {"version = 1", "no coordinator to work for; allowed: listen"},
        {"version = 1\njoin = [\"one\"]\nannounce = true", "'announce' was removed; allowed:"},
        {"version = 1\nlisten = \":1\"\ntls_ca = \"a\"\ntls_key = \"b\"",
         "only 2 of tls_ca, tls_cert, tls_key; allowed: all three, or none"},
        {"version = 1\nlisten = \":1\"\ntls_ca = \"a\"\ntls_cert = \"b\"\ntls_key = "
         "\"c\"\ntoken_file = \"d\"",
         "token_file and tls_ca; allowed: one of them"},
        {"version = 1\nlisten = \":1\"\nallow_origins = [\"a.example\"]",
         "allow_origins: read the origin 'a.example': not an address; allowed: "
         "http(s)://host[:port]"},
        {"version = 1\nlisten = \":1\"\nallow_origins = [\"http://10.0.0.1:80\"]",
         "allow_origins = 'http://10.0.0.1:80', no public address; allowed: there public ones"},
        {"version = 1\nlisten = \":1\"\nallow_origins = [\"http://[::ffff:127.0.0.1]\"]",
         "no public address"},
        {"version = 1\nlisten = \":1\"\nallow_private_origins = [\"http://0.0.0.0:80\"]",
         "allow_private_origins = 'http://0.0.0.0:80'; allowed: addresses of single machines"},
        {"version = 1\nlisten = \":1\"\nserver_origin = \"https://a\"",
         "only one of server_origin and server_token_file; allowed: both, or neither"},
        {"version = 1\nlisten = \":1\"\nserver_origin = \"https://a\"\nserver_token_file = \"t\"",
         "server_origin = 'https://a:443'; allowed: one of allow_origins"},
        {"version = 1\nlisten =", "(line 2)"},
    }));
    INFO(c.text);
    const Folder f;
    CHECK_THROWS_AS(f.load(c.text), util::UsageError);
    CHECK_THROWS_WITH(f.load(c.text), contains(c.message));
}

TEST_CASE("an invalid command line is refused with what is allowed",
          "[raytracer][worker][config]") {
    struct Case {
        std::vector<std::string> flags;
        const char* message;
    };
    const auto c = GENERATE(values<Case>({
        {{}, "no coordinator to work for"},
        {{"--listen", ":1", "--threads", "many"},
         "threads = 'many'; allowed: whole numbers, 0 to 1024"},
        {{"--listen", "a:b"}, "listen: read the address 'a:b'"},
        {{"--config", "/nowhere/worker.toml"},
         "read the worker's configuration /nowhere/worker.toml: no such file"},
    }));
    INFO(c.message);
    CHECK_THROWS_AS(farm::load_worker_config(parsed(c.flags)), util::UsageError);
    CHECK_THROWS_WITH(farm::load_worker_config(parsed(c.flags)), contains(c.message));
}

TEST_CASE("every field is read, and a reload changes what may change and reports the rest",
          "[raytracer][worker][config]") {
    const Folder f;
    const auto load = [&](const std::map<std::string, std::string>& fields) {
        std::string text;
        for (const auto& [name, value] : fields)
            text += name + " = " + value + "\n";
        return f.load(text);
    };
    const std::map<std::string, std::string> fields{
        {"version", "1"},
        {"listen", "':1'"},
        {"tls_ca", "'a'"},
        {"tls_cert", "'b'"},
        {"tls_key", "'c'"},
        {"allow_origins", "['https://a', 'https://b']"},
        {"server_origin", "'https://a'"},
        {"server_token_file", "'t'"},
    };
    const farm::WorkerConfig running = load(fields);
    struct Case {
        const char *name, *value;
        bool now;
    };
    for (const auto& [field, value, now] : std::vector<Case>{
             {"listen", "':2'", false},
             {"join", "['one']", true},
             {"name", "'other'", false},
             {"threads", "7", true},
             {"memory_mib", "64", true},
             {"sessions", "2", true},
             {"tls_ca", "'x'", false},
             {"tls_cert", "'x'", false},
             {"tls_key", "'x'", false},
             {"allow_origins", "['https://a']", false},
             {"allow_private_origins", "['http://127.0.0.1:8888']", false},
             {"server_origin", "'https://b'", false},
             {"server_token_file", "'x'", false},
             {"metrics", "'127.0.0.1:9187'", false},
             {"metrics_names", "'render1.lan'", false},
             {"drain_s", "1", true},
             {"idle_s", "1", true},
             {"once", "true", false},
             {"log", "'off'", true},
             {"log_json", "true", true},
         }) {
        INFO(field);
        auto changed = fields;
        changed[field] = value;
        const farm::WorkerConfig wanted = load(changed);
        const farm::WorkerConfig after = farm::reloaded(running, wanted);
        const std::vector<std::string> name{field};
        const farm::WorkerConfigChange none, done{name, {}}, kept{{}, name};
        CHECK(farm::difference(running, wanted) == (now ? done : kept));
        CHECK(farm::difference(running, after) == (now ? done : none));
        CHECK(farm::difference(after, wanted) == (now ? none : kept));
    }
}

TEST_CASE("a reload of everything keeps the order of the fields", "[raytracer][worker][config]") {
    farm::WorkerConfig wanted = listening();
    wanted.log = "off";
    wanted.threads = 1;
    wanted.join = {{"one", 1}};
    wanted.metrics = sockets::Address{"::1", 1};
    wanted.name = "x";
    CHECK(farm::difference(listening(), wanted) ==
          farm::WorkerConfigChange{{"join", "threads", "log"}, {"name", "metrics"}});
}

TEST_CASE("credentials are a token, read anew each time, or certificates",
          "[raytracer][worker][config]") {
    const Folder f;
    const auto token = f.folder.path() / "token";
    std::ofstream(token) << "h3kx8tq5vz2mw9rj6ncpd7bf4gy1ks8e\n";
    chmod(token.c_str(), 0600);
    unsetenv("TERRAVOX_FARM_TOKEN");
    farm::WorkerConfig c = listening();
    CHECK_THROWS_AS(farm::make_credentials(c), util::UsageError);
    CHECK_THROWS_WITH(farm::make_credentials(c), contains("neither token nor certificates"));
    c.token_file = token;
    CHECK(farm::make_credentials(c).token == "h3kx8tq5vz2mw9rj6ncpd7bf4gy1ks8e");
    std::ofstream(token) << "b7gd4sy2pk9xq6tm3wzvh8cj5nr1fa6e\n";
    CHECK(farm::make_credentials(c).token == "b7gd4sy2pk9xq6tm3wzvh8cj5nr1fa6e");
    CHECK_FALSE(farm::make_credentials(c).tls());
    c = listening();
    c.tls_ca = "a";
    c.tls_cert = "b";
    c.tls_key = "c";
    setenv("TERRAVOX_FARM_TOKEN", "y3bw6fj8nq2xs5gm9tzkc7dv1hr4pe8u", 1);
    CHECK(farm::make_credentials(c).token.empty());
    CHECK(farm::make_credentials(c).tls());
    CHECK(farm::make_credentials(c).key == "c");
    CHECK(farm::make_credentials(listening()).token == "y3bw6fj8nq2xs5gm9tzkc7dv1hr4pe8u");
    unsetenv("TERRAVOX_FARM_TOKEN");
}

TEST_CASE(
    "a worker may use the servers of its configuration alone, and sends no token of the "
    "environment",
    "[raytracer][worker][config]") {
    const Folder f;
    const auto token = f.folder.path() / "server-token";
    std::ofstream(token) << "a-token-of-a-server-93e1b7a05c2f\n";
    chmod(token.c_str(), 0600);
    setenv("TERRAVOX_SERVER_TOKEN", "a-token-of-the-environment-4d60fa", 1);
    setenv("TERRAVOX_SERVER_ORIGIN", "https://voxels.example", 1);
    const remote::HttpOrigin voxels = remote::HttpOrigin::parse("https://voxels.example"),
                             other = remote::HttpOrigin::parse("http://10.0.0.1:8080");
    const remote::HttpAccess nobody = farm::make_http_access(listening());
    CHECK_FALSE(nobody.token);
    CHECK(nobody.ranges(voxels).empty());
    const remote::HttpAccess some = farm::make_http_access(f.load(
        "version = 1\nlisten = \":1\"\nallow_origins = "
        "[\"https://voxels.example\"]\nallow_private_origins = [\"http://10.0.0.1:8080\"]\n"
        "server_origin = \"https://voxels.example\"\nserver_token_file = \"server-token\"\n"));
    REQUIRE(some.token);
    CHECK(some.token->text() == "a-token-of-a-server-93e1b7a05c2f");
    CHECK(some.token->origin() == voxels);
    CHECK(some.ranges(voxels) == remote::AddressRanges{remote::AddressRange::kPublic});
    CHECK(some.ranges(other) == remote::AddressRanges{remote::AddressRange::kPublic,
                                                      remote::AddressRange::kPrivate,
                                                      remote::AddressRange::kLoopback});
    CHECK(some.ranges(remote::HttpOrigin::parse("http://voxels.example")).empty());
    const farm::WorkerConfig clear = f.load(
        "version = 1\nlisten = \":1\"\nallow_origins = [\"http://voxels.example\"]\nserver_origin "
        "= \"http://voxels.example\"\nserver_token_file = \"server-token\"\n");
    CHECK_THROWS_AS(farm::make_http_access(clear), util::UsageError);
    CHECK_THROWS_WITH(farm::make_http_access(clear), contains("clear text"));
    chmod(token.c_str(), 0644);
    CHECK_THROWS_WITH(
        farm::make_http_access(
            f.load("version = 1\nlisten = \":1\"\nallow_origins = [\"https://a\"]\nserver_origin = "
                   "\"https://a\"\nserver_token_file = \"server-token\"\n")),
        contains("chmod 600"));
    unsetenv("TERRAVOX_SERVER_TOKEN");
    unsetenv("TERRAVOX_SERVER_ORIGIN");
}
