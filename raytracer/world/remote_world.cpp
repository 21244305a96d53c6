#include "raytracer/world/remote_world.hpp"

#include <curl/curl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "common/voxel/box_codec.hpp"
#include "common/voxel/world_json.hpp"

namespace terravox {
namespace {

constexpr long kConnectTimeout_ms = 10'000;
constexpr long kStalled_s = 120;  // a cold square may take a while before the first byte
constexpr std::size_t kMostBytes = std::size_t{64} << 20;
constexpr std::array kRetryAfter_ms = {100, 400, 1600, 4000};  // for lost connections
constexpr int kBusyPatience_s = 300;  // a server that says 503 is alive and works off its queue
constexpr long kLongestWait_s = 30;

struct Reply {
    long status = 0;
    long retry_after_s = 0;
    std::string content_type, content_encoding;
    std::vector<std::byte> body;
};

/// libcurl handles that are free to use: a request takes one (with its open connection) and gives it back.
class Connections {
public:
    Connections() {
        static std::once_flag once;
        std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
        // Unpacked here: libcurl may have been built without zstd.
        add_header("Accept-Encoding: zstd");
        if (const char* token = std::getenv("TERRAVOX_TOKEN"); token != nullptr && *token != '\0') add_header(std::string("Authorization: Bearer ") + token);
    }
    ~Connections() {
        curl_slist_free_all(m_headers);
        for (CURL* handle : m_free) curl_easy_cleanup(handle);
    }
    Connections(const Connections&) = delete;
    Connections& operator=(const Connections&) = delete;

