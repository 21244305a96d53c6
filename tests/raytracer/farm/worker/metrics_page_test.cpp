#include "raytracer/farm/worker/metrics_page.hpp"

#include <atomic>
#include <cctype>
#include <cstdlib>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/http/http_client.hpp"

using namespace terravox;
using terravox::test::HttpClient;

namespace {

/// Samples by name and labels, as written. Throws for what a reader of the text format would
/// refuse.
class MetricsReader {
public:
    explicit MetricsReader(const std::string& text) {
        if (text.empty() || text.back() != '\n')
            throw std::runtime_error("no end of the last line");
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) {
            m_line = line;
            if (line.starts_with("# HELP "))
                begin_family(line.substr(7));
            else if (line.starts_with("# TYPE "))
                set_type(line.substr(7));
            else
                read_sample(line);
        }
    }
    [[nodiscard]] double at(const std::string& sample) const { return m_samples.at(sample); }
    [[nodiscard]] std::size_t size() const { return m_samples.size(); }

private:
    [[noreturn]] void fail(const std::string& why) const {
        throw std::runtime_error(why + ": " + m_line);
    }
    static bool is_name(const std::string& name) {
        if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())))
            return false;
        for (const char c : name)
            if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != ':')
                return false;
        return true;
    }
    void begin_family(const std::string& rest) {
        m_family = rest.substr(0, rest.find(' '));
        if (!is_name(m_family))
            fail("not a name");
        if (rest.size() < m_family.size() + 2)
            fail("no help");
        if (!m_families.insert(m_family).second)
            fail("a family twice");
        m_type.clear();
    }
    void set_type(const std::string& rest) {
        if (rest.substr(0, rest.find(' ')) != m_family || !m_type.empty())
            fail("a type without its help");
        m_type = rest.substr(m_family.size() + 1);
        if (m_type != "counter" && m_type != "gauge")
            fail("unknown type");
        if ((m_type == "counter") != m_family.ends_with("_total"))
            fail("counters, and only they, end in _total");
    }
    void read_sample(const std::string& line) {
        if (m_type.empty())
            fail("a sample before its type");
        std::size_t at = m_family.size();
        if (line.substr(0, at) != m_family)
            fail("a sample of another family");
        if (line[at] == '{')
            at = end_of_label(line, at);
        if (at >= line.size() || line[at] != ' ')
            fail("no blank before the value");
        char* end = nullptr;
        const double value = std::strtod(line.c_str() + at + 1, &end);
        if (end == line.c_str() + at + 1 || *end != '\0')
            fail("not a number");
        if (!m_samples.emplace(line.substr(0, at), value).second)
            fail("a sample twice");
    }
    std::size_t end_of_label(const std::string& line, std::size_t at) const {
        const std::size_t equals = line.find("=\"", at);
        if (equals == std::string::npos || !is_name(line.substr(at + 1, equals - at - 1)))
            fail("not a label");
        for (at = equals + 2; at < line.size() && line[at] != '"'; ++at)
            if (line[at] == '\\' && ++at < line.size() && line[at] != '\\' && line[at] != '"' &&
                line[at] != 'n')
                fail("not an escape");
        if (line.substr(at, 2) != "\"}")
            fail("no end of the labels");
        return at + 2;
    }

    std::string m_line, m_family, m_type;
    std::set<std::string> m_families;
    std::map<std::string, double> m_samples;
};

farm::WorkerMetrics some_metrics() {
    farm::WorkerMetrics m;
    m.uptime_s = 12.5;
    m.tiles = 7;
    m.pixels = 28'672;
    m.rays = 9'007'199'254'740'991;
    m.failed = 1;
    m.result_bytes = 1'000'000'007;
    m.box_requests = 3;
    m.busy_s = 0.25;
    m.all_sessions = 4;
    m.refused = {{"wrong token", 5}, {"a \"quoted\"\\\nreason", 6}};
    m.sessions = 1;
    m.threads = 16;
    m.waiting = 8;
    m.begun = 9;
    m.memory_bytes = 123'456'789;
    m.box_bytes = 1024;
    m.box_limit_bytes = 2048;
    return m;
}

