#include "raytracer/world/remote_world.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <type_traits>

#include "common/util/error.hpp"
#include "common/voxel/box_codec.hpp"
#include "common/voxel/world_json.hpp"
#include "raytracer/world/batch_client.hpp"

namespace terravox {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMostBox_bytes = std::size_t{64} << 20;
constexpr std::size_t kMostText_bytes = std::size_t{4} << 20;
constexpr milliseconds kOpeningPatience{60'000};
constexpr milliseconds kMostStalled{120'000};  // a cold square may take a while before the first byte
constexpr int kGivenUpInRow = 16;  // then hope is lost, until something comes
constexpr int kHopelessShare = 20;
constexpr int kBatch = 32;  // boxes: most of what a request costs is shared, and a lost one loses little

std::string_view text_of(const HttpReply& reply) noexcept { return {reinterpret_cast<const char*>(reply.body.data()), reply.body.size()}; }

/// What Read makes of a reply.
template <class Read> using Made = std::invoke_result_t<Read, const std::string&, const HttpReply&>;

class RemoteWorld final : public voxel::World {
public:
    RemoteWorld(std::string url, util::StageTimes& times, milliseconds box_patience)
        : m_url(checked(std::move(url))), m_times(times), m_patience(std::max(box_patience, milliseconds{1})), m_batches(m_client, times, m_url, m_patience) {
        const auto text = ask(m_url + "/v2/world", kMostText_bytes, std::min(m_patience, kOpeningPatience),
                              [](const std::string&, const HttpReply& reply) { return std::string(text_of(reply)); });
        m_info = voxel::world_from_json(text, m_url);  // another version is no damage that a second try would mend
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        const util::StageTimes::Scope timed(m_times, "box transmission");
        return ask(m_url + "/v2/boxes/" + voxel::to_string(key), kMostBox_bytes, m_patience,
                   [&](const std::string& url, const HttpReply& reply) { return read_box(key, url, reply); });
    }

    void boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) override {
        std::vector<voxel::BoxKey> missing(keys.begin(), keys.end());
        if (hopeful())
            m_batches.ask(missing, [&](const voxel::BoxKey& key, voxel::BoxOutcome outcome) {
                m_given_up.store(0, std::memory_order_relaxed);
                take(key, std::move(outcome));
            });
        World::boxes(missing, take);
    }
    [[nodiscard]] int preferred_batch() const noexcept override { return kBatch; }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        const std::string place = std::to_string(level) + "/" + std::to_string(bx) + "/" + std::to_string(bz);
        return ask(m_url + "/v2/columns/" + place, kMostText_bytes, m_patience, [](const std::string& url, const HttpReply& reply) {
            const auto json = nlohmann::json::parse(text_of(reply), nullptr, false);
            voxel::ColumnExtent out;
            if (!read_whole(json, "by_begin", out.by_begin) || !read_whole(json, "by_end", out.by_end))
                throw Error("fetch " + url + ": not the reply of a voxel server");
            return out;
        });
    }

    void stop() noexcept override { m_client.stop(); }

private:
    static std::string checked(std::string url) {
        HttpClient::check_address(url);
        while (!url.empty() && url.back() == '/') url.pop_back();
        return url;
    }

    static std::shared_ptr<const voxel::Box> read_box(const voxel::BoxKey& key, const std::string& url, const HttpReply& reply) {
        if (reply.status == 204) return nullptr;  // the server knows that it is air
        if (reply.content_type != voxel::kBoxMediaType)
            throw Error("fetch " + url + ": the reply is of type '" + reply.content_type + "'; allowed: " + voxel::kBoxMediaType);
        const bool packed = reply.content_encoding == "zstd";
        if (!packed && !reply.content_encoding.empty() && reply.content_encoding != "identity")
            throw Error("fetch " + url + ": the reply is encoded as '" + reply.content_encoding + "'; allowed: zstd, identity");
        auto box = packed ? voxel::decompress_box(reply.body, url) : voxel::Box::from_blob(reply.body, url);
        if (box->key() != key) throw Error("fetch " + url + ": the server sent box " + voxel::to_string(box->key()));
        return box;
    }

    static bool read_whole(const nlohmann::json& json, const char* name, std::int32_t& into) {
        if (!json.is_object() || !json.contains(name) || !json[name].is_number_integer()) return false;
        const auto value = json[name].get<std::int64_t>();
        into = static_cast<std::int32_t>(value);
        return into == value;
    }

    /// @param read makes something of a reply with status 200 or 204; what it throws as Error is a damaged reply
    template <class Read> Made<Read> ask(const std::string& url, std::size_t most_bytes, milliseconds patience, const Read& read) {
        const bool hope = hopeful();
        if (!hope) patience = std::max(patience / kHopelessShare, std::min(patience, milliseconds{1000}));
        const auto stalled = std::chrono::ceil<std::chrono::seconds>(std::min(patience / 2, kMostStalled));
        Retry retry(Retry::Clock::now(), patience, hope);
        for (;;) {
            std::optional<FailedTry> failed;
            try {
                const HttpReply reply = m_client.get(url, {retry.time_left(Retry::Clock::now()), std::max(stalled, std::chrono::seconds{1}), most_bytes});
                Made<Read> out = answer(url, reply, read);
                m_given_up.store(0, std::memory_order_relaxed);
                return out;
            } catch (const LostError& e) {
                failed.emplace(Trouble::kLost, e.what());
            } catch (const FailedTry& f) {
                failed = f;
            }
            const auto wait = retry.wait_after(failed->trouble, Retry::Clock::now(), failed->retry_after, chance());
            if (!wait) give_up(*failed, retry.tries(), patience);
            spdlog::debug("{}; trying again in {} ms", failed->what(), wait->count());
            m_client.wait(url, *wait);
        }
    }

    /// @throws FailedTry for what another try may mend, Error for what is an answer
    template <class Read> Made<Read> answer(const std::string& url, const HttpReply& reply, const Read& read) {
        if (reply.status == 200 || reply.status == 204) {
            try {
                return read(url, reply);
            } catch (const Error& e) {
                throw FailedTry(Trouble::kDamaged, e.what());
            }
        }
        const std::string what = "fetch " + url + ": " + problem_of(reply);
        if (const auto trouble = trouble_of(reply.status)) throw FailedTry(*trouble, what, reply.retry_after);
        m_given_up.store(0, std::memory_order_relaxed);
        throw Error(what);
    }

    [[noreturn]] void give_up(const FailedTry& failed, int tries, milliseconds patience) {
        // A 500 is the word of a server that lives.
        if (failed.trouble == Trouble::kFailed) m_given_up.store(0, std::memory_order_relaxed);
        else m_given_up.fetch_add(1, std::memory_order_relaxed);
        throw Error(std::string(failed.what()) + "; given up after " + std::to_string(tries) + (tries == 1 ? " try" : " tries") + ", patience " +
                    std::to_string(std::chrono::ceil<std::chrono::seconds>(patience).count()) + " s");
    }

    [[nodiscard]] bool hopeful() const noexcept { return m_given_up.load(std::memory_order_relaxed) < kGivenUpInRow; }

    const std::string m_url;
    util::StageTimes& m_times;
    const milliseconds m_patience;
    HttpClient m_client;
    BatchClient m_batches;
    std::atomic<int> m_given_up{0};  ///< boxes in a row that nothing came for
    voxel::WorldInfo m_info;
};

}  // namespace

std::unique_ptr<voxel::World> open_remote_world(const std::string& url, util::StageTimes& times, milliseconds box_patience) {
    return std::make_unique<RemoteWorld>(url, times, box_patience);
}

}  // namespace terravox
