#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/remote/box_batch.hpp"
#include "voxelserver/make/worlds/remote/failed_try.hpp"

namespace terravox::remote {

/// Requests many boxes from a voxel server in one request (docs/formats/http.md: Batch).
/// Thread-safe.
///
/// A batch is an optimization: boxes that it does not deliver are requested one by one, with the
/// timeout and the errors of RemoteWorld::box(). So a lost or damaged stream is retried only once,
/// and batches are suspended for a server that has no capacity for them, or does not support them.
class BatchClient {
public:
    /// Client and times must outlive it.
    /// @param timeout for one request; a quarter of it while no data arrives
    BatchClient(HttpClient& client, util::StageTimes& times, std::string server_url,
                std::chrono::milliseconds timeout)
        : m_client(client),
          m_times(times),
          m_url(std::move(server_url) + "/v2/boxes"),
          m_timeout(timeout) {}

    /// Passes the received boxes to `take` and removes them from `missing`; boxes and air only,
    /// failures stay. Ends soon after HttpClient::stop().
    void fetch(std::vector<voxel::BoxKey>& missing, const voxel::TakeBox& take);

private:
    void fetch_once(std::vector<voxel::BoxKey>& missing, const voxel::TakeBox& take);
    void check(const HttpReply& reply, const BatchStream& stream);
    [[nodiscard]] bool welcome() const noexcept {
        return m_client.now().time_since_epoch().count() >= m_from.load(std::memory_order_relaxed);
    }

    HttpClient& m_client;
    util::StageTimes& m_times;
    const std::string m_url;
    const std::chrono::milliseconds m_timeout;
    /// The time from which batches may be requested.
    std::atomic<Retry::Clock::rep> m_from{
        Retry::Clock::time_point::min().time_since_epoch().count()};
};

}  // namespace terravox::remote
