#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/worlds/remote/box_batch.hpp"
#include "voxelserver/worlds/remote/failed_try.hpp"

namespace terravox::remote {

/// Asks a voxel server for many boxes in one request (docs/formats/http.md: Batch). Thread-safe.
///
/// A batch is a shortcut: what does not come in it is asked for box by box, with the timeout and
/// the reasons of RemoteWorld::box(). So a lost or damaged stream is tried again once, and a server
/// that has no place for batches, or knows none, is left alone with them.
class BatchClient {
public:
    /// Client and times must outlive it. @param timeout for one request; a quarter of it while
    /// nothing comes
    BatchClient(HttpClient& client, util::StageTimes& times, std::string server_url,
                std::chrono::milliseconds timeout)
        : m_client(client),
          m_times(times),
          m_url(std::move(server_url) + "/v2/boxes"),
          m_timeout(timeout) {}

    /// Participants over what comes and takes it out of `missing`; boxes and air only, failures
    /// stay. Ends soon after HttpClient::stop().
    void ask(std::vector<voxel::BoxKey>& missing, const voxel::TakeBox& take);

private:
    void ask_once(std::vector<voxel::BoxKey>& missing, const voxel::TakeBox& take);
    void check(const HttpReply& reply, const BatchStream& stream);
    [[nodiscard]] bool welcome() const noexcept {
        return m_client.now().time_since_epoch().count() >= m_from.load(std::memory_order_relaxed);
    }

    HttpClient& m_client;
    util::StageTimes& m_times;
    const std::string m_url;
    const std::chrono::milliseconds m_timeout;
    std::atomic<Retry::Clock::rep> m_from{Retry::Clock::time_point::min()
                                              .time_since_epoch()
                                              .count()};  ///< when batches may be asked for
};

}  // namespace terravox::remote
