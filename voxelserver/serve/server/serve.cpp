#include "voxelserver/serve/server/serve.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "common/thread/stop.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/voxel/fingerprint.hpp"
#include "common/voxel/material.hpp"
#include "voxelserver/serve/host/host_names.hpp"
#include "voxelserver/serve/http/map_view.hpp"
#include "voxelserver/serve/http/router.hpp"
#include "voxelserver/serve/jobs/job_queue.hpp"
#include "voxelserver/serve/server/open_for_serving.hpp"

namespace terravox::serve {
namespace {

std::string size_text(double bytes) {
    return bytes >= 1e9 ? fmt::format("{:.1f} GB", bytes / 1e9)
                        : fmt::format("{:.0f} MB", bytes / 1e6);
}

std::string crs_text(const voxel::WorldInfo& info) {
    if (!info.crs.empty())
        return info.crs;
    return info.crs_wkt.empty() ? "coordinates of its own" : "a CRS without a name";
}

std::string area_text(const voxel::WorldInfo& info) {
    const auto km = [&](int axis) {
        return (info.bounds.max[static_cast<std::size_t>(axis)] -
                info.bounds.min[static_cast<std::size_t>(axis)]) *
               info.voxel_m / 1000;
    };
    std::string out = fmt::format("{:.2f} x {:.2f} km, {}", km(0), km(2), crs_text(info));
    if (info.centre)
        out += fmt::format(", around {:.4f} {} {:.4f} {}", std::abs(info.centre->lat_deg),
                           info.centre->lat_deg < 0 ? "S" : "N", std::abs(info.centre->lon_deg),
                           info.centre->lon_deg < 0 ? "W" : "E");
    return out;
}

}  // namespace

void announce(const worlds::ServedWorld& world, const Options& options, const Plan& plan,
              const std::string& url) {
    const voxel::WorldInfo& info = world.info();
    const auto say = [](const char* what, const std::string& text) {
        std::cout << fmt::format("  {:<7} {}\n", what, util::printable(text));
    };
    say("world", info.title + ", " + area_text(info));
    say("data", fmt::format("{}; voxels of {} m, levels 0 to {}", world.summary(), info.voxel_m,
                            info.levels - 1));
    if (!info.licence.empty())
        say("licence", info.licence);
    const std::string where =
        plan.boxes.file.empty()
            ? "nothing on disk"
            : fmt::format("{} on disk in {}",
                          size_text(static_cast<double>(options.cache_mib) * 1048576.0),
                          plan.boxes.file.parent_path().string());
    say("boxes",
        std::string(options.prepare ? "all are made now" : "are made on request") +
            fmt::format("; kept: {} of memory in all, {}",
                        size_text(static_cast<double>(options.memory_mib) * 1048576.0), where));
    say("map", url + "/");
    say("stop", "Ctrl-C");
    std::cout << std::flush;
    const std::string& bind = options.server.bind;
    if (!http::is_loopback(bind) && plan.token.empty())
        util::log_warn(
            "every client that reaches {} is answered: --token-file requires a token, "
            "config/nginx/ "
            "is a front for open networks",
            bind);
}

namespace {

constexpr std::uint64_t kReportEach_percent = 10;
constexpr int kBarWidth = 30;

std::string duration_text(double seconds) {
    char out[32];
    const auto whole = static_cast<long>(seconds + 0.5);
    if (whole >= 3600)
        std::snprintf(out, sizeof out, "%ld h %02ld min", whole / 3600, whole / 60 % 60);
    else if (whole >= 60)
        std::snprintf(out, sizeof out, "%ld min %02ld s", whole / 60, whole % 60);
    else
        std::snprintf(out, sizeof out, "%ld s", whole);
    return out;
}

}  // namespace

void PrepareProgress::show(const boxes::Preparer::Progress& now) {
    const double seconds = std::chrono::duration<double>(Clock::now() - m_start).count();
    const double share =
        now.total > 0 ? static_cast<double>(now.done) / static_cast<double>(now.total) : 1;
    if (m_bar) {
        const int full = static_cast<int>(share * kBarWidth);
        const std::string bar = std::string(static_cast<std::size_t>(full), '#') +
                                std::string(static_cast<std::size_t>(kBarWidth - full), '.');
        const std::string left =
            share > 0.01 ? ", " + duration_text(seconds / share - seconds) + " left" : "";
        std::fprintf(stderr, "\rpreparing [%s] %3.0f %%, %llu of %llu boxes%s\033[K", bar.c_str(),
                     share * 100, static_cast<unsigned long long>(now.done),
                     static_cast<unsigned long long>(now.total), left.c_str());
        return;
    }
    const auto percent = static_cast<std::uint64_t>(share * 100);
    if (percent < m_reported_percent + kReportEach_percent)
        return;
    m_reported_percent = percent - percent % kReportEach_percent;
    util::log_info("preparing: {} % of {} boxes", m_reported_percent, now.total);
}

void PrepareProgress::end(const boxes::Preparer::Progress& now) {
    if (m_bar)
        std::fprintf(stderr, "\r\033[K");
    const double seconds = std::chrono::duration<double>(Clock::now() - m_start).count();
    if (now.failed == 0 && now.done >= now.total)
        util::log_info("prepared: {} boxes in {}", now.done, duration_text(seconds));
    else
        util::log_warn("prepared: {} of {} boxes in {}; {} cannot be made", now.done - now.failed,
                       now.total, duration_text(seconds), now.failed);
}

namespace {

constexpr std::chrono::milliseconds kProgressInterval{200};

std::unique_ptr<boxes::Preparer> start_preparing(boxes::BoxCache& cache, int lanes) {
    return std::make_unique<boxes::Preparer>(
        cache, lanes, [](const std::string& why) { util::log_warn("prepare: {}", why); });
}

/// Reports the progress until preparing has finished, a stop is requested, or `useless` returns
/// true.
/// @return whether a stop was requested
template <class Useless>
bool watch(const boxes::Preparer& preparer, bool bar, const std::stop_token& stop,
           const Useless& useless) {
    PrepareProgress progress(bar);
    while (!stop.stop_requested() && !preparer.finished() && !useless()) {
        progress.show(preparer.progress());
        (void)thread::wait_for_stop(stop, kProgressInterval);
    }
    progress.end(preparer.progress());
    return stop.stop_requested();
}

util::ExitCode prepare_only(boxes::BoxCache& cache, const Plan& plan, bool bar,
                            const std::stop_token& stop) {
    const auto preparer = start_preparing(cache, plan.boxes.makers);
    boxes::DiskCache& disk = *cache.disk();
    const bool stopped = watch(*preparer, bar, stop, [&] { return disk.failing(); });
    preparer->stop();
    if (stopped)
        cache.world().stop();
    const auto end = preparer->progress();
    disk.flush();
    if (const auto dropped = disk.stats().dropped; disk.failing() || dropped > 0)
        throw util::Error(
            "prepare the world: " +
            (disk.failing() ? std::string("finished boxes") : std::to_string(dropped) + " boxes") +
            " cannot be kept in " + disk.file().string() + "; the next start goes on from there");
    if (stopped)
        throw util::Error("prepare the world: stopped after " + std::to_string(end.done) + " of " +
                          std::to_string(end.total) + " boxes; the next start goes on from there");
    if (const auto d = disk.stats(); d.evictions > 0)
        util::log_warn("prepare: {} boxes were evicted again; a larger --cache-mib keeps them",
                       d.evictions);
    return end.failed > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

http::Health read_health(const worlds::ServedWorld& world) {
    using State = http::Health::State;
    if (std::string why = world.failure(); !why.empty())
        return {State::kFailed, std::move(why)};
    return {world.is_open() ? State::kOk : State::kOpening};
}

/// @throws UsageError when preparing would not terminate, or its results would not be kept
void check_can_prepare(const Options& options, const worlds::ServedWorld& world) {
    if (!options.prepare && !options.prepare_only)
        return;
    constexpr std::int64_t kMaxColumns = 100'000'000;
    const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, 0);
    const std::int64_t columns =
        (std::int64_t{range.max.bx} - range.min.bx) * (std::int64_t{range.max.bz} - range.min.bz);
    if (columns > kMaxColumns)
        throw util::UsageError("prepare the world: it has " + std::to_string(columns) +
                               " columns of boxes; allowed: up to " + std::to_string(kMaxColumns));
    if (options.prepare_only && !world.has_lasting_fingerprint())
        throw util::UsageError(
            "prepare the world: its server does not name the state of its world, so that no later "
            "start could use the boxes; allowed: a server that sends an edition, an entity tag or "
            "a date");
}

/// @throws UsageError when pages of other origins are to read an archive that is not there
void check_can_share(const Options& options, const worlds::ServedWorld& world) {
    if (!options.shared_origins.empty() && world.archive_file().empty())
        throw util::UsageError("share the archive with pages: --allow-origin with " +
                               world.summary() + "; allowed: with a box archive of this machine");
}

/// Adjusts the settings of the plan that depend on the kind of world.
void fit_to_world(const worlds::ServedWorld& world, Plan& plan) {
    plan.boxes.downsample = !world.makes_all_levels();
    plan.boxes.makers = world.useful_concurrency(plan.boxes.makers);
    // Another server must not spend time on boxes that were not requested.
    if (world.is_remote())
        plan.boxes.ahead = false;
    if (!world.has_lasting_fingerprint())
        plan.boxes.file.clear();
}

/// Identifies the state of all inputs of the boxes.
std::string make_edition(const worlds::ServedWorld& world) {
    const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, 0);
    return voxel::to_hex(
        world.fingerprint({range.min.bx, range.min.bz, range.max.bx, range.max.bz}));
}

void set_up_process(const Options& options) {
    util::set_up_log(options.log_level,
                     options.log_json ? util::LogFormat::kJson : util::LogFormat::kText);
    std::signal(SIGPIPE, SIG_IGN);
    // Exceeding the file size limit is then an error to report, like a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    // Whoever has started this may ignore it, and nobody could wait for the processes of jobs then.
    std::signal(SIGCHLD, SIG_DFL);
}

/// @param opened, times, cache must outlive the service
http::Service make_service(const Options& options, const OpenedForServing& opened,
                           util::StageTimes& times, boxes::BoxCache& cache) {
    worlds::ServedWorld& world = *opened.world;
    http::Service out{world, times, cache};
    if (opened.lidar != nullptr)
        out.squares = [&opened, list = std::make_shared<SquareList>(opened.store)] {
            const DeferredWorld& lidar = *opened.lidar;
            return list->entries(lidar.squares(), lidar.info());
        };
    out.health = [&world] { return read_health(world); };
    out.edition = make_edition(world);
    out.archive = world.archive_file();
    out.memory_limit_bytes = static_cast<std::size_t>(options.memory_mib) << 20;
    return out;
}

/// Analyses for clients, and the server on loopback that gives them their boxes. It makes no jobs.
class Jobs {
public:
    /// @param service without jobs
    Jobs(const Options& options, const Plan& plan, const http::Service& service)
        : m_router(service, plan.token),
          m_server(m_router, server_options(options)),
          m_queue(queue_options(options, plan)) {}

