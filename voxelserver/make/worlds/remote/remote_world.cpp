#include "voxelserver/make/worlds/remote/remote_world.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/json_text.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/make/worlds/remote/batch_client.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"
#include "voxelserver/make/worlds/remote/retrying_client.hpp"

namespace terravox::remote {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMaxText_bytes = std::size_t{4} << 20;
constexpr milliseconds kMaxOpening{60'000};
constexpr int kLoaders = 8;
// Boxes: most of the cost of a request is shared, and a lost one loses little.
constexpr int kBatch = 32;

std::string_view to_text(const HttpReply& reply) noexcept {
    return {reinterpret_cast<const char*>(reply.body.data()), reply.body.size()};
}

/// The only form that is sent back: a server's reply could be anything.
bool is_edition(const std::string& text) noexcept {
    constexpr std::size_t kDigits = 32;
    return text.size() == kDigits &&
           text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

class RemoteWorld final : public voxel::World {
public:
    RemoteWorld(std::string url, util::StageTimes& times, milliseconds box_timeout,
                const std::stop_token& stop, const HttpAccess& access, RetryClock& clock)
        : m_url(checked(std::move(url))),
          m_times(times),
          m_client(box_timeout, access, clock),
          m_batches(m_client.http(), times, m_url, m_client.timeout()),
          m_ending(stop, [this] { m_client.stop(); }) {
        const auto text = m_client.fetch(
            m_url + "/v2/world", kMaxText_bytes, {}, std::min(m_client.timeout(), kMaxOpening),
            [this](const std::string&, const HttpReply& reply) {
                m_edition = is_edition(reply.edition) ? reply.edition : "";
                return std::string(to_text(reply));
            });
        if (!m_edition.empty())
            m_client.http().add_header("Terravox-Edition: " + m_edition);
        m_info = voxel::world_from_json(
            text, m_url);  // another version is not damage that a retry would resolve
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        const util::StageTimes::Scope timed(m_times, "box transmission");
        return m_client.fetch(m_url + "/v2/boxes/" + voxel::to_string(key), kMaxBox_bytes, {},
                              m_client.timeout(),
                              [&](const std::string& url, const HttpReply& reply) {
                                  return read_box(key, url, reply);
                              });
    }

    void boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) override {
        std::vector<voxel::BoxKey> missing(keys.begin(), keys.end());
        if (m_client.is_reachable())
            m_batches.fetch(missing, [&](const voxel::BoxKey& key, voxel::BoxOutcome outcome) {
                m_client.on_reply();
                take(key, std::move(outcome));
            });
        World::boxes(missing, take);
    }
    [[nodiscard]] int preferred_batch() const noexcept override { return kBatch; }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        return std::max(kLoaders, threads);
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        const std::string place =
            std::to_string(level) + "/" + std::to_string(bx) + "/" + std::to_string(bz);
        return m_client.fetch(
            m_url + "/v2/columns/" + place, kMaxText_bytes, {}, m_client.timeout(),
            [](const std::string& url, const HttpReply& reply) {
                const auto json = util::parse_json(to_text(reply));
                voxel::ColumnExtent out;
                if (!read_whole(json, "by_begin", out.by_begin) ||
                    !read_whole(json, "by_end", out.by_end))
                    throw util::Error("fetch {}: not the reply of a voxel server", url);
                return out;
            });
    }

    [[nodiscard]] std::string edition() const override { return m_edition; }
    void stop() noexcept override { m_client.stop(); }

private:
    static std::string checked(std::string url) {
        (void)HttpOrigin::of(url);
        while (!url.empty() && url.back() == '/')
            url.pop_back();
        return url;
    }

    static std::shared_ptr<const voxel::Box> read_box(const voxel::BoxKey& key,
                                                      const std::string& url,
                                                      const HttpReply& reply) {
        if (reply.status == 204)
            return nullptr;  // the server reports air
        if (reply.content_type != voxel::kBoxMediaType)
            throw util::Error("fetch {}: the reply is of type '{}'; allowed: {}", url,
                              reply.content_type, voxel::kBoxMediaType);
        const bool packed = reply.content_encoding == "zstd";
        if (!packed && !reply.content_encoding.empty() && reply.content_encoding != "identity")
            throw util::Error("fetch {}: the reply is encoded as '{}'; allowed: zstd, identity",
                              url, reply.content_encoding);
        auto box = packed ? voxel::decompress_box(reply.body, url)
                          : voxel::Box::from_blob(reply.body, url);
        if (box->key() != key)
            throw util::Error("fetch {}: the server sent box {}", url,
                              voxel::to_string(box->key()));
        return box;
    }

    static bool read_whole(const nlohmann::json& json, const char* name, std::int32_t& into) {
        if (!json.is_object() || !json.contains(name) || !json[name].is_number_integer())
            return false;
        const auto value = json[name].get<std::int64_t>();
        into = static_cast<std::int32_t>(value);
        return into == value;
    }

    const std::string m_url;
    util::StageTimes& m_times;
    RetryingClient m_client;
    BatchClient m_batches;
    voxel::WorldInfo m_info;
    std::string m_edition;  ///< from the first reply; empty: the server sends none
    std::stop_callback<std::function<void()>> m_ending;
};

}  // namespace

std::unique_ptr<voxel::World> open_remote_world(const std::string& url, util::StageTimes& times,
                                                milliseconds box_timeout,
                                                const std::stop_token& stop,
                                                const HttpAccess& access, RetryClock& clock) {
    return std::make_unique<RemoteWorld>(url, times, box_timeout, stop, access, clock);
}

}  // namespace terravox::remote

namespace terravox::worlds {
namespace {

std::unique_ptr<voxel::World> open_server(const OpenRequest& request) {
    return remote::open_remote_world(request.input(), request.times, request.options.box_timeout,
                                     request.stop, remote::access_of_environment());
}

}  // namespace

constinit const WorldKind kServerKind{
    .noun = "the address of a voxel server",
    .input = "the http:// address of a voxel server or box archive",
    .recognises = is_http_address,
    .open = open_server,
    .flags = "--processing-box-timeout-s",
    .is_path = false,
    .farm_access = FarmAccess::kByAddress,
};

}  // namespace terravox::worlds
