#include "voxelserver/serve/http/route_answers.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/util/process_memory.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"
#include "voxelserver/serve/host/metrics_text.hpp"

namespace terravox::http {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxKeys = 100'000;  // limit for each kind in a reply of /v2/cached

// Written directly as text: as values of a JSON library a long list would cost fifty times as
// much.
std::string boxes_text(const std::vector<voxel::BoxKey>& keys) {
    std::string out = "[";
    for (const voxel::BoxKey& key : keys)
        out.append(out.size() > 1 ? ",[" : "[")
            .append(std::to_string(key.bx))
            .append(",")
            .append(std::to_string(key.by))
            .append(",")
            .append(std::to_string(key.bz))
            .append("]");
    return out + "]";
}

json cache_json(const util::CacheStats& cache, std::uint64_t limit_bytes) {
    return {{"hits", cache.hits},   {"misses", cache.misses},   {"evictions", cache.evictions},
            {"bytes", cache.bytes}, {"entries", cache.entries}, {"limit_bytes", limit_bytes}};
}

json disk_json(boxes::DiskCache* disk) {
    if (disk == nullptr)
        return json();
    const boxes::DiskStats d = disk->stats();
    json out = cache_json(d, disk->limit_bytes());
    out.update({{"writes", d.writes}, {"dropped", d.dropped}, {"damaged", d.damaged}});
    return out;
}

json requests_json(const RequestCounts& counts) {
    json out = json::object();
    for (const RouteFacts& route : routes())
        for (const auto& [status, count] : counts.statuses(route.route))
            out[std::string(route.path)][std::to_string(status)] = count;
    return out;
}

}  // namespace

Response answer_health(const Service& service, const RouteRequest& call) {
    const Health now = service.health();
    if (now.state == Health::State::kFailed)
        return problem(503,
                       call.has_token
                           ? "failed: " + without_folders(now.reason)
                           : "failed: only kept boxes can be served; the server's log says why")
            .add("Retry-After", "60");
    return reply(200, "text/plain; charset=utf-8",
                 now.state == Health::State::kOpening ? "opening\n" : "ok\n")
        .add("Cache-Control", "no-store");
}

Response answer_cached(Service& service, const RouteRequest& call) {
    const auto level = parse_int32(call.parts.part[2]);
    if (!level)
        return not_numbers(call.request);
    if (const int levels = service.world.info().levels; *level < 0 || *level >= levels)
        return no_such_level(*level, levels);
    boxes::DiskCache* disk = service.boxes.disk();
    const auto in_memory = service.boxes.in_memory(*level, kMaxKeys);
    const auto on_disk = disk != nullptr ? disk->keys(boxes::Kind::kBox, *level, kMaxKeys)
                                         : std::vector<voxel::BoxKey>{};
    const auto s = service.boxes.stats();
    const std::uint64_t changes =
        s.made + s.memory.evictions + (disk != nullptr ? disk->changes() : 0);
    std::string out = "{\"level\":" + std::to_string(*level) +
                      ",\"changes\":" + std::to_string(changes) +
                      ",\"memory\":" + boxes_text(in_memory) + ",\"disk\":" + boxes_text(on_disk);
    out += std::string(",\"truncated\":") +
           (in_memory.size() == kMaxKeys || on_disk.size() == kMaxKeys ? "true" : "false") + "}\n";
    return json_reply(std::move(out), call.request);
}

Response answer_stats(Service& service, const RouteRequest& call, const RequestCounts& counts,
                      double uptime_s) {
    json stages = json::array();
    for (const auto& s : service.times.stages())
        stages.push_back({{"name", s.name}, {"seconds", s.seconds}, {"count", s.count}});
    const auto b = service.boxes.stats();
    json cache = cache_json(b.memory, service.boxes.limit_bytes());
    cache["waits"] = b.memory.waits;
    json prepare;
    if (service.preparer != nullptr) {
        const auto p = service.preparer->progress();
        prepare = {{"done", p.done}, {"total", p.total}, {"failed", p.failed}};
    }
    const json out = {
        {"version", kVersion},
        {"uptime_s", uptime_s},
        {"stages", stages},
        {"requests", requests_json(counts)},
        {"replies", {{"count", counts.replies()}, {"bytes", counts.bytes()}}},
        {"cache", cache},
        {"disk", disk_json(service.boxes.disk())},
        {"making",
         {{"running", b.admission.running + b.admission.ahead_running},
          {"waiting", b.admission.waiting},
          {"ahead_waiting", b.ahead_waiting},
          {"made", b.made},
          {"made_ahead", b.made_ahead},
          {"failed", b.failed}}},
        {"memory",
         {{"rss_bytes", util::resident_bytes()}, {"limit_bytes", service.memory_limit_bytes}}},
        {"jobs", jobs_json(service.jobs)},
        {"prepare", prepare}};
    return json_reply(out.dump(-1, ' ', false, json::error_handler_t::replace) + "\n",
                      call.request);
}

