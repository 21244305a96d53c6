#include <semaphore.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <iostream>
#include <memory>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/program.hpp"
#include "common/util/version.hpp"
#include "voxelserver/http/options.hpp"
#include "voxelserver/http/router.hpp"
#include "voxelserver/http/server.hpp"
#include "voxelserver/voxelize/lidar_world.hpp"

namespace {

using namespace terravox;

sem_t g_stop;  // sem_post is one of the few calls allowed in a signal handler

/// SIGINT and SIGTERM are held back while this lives, so that threads started meanwhile never see them.
class SignalsHeld {
public:
    SignalsHeld() {
        sigset_t held;
        sigemptyset(&held);
        sigaddset(&held, SIGINT);
        sigaddset(&held, SIGTERM);
        pthread_sigmask(SIG_BLOCK, &held, &m_before);
    }
    ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &m_before, nullptr); }
    SignalsHeld(const SignalsHeld&) = delete;
    SignalsHeld& operator=(const SignalsHeld&) = delete;

private:
    sigset_t m_before{};
};

// The first signal drains; a second one of the same kind ends the process as if nothing had been installed.
void install_stop_handlers() {
    sem_init(&g_stop, 0, 0);
    struct sigaction action {};
    action.sa_handler = [](int) { sem_post(&g_stop); };
    action.sa_flags = static_cast<int>(SA_RESTART | SA_RESETHAND);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

void wait_for_stop() {
    while (sem_wait(&g_stop) != 0) {
    }
}

ExitCode serve(http::Options& options) {
    util::set_up_log(options.log_level);
    std::signal(SIGPIPE, SIG_IGN);
    const http::BoxRepliesOptions replies = http::finish(options);
    http::check_can_listen(options.server);  // before minutes of decoding
    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(options.world, times);
    const auto stats = world->stats();
    spdlog::info("{} points in {} files, {} orthophotos, {}, voxels of {} m", stats.points, stats.files, stats.orthophotos, world->info().crs,
                 world->info().voxel_m);

    http::Router router(*world, times, replies);
    std::unique_ptr<http::Server> server;
    {
        const SignalsHeld held;
        server = std::make_unique<http::Server>(router, options.server);
        install_stop_handlers();
    }
    std::cout << "listening on " << server->url() << std::endl;
    wait_for_stop();
    spdlog::info("stopping: running requests are finished first");
    server->stop();
    return ExitCode::kDone;
}

int run(int argc, char** argv) {
    CLI::App app{"Serves voxel boxes of a place, made from LiDAR files, over HTTP.", "terravox-voxelserver"};
    app.set_version_flag("--version", std::string("terravox ") + kVersion);
    http::Options options;
    http::add_options(app, options);
    if (const auto code = util::parse_arguments(app, argc, argv)) return *code;
    return static_cast<int>(serve(options));
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_program([&] { return run(argc, argv); });
}
