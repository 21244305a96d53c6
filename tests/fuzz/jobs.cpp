// Jobs for analyses, as bodies of requests to the voxel server.
#include <algorithm>
#include <array>
#include <cctype>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/voxel/analysis.hpp"
#include "tests/eventually.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "tests/voxelserver/serve/jobs/script.hpp"
#include "voxelserver/serve/http/router.hpp"
#include "voxelserver/serve/jobs/job_queue.hpp"

namespace terravox::fuzz {
namespace {

using nlohmann::json;

/// Few cells: the queue wants room on the disk for the raster of a job.
constexpr std::int64_t kMaxCells = 10'000;
constexpr std::size_t kLongestReply = 2000;
/// Of one word: three numbers, none longer than its text in the request or 40 characters.
constexpr std::size_t kLongestWord = 200;
constexpr std::size_t kMaxWords = 24;

/// The options of `terravox analyse` that a job may set; no others, such as those that name files.
constexpr std::array<std::string_view, 16> kOptions{
    "area",    "resolution", "surface",  "thin-blocks",   "directions", "range-m",
    "date",    "from",       "to",       "step-min",      "zone",       "at",
    "monthly", "linke",      "observer", "target-height",
};

void check_word(std::string_view word) {
    expect(word.size() <= kLongestWord, "a word is short");
    expect(word.starts_with("--"), "a word is an option");
    word.remove_prefix(2);
    const std::string_view name = word.substr(0, word.find('='));
    expect(std::find(kOptions.begin(), kOptions.end(), name) != kOptions.end(),
           "an option is one that a job may set");
    const std::string_view value = word.substr(std::min(name.size() + 1, word.size()));
    expect(value.empty() == (name == "monthly"), "an option has a value where it takes one");
    const bool is_word = name == "zone" || name == "surface" || name == "thin-blocks";
    const auto is_known = [&](char c) {
        if (is_word && std::isalpha(static_cast<unsigned char>(c)) != 0)
            return true;
        return std::string_view(is_word ? "0123456789_+-/" : "0123456789+-.,:e").find(c) !=
               std::string_view::npos;
    };
    expect(std::all_of(value.begin(), value.end(), is_known),
           "a value has no characters but those of numbers, days and zones");
    expect(!value.starts_with('/'), "a value is no path");
}

/// @return nullopt where the job is refused
std::optional<jobs::JobRequest> read(const std::string& body, const voxel::WorldInfo& world,
                                     const jobs::JobLimits& limits) {
    std::optional<jobs::JobRequest> out;
    try {
        out = jobs::read_job_request(body, world, limits);
    } catch (const util::UsageError& e) {
        expect(std::string_view(e.what()).size() < kLongestReply, "a message is short");
        return out;
    }
    const std::vector<std::string> kinds = voxel::list_analyses();
    expect(std::find(kinds.begin(), kinds.end(), out->kind) != kinds.end(), "a job has a kind");
    expect(out->cells > 0 && out->cells <= limits.max_cells, "a job has as many cells as it may");
    expect(out->words.size() <= kMaxWords, "a job has few words");
    for (const std::string& word : out->words)
        check_word(word);
    return out;
}

/// A server whose queue is at work on a job without end, so that all others wait.
class Server {
public:
    Server() {
        expect(m_queue.submit({"terrain", 1, {}}).has_value(), "the first job is taken");
        expect(test::eventually([&] { return m_queue.counts().running == 1; }),
               "the first job runs");
    }

    void post(const std::string& body) {
        const bool is_job = read(body, m_world.info(), m_queue.limits()).has_value();
        const std::string length = std::to_string(body.size());
        const http::Response reply =
            send({"POST", "/v2/jobs", {{"Content-Length", length}}, {}, body});
        if (reply.status == 503 && is_job)
            return;  // the disk is nearly full
        expect(reply.status == (is_job         ? 201
                                : body.empty() ? 411
                                               : 400),
               "the status is that of a job, or of its refusal");
        expect(m_queue.counts().waiting == (is_job ? 1 : 0), "no job waits that was refused");
        if (is_job)
            look_and_delete(json::parse(reply.bytes()).at("id").get<std::string>());
    }

private:
    static jobs::QueueOptions options(const test::Script& program) {
        jobs::QueueOptions out;
        out.program = program.file();
        out.world = "http://127.0.0.1:1";
        out.spare_bytes = 0;
        out.limits.max_cells = kMaxCells;
        out.limits.max_minutes = 1'000'000;
        return out;
    }
    [[nodiscard]] http::Service service() {
        http::Service out{m_world, m_times, m_boxes};
        out.jobs = &m_queue;
        return out;
    }

    http::Response send(const http::Request& request) {
        std::optional<http::Response> refused = m_router.refusal(request);
        http::Response out = refused ? std::move(*refused) : m_router.handle(request);
        expect(out.status >= 200 && out.status < 600 && out.status != 500,
               "no request is an error of the server's own");
        expect(out.body_bytes() < kLongestReply, "a reply is short");
        expect(out.status == 204 || json::accept(out.bytes()), "a reply is JSON");
        return out;
    }

    void look_and_delete(const std::string& id) {
        const std::string path = "/v2/jobs/" + id;
        const http::Response now = send({"GET", path, {}});
        expect(now.status == 200 && json::parse(now.bytes()).at("state") == "waiting",
               "a job waits for its turn");
        expect(send({"DELETE", path, {}}).status == 204, "a job is deleted");
        expect(m_queue.counts().waiting == 0, "no job waits that was deleted");
    }

    const test::Script m_program{"exec sleep infinity"};
    test::FakeWorld m_world;
    util::StageTimes m_times;
    boxes::BoxCache m_boxes{m_world, m_times, {.ahead = false}};
    jobs::JobQueue m_queue{options(m_program)};
    http::Router m_router{service()};
};

}  // namespace

void run(Input input) {
    static Server server;
    static const voxel::WorldInfo placed = [] {
        voxel::WorldInfo out;
        out.voxel_m = 0.5;
        out.crs = "EPSG:3794";
        out.crs_units_per_voxel = 0.5;
        return out;
    }();
    const std::string body = as_text(input);
    (void)read(body, placed, {});
    server.post(body);
}

}  // namespace terravox::fuzz