namespace {

void write_requests(MetricsText& text, const RequestCounts& counts) {
    text.family("terravox_http_replies_total", "counter", "Replies sent.");
    for (const RouteFacts& route : routes())
        for (const auto& [status, count] : counts.statuses(route.route))
            text.value(static_cast<double>(count),
                       metrics_label("route", route.path) + "," +
                           metrics_label("status", std::to_string(status)));
    text.one("terravox_http_body_bytes_total", "counter", "Bytes of bodies sent.",
             static_cast<double>(counts.bytes()));
    text.family("terravox_http_seconds", "histogram",
                "Time from a request's header until its reply is ready to be sent.");
    for (const RouteFacts& route : routes()) {
        const auto times = counts.times(route.route);
        if (times.count == 0)
            continue;
        const std::string name = metrics_label("route", route.path);
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < RequestCounts::kBuckets; ++i) {
            sum += times.buckets[i];
            char end[24] = "+Inf";
            if (i < RequestCounts::kBucketEnds_s.size())
                std::snprintf(end, sizeof end, "%g", RequestCounts::kBucketEnds_s[i]);
            text.value(static_cast<double>(sum), name + "," + metrics_label("le", end), "_bucket");
        }
        text.value(times.seconds, name, "_sum");
        text.value(static_cast<double>(times.count), name, "_count");
    }
}

struct NamedCache {
    const char* name;
    util::CacheStats stats;
    std::uint64_t limit_bytes;
};

void write_caches(MetricsText& text, const std::vector<NamedCache>& caches) {
    struct Family {
        const char *name, *type, *help;
        std::uint64_t util::CacheStats::* value;
    };
    static constexpr Family kFamilies[] = {
        {"terravox_cache_hits_total", "counter", "Boxes found.", &util::CacheStats::hits},
        {"terravox_cache_misses_total", "counter", "Boxes not found.", &util::CacheStats::misses},
        {"terravox_cache_evictions_total", "counter", "Boxes that had to go.",
         &util::CacheStats::evictions},
        {"terravox_cache_bytes", "gauge", "Bytes kept.", &util::CacheStats::bytes},
        {"terravox_cache_entries", "gauge", "Boxes kept.", &util::CacheStats::entries},
    };
    for (const Family& f : kFamilies) {
        text.family(f.name, f.type, f.help);
        for (const NamedCache& c : caches)
            text.value(static_cast<double>(c.stats.*f.value), metrics_label("cache", c.name));
    }
    text.family("terravox_cache_limit_bytes", "gauge", "Most bytes that are kept.");
    for (const NamedCache& c : caches)
        text.value(static_cast<double>(c.limit_bytes), metrics_label("cache", c.name));
}

}  // namespace

Response answer_metrics(Service& service, const RequestCounts& counts, double uptime_s) {
    MetricsText text;
    text.family("terravox_build_info", "gauge", "The version that runs.");
    text.value(1, metrics_label("version", kVersion));
    text.one("terravox_uptime_seconds", "gauge", "Time since the start.", uptime_s);
    text.one("process_resident_memory_bytes", "gauge", "Resident memory.",
             static_cast<double>(util::resident_bytes()));
    text.one("terravox_memory_limit_bytes", "gauge", "The limit of memory that was set.",
             static_cast<double>(service.memory_limit_bytes));
    write_requests(text, counts);
    const auto b = service.boxes.stats();
    std::vector<NamedCache> caches = {{"memory", b.memory, service.boxes.limit_bytes()}};
    if (boxes::DiskCache* disk = service.boxes.disk(); disk != nullptr)
        caches.push_back({"disk", disk->stats(), disk->limit_bytes()});
    write_caches(text, caches);
    text.one("terravox_boxes_waited_total", "counter",
             "Requests that waited for a box that was being made already.",
             static_cast<double>(b.memory.waits));
    text.one("terravox_boxes_made_total", "counter", "Boxes made.", static_cast<double>(b.made));
    text.one("terravox_boxes_made_ahead_total", "counter", "Of these, made before any request.",
             static_cast<double>(b.made_ahead));
    text.one("terravox_boxes_failed_total", "counter", "Boxes that could not be made.",
             static_cast<double>(b.failed));
    text.one("terravox_boxes_making", "gauge", "Boxes being made now.",
             b.admission.running + b.admission.ahead_running);
    text.one("terravox_boxes_waiting", "gauge", "Requested boxes that wait to be made.",
             b.admission.waiting);
    const auto stages = service.times.stages();
    text.family("terravox_step_seconds_total", "counter",
                "Time spent in a step, summed over threads.");
    for (const auto& s : stages)
        text.value(s.seconds, metrics_label("step", s.name));
    text.family("terravox_step_runs_total", "counter", "How often a step ran.");
    for (const auto& s : stages)
        text.value(static_cast<double>(s.count), metrics_label("step", s.name));
    return text.take_reply();
}

}  // namespace terravox::http
