#include <terravox/error.hpp>
#include <terravox/server.hpp>

#include <mutex>
#include <random>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/secret.hpp"
#include "common/util/stage_times.hpp"
#include "common/voxel/fingerprint.hpp"
#include "common/voxel/material.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/state.hpp"
#include "raytracer/core/material/appearance.hpp"
#include "voxelserver/serve/boxes/box_cache.hpp"
#include "voxelserver/serve/host/host.hpp"
#include "voxelserver/serve/host/host_names.hpp"
#include "voxelserver/serve/http/map_view.hpp"
#include "voxelserver/serve/http/router.hpp"

namespace terravox {
namespace {

constexpr int kQueue = 64;         ///< boxes that may wait to be made
constexpr int kSpareThreads = 32;  ///< for requests that need no box to be made

/// An open world as the server wants it. The state of its inputs is not known, so each server
/// counts as one of its own, and no client keeps boxes longer than that.
class OpenWorldForServing final : public voxel::ProvenanceWorld {
public:
    explicit OpenWorldForServing(voxel::World& world) : m_world(world) {
        std::random_device random;
        for (std::uint64_t& part : m_fingerprint)
            part = (std::uint64_t{random()} << 32) | random();
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_world.info(); }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        return m_world.box(key);
    }
    void boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) override {
        m_world.boxes(keys, take);
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_world.column(level, bx, bz);
    }
    [[nodiscard]] bool may_hold(const voxel::BoxRange& boxes) override {
        return m_world.may_hold(boxes);
    }
    [[nodiscard]] std::vector<std::string> damage() const override { return m_world.damage(); }
    [[nodiscard]] voxel::BoxWithInputs box_with_inputs(const voxel::BoxKey& key) override {
        return {m_world.box(key), {}};
    }
    [[nodiscard]] voxel::Fingerprint fingerprint(
        const voxel::InputExtent& /*reach*/) const override {
        return m_fingerprint;
    }

private:
    voxel::World& m_world;
    voxel::Fingerprint m_fingerprint{};
};

std::size_t to_bytes(int memory_mib) {
    constexpr int kLeast_mib = 16;
    constexpr int kMost_mib = 1 << 20;
    if (memory_mib < kLeast_mib || memory_mib > kMost_mib)
        throw util::UsageError("serve a world: memory_mib = " + std::to_string(memory_mib) +
                               "; allowed: " + std::to_string(kLeast_mib) + " to " +
                               std::to_string(kMost_mib));
    return static_cast<std::size_t>(memory_mib) << 20;
}

boxes::BoxCacheOptions cache_options(const ServerOptions& options, voxel::World& world) {
    boxes::BoxCacheOptions out;
    // The map's tiles take the last quarter.
    out.memory_bytes = to_bytes(options.memory_mib) / 4 * 3;
    out.makers = world.useful_concurrency(thread::thread_count(options.threads));
    out.queue = kQueue;
    out.max_requests = out.makers + kQueue;
    out.downsample = false;
    // The world belongs to its program, too, which may want all cores.
    out.ahead = false;
    return out;
}

http::HostOptions listen_options(const ServerOptions& options, int makers) {
    http::HostOptions out;
    out.bind = options.bind;
    out.port = options.port;
    out.request_threads = makers + kQueue + kSpareThreads;
    return out;
}

void check(const ServerOptions& options) {
    constexpr int kMostPort = 65535;
    if (options.port < 0 || options.port > kMostPort)
        throw util::UsageError("serve a world: port = " + std::to_string(options.port) +
                               "; allowed: 0 (any that is free) to 65535");
    check_threads(options.threads);
    if (!options.token.empty())
        util::check_token(options.token, "serve a world");
}

}  // namespace

struct Server::Impl {
    Impl(std::shared_ptr<WorldState> from, const ServerOptions& options)
        : state(std::move(from)),
          world(*state->world),
          boxes(world, state->times, cache_options(options, *state->world)),
          map(boxes, {voxel::load_palette(material::find_materials(""))},
              to_bytes(options.memory_mib) / 4),
          router(service(), options.token, http::HostNames(options.bind, options.names)),
          server(router, listen_options(options, boxes_made_at_once(options))) {}

    [[nodiscard]] int boxes_made_at_once(const ServerOptions& options) const {
        return cache_options(options, *state->world).makers;
    }
    [[nodiscard]] http::Service service() {
        http::Service out{world, state->times, boxes};
        out.map = &map;
        out.edition = voxel::to_hex(world.fingerprint({}));
        return out;
    }

    const std::shared_ptr<WorldState> state;  ///< outlives all that follows
    OpenWorldForServing world;
    boxes::BoxCache boxes;
    http::MapView map;
    http::Router router;
    http::Host server;
    std::once_flag stopped;
};

Server::Server(const World& world, const ServerOptions& options) {
    guarded([&] {
        check(options);
        m_impl = std::make_unique<Impl>(world.m_state, options);
        if (options.token.empty() && !http::is_loopback(options.bind))
            util::log_warn(
                "serve a world: whoever reaches {} may read it; a token would prevent that",
                options.bind);
    });
}

Server::~Server() {
    stop();
    if (!has_threads_here())
        (void)m_impl.release();
}

int Server::port() const noexcept {
    return m_impl->server.port();
}

std::string Server::url() const {
    return m_impl->server.url();
}

void Server::stop() noexcept {
    // In a forked process there are no threads to wait for.
    if (!has_threads_here())
        return;
    std::call_once(m_impl->stopped, [&] { m_impl->server.stop([&] { m_impl->boxes.refuse(); }); });
}

}  // namespace terravox