    /// @throws Error when no whole reply came
    Reply get(const std::string& url) {
        CURL* handle = take();
        Reply reply;
        curl_easy_reset(handle);
        curl_easy_setopt(handle, CURLOPT_URL, url.c_str());
        curl_easy_setopt(handle, CURLOPT_USERAGENT, (std::string("terravox/") + kVersion).c_str());
        curl_easy_setopt(handle, CURLOPT_HTTPHEADER, m_headers);
        curl_easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
        curl_easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
        curl_easy_setopt(handle, CURLOPT_CONNECTTIMEOUT_MS, kConnectTimeout_ms);
        curl_easy_setopt(handle, CURLOPT_LOW_SPEED_LIMIT, 1L);
        curl_easy_setopt(handle, CURLOPT_LOW_SPEED_TIME, kStalled_s);
        curl_easy_setopt(handle, CURLOPT_WRITEDATA, &reply.body);
        curl_easy_setopt(handle, CURLOPT_WRITEFUNCTION, +[](char* data, std::size_t size, std::size_t count, void* into) noexcept -> std::size_t {
            auto& body = *static_cast<std::vector<std::byte>*>(into);
            if (body.size() + size * count > kMostBytes) return 0;
            const auto* first = reinterpret_cast<const std::byte*>(data);
            body.insert(body.end(), first, first + size * count);
            return size * count;
        });
        const CURLcode failed = curl_easy_perform(handle);
        curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &reply.status);
        curl_off_t retry_after = 0;
        if (curl_easy_getinfo(handle, CURLINFO_RETRY_AFTER, &retry_after) == CURLE_OK) reply.retry_after_s = static_cast<long>(retry_after);
        const char* type = nullptr;
        if (curl_easy_getinfo(handle, CURLINFO_CONTENT_TYPE, &type) == CURLE_OK && type != nullptr) reply.content_type = type;
        curl_header* encoding = nullptr;
        if (curl_easy_header(handle, "Content-Encoding", 0, CURLH_HEADER, -1, &encoding) == CURLHE_OK) reply.content_encoding = encoding->value;
        give_back(handle);
        if (failed != CURLE_OK) throw Error("fetch " + url + ": " + curl_easy_strerror(failed));
        return reply;
    }

private:
    void add_header(const std::string& line) {
        curl_slist* longer = curl_slist_append(m_headers, line.c_str());
        if (longer == nullptr) throw std::bad_alloc();
        m_headers = longer;
    }
    CURL* take() {
        {
            const std::lock_guard lock(m_mutex);
            if (!m_free.empty()) {
                CURL* handle = m_free.back();
                m_free.pop_back();
                return handle;
            }
        }
        CURL* handle = curl_easy_init();
        if (handle == nullptr) throw Error("fetch from the voxel server: libcurl could not start");
        return handle;
    }
    void give_back(CURL* handle) {
        const std::lock_guard lock(m_mutex);
        m_free.push_back(handle);
    }
    curl_slist* m_headers = nullptr;  ///< sent with every request
    std::mutex m_mutex;
    std::vector<CURL*> m_free;
};

std::string problem_of(const Reply& reply) {
    const std::string text(reinterpret_cast<const char*>(reply.body.data()), std::min<std::size_t>(reply.body.size(), 2000));
    const auto json = nlohmann::json::parse(text, nullptr, false);
    if (json.is_object() && json.contains("detail") && json["detail"].is_string()) return json["detail"].get<std::string>();
    return "no reason given";
}

class RemoteWorld final : public voxel::World {
public:
    RemoteWorld(std::string url, util::StageTimes& times) : m_url(std::move(url)), m_times(times) {
        while (!m_url.empty() && m_url.back() == '/') m_url.pop_back();
        const Reply reply = fetch(m_url + "/v2/world");
        if (reply.status != 200) throw Error("open the world " + m_url + ": HTTP status " + std::to_string(reply.status) + ", " + problem_of(reply));
        m_info = voxel::world_from_json({reinterpret_cast<const char*>(reply.body.data()), reply.body.size()}, m_url);
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        const util::StageTimes::Scope timed(m_times, "box transmission");
        const std::string url = m_url + "/v2/boxes/" + voxel::to_string(key);
        const Reply reply = fetch(url);
        if (reply.status == 204) return nullptr;  // the server knows that it is air
        if (reply.status != 200) throw Error("fetch the box " + url + ": HTTP status " + std::to_string(reply.status) + ", " + problem_of(reply));
        if (reply.content_type != voxel::kBoxMediaType)
            throw Error("fetch the box " + url + ": the reply is of type '" + reply.content_type + "'; allowed: " + voxel::kBoxMediaType);
        const bool packed = reply.content_encoding == "zstd";
        if (!packed && !reply.content_encoding.empty() && reply.content_encoding != "identity")
            throw Error("fetch the box " + url + ": the reply is encoded as '" + reply.content_encoding + "'; allowed: zstd, identity");
        auto box = packed ? voxel::decompress_box(reply.body, url) : voxel::Box::from_blob(reply.body, url);
        if (box->key() != key) throw Error("fetch the box " + url + ": the server sent box " + voxel::to_string(box->key()));
        return box;
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        const std::string url = m_url + "/v2/columns/" + std::to_string(level) + "/" + std::to_string(bx) + "/" + std::to_string(bz);
        const Reply reply = fetch(url);
        if (reply.status != 200) throw Error("fetch the column " + url + ": HTTP status " + std::to_string(reply.status) + ", " + problem_of(reply));
        const auto json = nlohmann::json::parse(reinterpret_cast<const char*>(reply.body.data()), reinterpret_cast<const char*>(reply.body.data()) + reply.body.size(), nullptr, false);
        if (!json.is_object() || !json.value("by_begin", nlohmann::json()).is_number_integer() || !json.value("by_end", nlohmann::json()).is_number_integer())
            throw Error("fetch the column " + url + ": not the reply of a voxel server");
        return {json["by_begin"].get<std::int32_t>(), json["by_end"].get<std::int32_t>()};
    }

private:
    // A busy server (503) and a lost connection are worth another try; other errors are answers.
    Reply fetch(const std::string& url) {
        const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(kBusyPatience_s);
        for (std::size_t lost = 0;;) {
            std::chrono::milliseconds wait{};
            try {
                Reply reply = m_connections.get(url);
                if (reply.status != 503 || std::chrono::steady_clock::now() > give_up) return reply;
                wait = std::chrono::seconds(std::clamp(reply.retry_after_s, 1L, kLongestWait_s));
                spdlog::debug("{}: busy, trying again", url);
            } catch (const Error& e) {
                if (lost == kRetryAfter_ms.size()) throw;
                wait = std::chrono::milliseconds(kRetryAfter_ms[lost++]);
                spdlog::debug("{}; trying again", e.what());
            }
            std::this_thread::sleep_for(wait);
        }
    }

    std::string m_url;
    util::StageTimes& m_times;
    Connections m_connections;
    voxel::WorldInfo m_info;
};

}  // namespace

std::unique_ptr<voxel::World> open_remote_world(const std::string& url, util::StageTimes& times) { return std::make_unique<RemoteWorld>(url, times); }

}  // namespace terravox