struct Page {
    std::atomic<bool> draining{false}, fails{false};
    farm::MetricsPage page{{"127.0.0.1", 0, {"render1.lan"}}, [this] {
                               if (fails)
                                   throw std::runtime_error("no metrics today");
                               farm::WorkerMetrics m = some_metrics();
                               m.draining = draining;
                               return m;
                           }};
    [[nodiscard]] test::HttpReply ask(const std::string& path, const std::string& headers = "",
                                      const std::string& method = "GET") const {
        return HttpClient(page.port()).get(path, headers, method);
    }
};

}  // namespace

TEST_CASE("a worker's metrics are what a reader of the text format takes",
          "[raytracer][worker][metrics]") {
    const MetricsReader read(farm::metrics_text(some_metrics()));
    CHECK(read.at("terravox_worker_uptime_seconds") == 12.5);
    CHECK(read.at("terravox_worker_tiles_total") == 7);
    CHECK(read.at("terravox_worker_pixels_total") == 28'672);
    CHECK(read.at("terravox_worker_rays_total") == 9'007'199'254'740'991.0);
    CHECK(read.at("terravox_worker_failed_total") == 1);
    CHECK(read.at("terravox_worker_results_bytes_total") == 1'000'000'007);
    CHECK(read.at("terravox_worker_box_requests_total") == 3);
    CHECK(read.at("terravox_worker_busy_seconds_total") == 0.25);
    CHECK(read.at("terravox_worker_sessions_total") == 4);
    CHECK(read.at("terravox_worker_refused_total{reason=\"wrong token\"}") == 5);
    CHECK(read.at("terravox_worker_refused_total{reason=\"a \\\"quoted\\\"\\\\ reason\"}") == 6);
    CHECK(read.at("terravox_worker_sessions") == 1);
    CHECK(read.at("terravox_worker_threads") == 16);
    CHECK(read.at("terravox_worker_tiles_waiting") == 8);
    CHECK(read.at("terravox_worker_tiles_begun") == 9);
    CHECK(read.at("terravox_worker_memory_bytes") == 123'456'789);
    CHECK(read.at("terravox_worker_box_bytes") == 1024);
    CHECK(read.at("terravox_worker_box_limit_bytes") == 2048);
    CHECK(read.at("terravox_worker_draining") == 0);
    CHECK(read.size() == 20);
    CHECK(MetricsReader(farm::metrics_text({})).size() == 18);
}

TEST_CASE("the reader of metrics refuses what is none", "[raytracer][worker][metrics]") {
    const char* broken =
        GENERATE("", "# HELP a b\n# TYPE a gauge\na 1", "a 1\n", "# HELP a b\na 1\n",
                 "# HELP a b\n# TYPE a gauge\nb 1\n", "# HELP a b\n# TYPE a gauge\na one\n",
                 "# HELP a b\n# TYPE a gauge\na{x=\"1} 1\n",
                 "# HELP a b\n# TYPE a gauge\na 1\na 1\n", "# HELP a b\n# TYPE a counter\na 1\n");
    INFO(broken);
    CHECK_THROWS_AS(MetricsReader(broken), std::runtime_error);
}

TEST_CASE("the page answers GET and HEAD", "[raytracer][worker][metrics]") {
    Page page;
    const auto metrics = page.ask("/metrics");
    CHECK(metrics.status == 200);
    CHECK(metrics.headers.at("content-type") == "text/plain; version=0.0.4; charset=utf-8");
    CHECK(metrics.headers.at("cache-control") == "no-store");
    CHECK(MetricsReader(metrics.body).at("terravox_worker_tiles_total") == 7);
    const auto head = page.ask("/metrics", "", "HEAD");
    CHECK(head.status == 200);
    CHECK(head.headers.at("content-length") == std::to_string(metrics.body.size()));
    CHECK(page.ask("/healthz").status == 200);
    CHECK(page.ask("/healthz").body == "ok\n");
    page.draining = true;
    CHECK(page.ask("/healthz").status == 503);
    CHECK(MetricsReader(page.ask("/metrics").body).at("terravox_worker_draining") == 1);
    page.fails = true;
    CHECK(page.ask("/metrics").status == 500);
    page.fails = false;
    CHECK(page.ask("/metrics").status == 200);
}

TEST_CASE("the page refuses all other requests, and continues", "[raytracer][worker][metrics]") {
    Page page;
    for (const char* path :
         {"/", "/metrics/", "/metrics/../metrics", "/%6detrics", "/etc/passwd", "/healthz/x"}) {
        INFO(path);
        const int status = page.ask(path).status;
        CHECK((status == 404 || status == 400));
    }
    for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS"}) {
        INFO(method);
        // The body is announced and never sent; the page does not wait for it.
        const auto reply = page.ask("/metrics", "Content-Length: 1000000000000\r\n", method);
        CHECK(reply.status == 405);
        CHECK(reply.headers.at("allow") == "GET, HEAD");
    }
    for (const std::string& bytes : {std::string("\r\n\r\n"), std::string("GET\r\n\r\n"),
                                     std::string("GET * HTTP/1.1\r\nHost: x\r\n\r\n"),
                                     "GET /" + std::string(20'000, 'x') + " HTTP/1.1\r\n\r\n",
                                     std::string("\x16\x03\x01 hello\r\n\r\n")}) {
        INFO(bytes.substr(0, 10));
        HttpClient client(page.page.port());
        client.send(bytes);
        const std::string reply = client.read_to_end();
        CHECK((reply.empty() || reply.starts_with("HTTP/1.1 4")));
    }
    CHECK(page.ask("/healthz").status == 200);
}

TEST_CASE("the page answers to its own names alone, and to no page of elsewhere",
          "[raytracer][worker][metrics]") {
    Page page;
    const auto status = [&](const std::string& headers) {
        HttpClient client(page.page.port());
        client.send("GET /metrics HTTP/1.1\r\n" + headers + "\r\n");
        const auto reply = client.read_reply();
        return reply ? reply->status : 0;
    };
    for (const char* host :
         {"localhost:9187", "127.0.0.1", "[::1]:9187", "192.0.2.7:9187", "render1.lan:9187"})
        CHECK(status("Host: " + std::string(host) + "\r\n") == 200);
    for (const char* headers : {"Host: attacker.example\r\n", "Host: attacker.example:9187\r\n",
                                "Host:\r\n", "", "Host: localhost\r\nHost: localhost\r\n"}) {
        INFO(headers);
        CHECK(status(headers) == 421);
    }
    CHECK(status("Host: localhost\r\nOrigin: http://attacker.example\r\n") == 403);
    CHECK(status("Host: localhost\r\nSec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: no-cors\r\n"
                 "Sec-Fetch-Dest: image\r\n") == 403);
    HttpClient old(page.page.port());
    old.send("GET /healthz HTTP/1.0\r\n\r\n");
    CHECK(old.read_reply()->status == 200);
}

TEST_CASE("clients that send nothing do not block the page for long",
          "[raytracer][worker][metrics]") {
    Page page;
    std::vector<std::unique_ptr<HttpClient>> silent;
    for (int i = 0; i < 100; ++i)
        silent.push_back(std::make_unique<HttpClient>(page.page.port()));
    CHECK(page.ask("/metrics").status == 200);
    CHECK(silent.front()->wait_for_end());
}

TEST_CASE("a page that cannot be opened is an error with address and reason",
          "[raytracer][worker][metrics]") {
    Page page;
    const auto nothing = [] { return farm::WorkerMetrics(); };
    CHECK_THROWS_AS(farm::MetricsPage({"127.0.0.1", page.page.port()}, nothing), util::Error);
    CHECK_THROWS_WITH(farm::MetricsPage({"127.0.0.1", page.page.port()}, nothing),
                      test::contains("127.0.0.1:" + std::to_string(page.page.port())));
    CHECK_THROWS_AS(farm::MetricsPage({"localhost", 0}, nothing), util::UsageError);
    CHECK_THROWS_AS(farm::MetricsPage({"127.0.0.1,8080", 0}, nothing), util::UsageError);
}
