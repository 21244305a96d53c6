#include "raytracer/farm/worker/metrics_page.hpp"

#include <atomic>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>

#include "tests/catch.hpp"
#include "tests/voxelserver/serve/host/http_client.hpp"

using namespace terravox;
using terravox::test::HttpClient;

namespace {

/// Samples by name and labels, as written. Throws for what a reader of the text format would
/// refuse.
class MetricsReader {
public:
    explicit MetricsReader(const std::string& text) {
        static const std::regex help("# HELP ([a-zA-Z_:][a-zA-Z0-9_:]*) .+");
        static const std::regex type("# TYPE ([^ ]+) (counter|gauge)");
        static const std::regex sample(
            R"re((([^ {]+)(\{[a-zA-Z_]\w*="([^"\\]|\\["\\n])*"\})?) ([^ ]+))re");
        std::istringstream lines(text);
        std::string family;
        std::string typed;
        for (std::string line; std::getline(lines, line);) {
            std::smatch found;
            bool is_good = false;
            if (std::regex_match(line, found, help)) {
                family = found[1];
                is_good = m_families.insert(family).second;
            } else if (std::regex_match(line, found, type)) {
                typed = found[1];
                // Counters, and only they, end in _total.
                is_good = typed == family && (found[2] == "counter") == typed.ends_with("_total");
            } else if (std::regex_match(line, found, sample)) {
                is_good =
                    found[2] == typed && m_samples.emplace(found[1], std::stod(found[5])).second;
            }
            if (!is_good)
                throw std::runtime_error("a reader would refuse: " + line);
        }
    }
    [[nodiscard]] double at(const std::string& sample) const { return m_samples.at(sample); }
    [[nodiscard]] std::size_t size() const { return m_samples.size(); }

private:
    std::set<std::string> m_families;
    std::map<std::string, double> m_samples;
};

farm::WorkerDaemon::Totals some_metrics() {
    farm::WorkerDaemon::Totals m;
    m.uptime_s = 12.5;
    m.tiles = 7;
    m.pixels = 28'672;
    m.rays = 9'007'199'254'740'991;
    m.failed = 1;
    m.result_bytes = 1'000'000'007;
    m.box_requests = 3;
    m.busy_s = 0.25;
    m.sessions = 4;
    m.busy = 5;
    m.unfit = 6;
    m.now.resize(2);
    m.now[0].box_bytes = 1000;
    m.now[0].waiting = 5;
    m.now[0].begun = 9;
    m.now[1].box_bytes = 24;
    m.now[1].waiting = 3;
    m.threads = 16;
    m.resident_bytes = 123'456'789;
    m.memory_bytes = 2048;
    return m;
}

struct Page {
    std::atomic<bool> draining{false}, fails{false};
    farm::MetricsPage page{{"127.0.0.1", 0, {"render1.lan"}}, [this] {
                               if (fails)
                                   throw std::runtime_error("no metrics today");
                               farm::WorkerDaemon::Totals m = some_metrics();
                               m.ending = draining;
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
    const MetricsReader read(farm::write_metrics(some_metrics()).take());
    CHECK(read.at("terravox_worker_uptime_seconds") == 12.5);
    CHECK(read.at("terravox_worker_tiles_total") == 7);
    CHECK(read.at("terravox_worker_pixels_total") == 28'672);
    CHECK(read.at("terravox_worker_rays_total") == 9'007'199'254'740'991.0);
    CHECK(read.at("terravox_worker_failed_total") == 1);
    CHECK(read.at("terravox_worker_results_bytes_total") == 1'000'000'007);
    CHECK(read.at("terravox_worker_box_requests_total") == 3);
    CHECK(read.at("terravox_worker_busy_seconds_total") == 0.25);
    CHECK(read.at("terravox_worker_sessions_total") == 4);
    CHECK(read.at("terravox_worker_refused_total{reason=\"busy\"}") == 5);
    CHECK(read.at("terravox_worker_refused_total{reason=\"unfit\"}") == 6);
    CHECK(http::metrics_label("reason", "a \"quoted\"\\\nreason") ==
          "reason=\"a \\\"quoted\\\"\\\\ reason\"");
    CHECK(read.at("terravox_worker_sessions") == 2);
    CHECK(read.at("terravox_worker_threads") == 16);
    CHECK(read.at("terravox_worker_tiles_waiting") == 8);
    CHECK(read.at("terravox_worker_tiles_begun") == 9);
    CHECK(read.at("terravox_worker_memory_bytes") == 123'456'789);
    CHECK(read.at("terravox_worker_box_bytes") == 1024);
    CHECK(read.at("terravox_worker_box_limit_bytes") == 2048);
    CHECK(read.at("terravox_worker_draining") == 0);
    CHECK(read.size() == 20);
    CHECK(MetricsReader(farm::write_metrics({}).take()).size() == 20);
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
    std::string many_headers;
    for (int i = 0; i < 64; ++i)
        many_headers += "X-" + std::to_string(i) + ": 1\r\n";
    CHECK(page.ask("/metrics", many_headers).status == 431);
    CHECK(page.ask("/healthz").status == 200);
}

TEST_CASE("the page answers to its own names alone, and to no page of elsewhere",
          "[raytracer][worker][metrics]") {
    const Page page;
    const auto status = [&](const std::string& request) {
        HttpClient client(page.page.port());
        client.send("GET /metrics HTTP/1." + request + "\r\n");
        const auto reply = client.read_reply();
        return reply ? reply->status : 0;
    };
    CHECK(status("1\r\nHost: render1.lan:9187\r\n") == 200);
    CHECK(status("0\r\n") == 200);
    CHECK(status("1\r\n") == 421);
    CHECK(status("1\r\nHost: attacker.example\r\n") == 421);
    CHECK(status("1\r\nHost: localhost\r\nOrigin: http://attacker.example\r\n") == 403);
}
