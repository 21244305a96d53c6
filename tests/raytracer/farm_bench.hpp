#pragma once

#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "raytracer/core/tiles/tile_plan.hpp"
#include "raytracer/farm/coordinator/farm.hpp"
#include "raytracer/farm/wire/frames.hpp"
#include "raytracer/farm/worker/worker_daemon.hpp"
#include "tests/raytracer/farm/link_pair.hpp"
#include "tests/raytracer/landscape.hpp"

namespace terravox::test {

/// Sets the short deadlines and heartbeats of tests, before they are first read.
inline const bool kShortFarmTimes = ::setenv("TERRAVOX_FARM_TEST", "1", 1) == 0;

inline processors::PoolSettings pool_settings(Job& job) {
    processors::PoolSettings out;
    out.seed = 77;
    out.min_deadline = farm::farm_times().min_deadline;
    out.make_checker = [&job] {
        return std::make_shared<processors::ThreadProcessor>(job.view, job.blocks, 1);
    };
    return out;
}

/// A coordinator in this process, with workers at the other ends of links in memory.
class FarmBench {
public:
    /// @param source where workers may get boxes from
    explicit FarmBench(Job& job, std::optional<std::chrono::milliseconds> give_up = std::nullopt,
                       int check_every = 200, farm::BoxSource source = {})
        : m_job(job), m_farm(farm::FarmOptions{}, job.blocks, std::move(source)) {
        processors::PoolSettings settings = pool_settings(job);
        settings.give_up = give_up;
        settings.check_every = check_every;
        settings.gone = [this](processors::ProcessorPool::MemberId id, const std::string& why,
                               bool expelled) {
            {
                const std::lock_guard lock(m_mutex);
                if (expelled)
                    m_expelled.push_back(why);
            }
            m_farm.gone(id, why, expelled);
        };
        m_pool = std::make_unique<processors::ProcessorPool>(std::move(settings));
        m_farm.begin(*m_pool, job.view.scene, job.view);
    }
    ~FarmBench() {
        m_farm.end();
        m_pool.reset();
        for (auto& link : m_kill)
            link->abort();
        for (std::thread& t : m_threads)
            t.join();
    }

    /// Gives the coordinator's end of a new link to the farm.
    /// @return the other end
    std::unique_ptr<net::Link> plug() {
        auto [mine, theirs] = net::link_pair();
        m_threads.emplace_back(
            [this, link = std::shared_ptr<net::Link>(std::move(mine))]() mutable {
                (void)m_farm.serve(std::make_unique<Shared>(std::move(link)), "");
            });
        return std::move(theirs);
    }
    /// Adds a worker of this many threads.
    /// @param http servers that it may request boxes from itself
    /// @return its number
    std::size_t add_worker(int threads = 1, remote::HttpAccess http = remote::no_http_access()) {
        farm::WorkerDaemonOptions options;
        options.threads = threads;
        options.http = std::move(http);
        options.name = "worker " + std::to_string(m_daemons.size());
        options.memory_bytes = std::size_t{64} << 20;
        m_daemons.push_back(std::make_unique<farm::WorkerDaemon>(options));
        std::shared_ptr<net::Link> link = plug();
        m_kill.push_back(link);
        m_threads.emplace_back([daemon = m_daemons.back().get(), link] {
            (void)daemon->serve(std::make_unique<Shared>(link), false);
        });
        return m_daemons.size() - 1;
    }
    void kill(std::size_t worker) { m_kill[worker]->abort(); }
    /// It gives back what it has not begun, finishes the rest, and ends; meanwhile this returns.
    void drain(std::size_t worker) {
        m_threads.emplace_back([daemon = m_daemons[worker].get()] {
            std::stop_source stopped;
            stopped.request_stop();
            daemon->run(stopped.get_token());
        });
    }
    [[nodiscard]] farm::WorkerDaemon& daemon(std::size_t worker) { return *m_daemons[worker]; }
    /// Threads of this process join in.
    void add_threads(int threads) {
        m_pool->add(
            {"here",
             "threads",
             threads,
             true,
             false,
             std::make_shared<processors::ThreadProcessor>(m_job.view, m_job.blocks, threads),
             {}});
    }

    [[nodiscard]] processors::ProcessorPool& pool() { return *m_pool; }
    [[nodiscard]] farm::Farm& farm() { return m_farm; }
    [[nodiscard]] std::vector<std::string> expelled() {
        const std::lock_guard lock(m_mutex);
        return m_expelled;
    }
    render::RenderCounts render(output::Film& film) {
        return render::render_film({m_job.view, *m_pool, true, {}}, film);
    }

private:
    /// A link that another owner may end as well.
    class Shared final : public net::Link {
    public:
        explicit Shared(std::shared_ptr<net::Link> link) : m_link(std::move(link)) {}
        ~Shared() override { m_link->abort(); }
        bool send(farm::Frame frame) override { return m_link->send(std::move(frame)); }
        std::optional<farm::Frame> receive() override { return m_link->receive(); }
        void close(std::chrono::milliseconds timeout) noexcept override { m_link->close(timeout); }
        void abort() noexcept override { m_link->abort(); }
        const std::string& peer() const noexcept override { return m_link->peer(); }
        std::string why_ended() const override { return m_link->why_ended(); }
        Traffic traffic() const noexcept override { return m_link->traffic(); }

    private:
        std::shared_ptr<net::Link> m_link;
    };

    Job& m_job;
    std::mutex m_mutex;
    std::vector<std::string> m_expelled;
    farm::Farm m_farm;
    std::unique_ptr<processors::ProcessorPool> m_pool;
    std::vector<std::unique_ptr<farm::WorkerDaemon>> m_daemons;
    std::vector<std::shared_ptr<net::Link>> m_kill;
    std::vector<std::thread> m_threads;
};

/// A single pass, so that only the processors differ.
inline scene::Scene farm_scene(bool layers = false) {
    scene::Scene scene = small_scene();
    scene.quality.coarse_step = 1;
    if (layers)
        scene.output.layers = core::PictureLayers::kAll;
    return scene;
}

inline output::Film empty_film(const Job& job) {
    return {job.view.scene.output.size_px[0], job.view.scene.output.size_px[1],
            job.view.wants_layers()};
}

}  // namespace terravox::test