    [[nodiscard]] jobs::JobQueue& queue() noexcept { return m_queue; }

private:
    static http::HostOptions server_options(const Options& options) {
        constexpr int kThreadsOfJob = 16;
        http::HostOptions out = options.server;
        out.bind = "127.0.0.1";
        out.port = 0;
        out.tls_certificate.clear();
        out.request_threads = options.jobs * kThreadsOfJob;
        out.drain_timeout = {};
        return out;
    }
    [[nodiscard]] jobs::QueueOptions queue_options(const Options& options, const Plan& plan) const {
        jobs::QueueOptions out;
        out.running = options.jobs;
        out.limits = options.job_limits;
        out.program = util::beside_program("terravox-raytracer");
        out.world = m_server.url();
        out.token = plan.token;
        return out;
    }

    http::Router m_router;
    http::Host m_server;
    jobs::JobQueue m_queue;  // its processes end before the server does
};

/// Lets running requests finish for some time, then cancels the rest.
void stop_serving(http::Host& server, boxes::BoxCache& cache, worlds::ServedWorld& world) {
    const auto stop_remote = [&] {
        if (world.is_remote())
            world.stop();
    };
    server.stop([&] {
        cache.refuse();
        stop_remote();
    });
    stop_remote();  // cancels the boxes that are being prepared
}

/// Serves the boxes over HTTP until a stop is requested; prepares them meanwhile where the options
/// say so.
void serve_boxes(const Options& options, const Plan& plan, const OpenedForServing& opened,
                 util::StageTimes& times, boxes::BoxCache& cache, bool bar,
                 const std::stop_token& stop) {
    worlds::ServedWorld& world = *opened.world;
    http::MapView map(cache, {voxel::load_palette(util::config_dir() / "materials.toml")},
                      plan.map_bytes);
    std::unique_ptr<boxes::Preparer> preparer;
    if (options.prepare)
        preparer = start_preparing(cache, plan.boxes.makers);
    http::Service service = make_service(options, opened, times, cache);
    service.map = &map;
    service.preparer = preparer.get();
    std::optional<Jobs> jobs;
    if (options.jobs > 0) {
        jobs.emplace(options, plan, service);
        service.jobs = &jobs->queue();
    }
    http::Router router(service, plan.token, plan.names, plan.origins);
    http::Host server(router, options.server);
    std::cout << "listening on " << server.url() << std::endl;
    // Everything that cached boxes do not need is done after the start, so that it does not delay
    // the start and the only threads are those that answer requests.
    world.begin_opening();
    map.scan_disk();
    announce(world, options, plan, server.url());
    if (preparer)
        (void)watch(*preparer, bar, stop, [] { return false; });
    while (!thread::wait_for_stop(stop, std::chrono::hours(1))) {
    }
    util::log_info("stopping: running requests are finished first");
    if (preparer)
        preparer->stop();
    if (jobs)
        jobs->queue().stop();
    stop_serving(server, cache, world);
}

}  // namespace

util::ExitCode serve(Options& options) {
    set_up_process(options);
    Plan plan = finish(options);
    if (!options.prepare_only)
        http::check_can_listen(options.server);  // fail before minutes of decoding

    // Some libraries treat a call that is interrupted by a signal as an error.
    const thread::SignalsBlocked blocked;
    thread::StopSignals::Options handling;
    handling.second_ends_program = true;
    const thread::StopSignals signals(std::move(handling));
    const std::stop_token stop = signals.token();
    util::StageTimes times;
    const OpenedForServing opened = open_for_serving(options, plan, times, stop);
    worlds::ServedWorld& world = *opened.world;
    check_can_prepare(options, world);
    check_can_share(options, world);
    fit_to_world(world, plan);
    boxes::BoxCache cache(world, times, plan.boxes);
    const bool bar = isatty(STDERR_FILENO) == 1 && !options.log_json && options.log_level == "info";
    if (options.prepare_only) {
        world.begin_opening();
        return prepare_only(cache, plan, bar, stop);
    }

    serve_boxes(options, plan, opened, times, cache, bar, stop);
    return util::ExitCode::kDone;
}

}  // namespace terravox::serve
