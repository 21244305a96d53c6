#include "voxelserver/make/worlds/remote/batch_client.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/box.hpp"

namespace terravox::remote {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw util::Error("read a batch of boxes: " + what);
}

}  // namespace

std::string batch_request(std::span<const voxel::BoxKey> keys) {
    std::string out = "{\"boxes\":[";
    for (const voxel::BoxKey& key : keys) {
        if (out.back() == ']')
            out += ',';
        out += '[' + std::to_string(key.level) + ',' + std::to_string(key.bx) + ',' +
               std::to_string(key.by) + ',' + std::to_string(key.bz) + ']';
    }
    return out + "]}";
}

std::uint32_t BatchStream::word(std::size_t at, std::size_t index) const noexcept {
    std::uint32_t value = 0;
    for (std::size_t byte = 0; byte < 4; ++byte)
        value |= std::to_integer<std::uint32_t>(m_bytes[at + index * 4 + byte]) << (8 * byte);
    return value;
}

void BatchStream::feed(std::span<const std::byte> part,
                       const std::function<void(const BatchRecord&)>& take) {
    m_bytes.insert(m_bytes.end(), part.begin(), part.end());
    std::size_t at = 0;
    while (m_bytes.size() - at >= kHead_bytes) {
        if (m_whole)
            break;
        const auto number = [&](std::size_t index) {
            return static_cast<std::int32_t>(word(at, index));
        };
        const std::size_t length = word(at, 5);
        // Checked before waiting for the data: the number is untrusted.
        if (length > m_max_payload_bytes)
            refuse("a record of " + std::to_string(length) + " bytes; allowed: up to " +
                   std::to_string(m_max_payload_bytes));
        if (m_bytes.size() - at - kHead_bytes < length)
            break;
        const BatchRecord record{{number(0), number(1), number(2), number(3)},
                                 word(at, 4),
                                 std::span(m_bytes).subspan(at + kHead_bytes, length)};
        at += kHead_bytes + length;
        if (record.key.level == -1) {
            last_record(record);
            continue;
        }
        if (++m_taken > m_requested)
            refuse("more than the " + std::to_string(m_requested) + " boxes that were requested");
        take(record);
    }
    m_bytes.erase(m_bytes.begin(), m_bytes.begin() + static_cast<std::ptrdiff_t>(at));
    if (m_whole && !m_bytes.empty())
        refuse("bytes after the last record");
}

void BatchStream::last_record(const BatchRecord& record) {
    if (record.status != 0 || !record.payload.empty() || record.key.bx < 0 ||
        static_cast<std::size_t>(record.key.bx) != m_requested || m_taken != m_requested)
        refuse("a last record after " + std::to_string(m_taken) + " boxes that states " +
               std::to_string(record.key.bx) + "; requested: " + std::to_string(m_requested));
    m_whole = true;
}

namespace {

using std::chrono::seconds;

// Consecutive tries without any result: after that, one box must not hold up the others any longer.
constexpr int kTriesInVain = 2;
constexpr seconds kShortestPause{5};
constexpr seconds kLongestPause{60};
constexpr seconds kMaxBatchStalled{120};

/// @return nullopt for a box that is to be requested by itself
std::optional<voxel::BoxOutcome> read(const BatchRecord& record) {
    if (record.status == 204 && record.payload.empty())
        return voxel::BoxOutcome{};
    if (record.status != 200)
        return std::nullopt;
    try {
        auto box = voxel::decompress_box(record.payload,
                                         "box " + voxel::to_string(record.key) + " of a batch");
        if (box->key() != record.key)
            return std::nullopt;
        return voxel::BoxOutcome{std::move(box), nullptr};
    } catch (const util::Error&) {
        return std::nullopt;
    }
}

}  // namespace

void BatchClient::fetch(std::vector<voxel::BoxKey>& missing, const voxel::TakeBox& take) {
    Retry retry(m_client.now(), m_timeout);
    for (int tries = 0; tries < kTriesInVain && missing.size() > 1 && welcome();) {
        const std::size_t before = missing.size();
        std::optional<FailedTry> failed;
        try {
            fetch_once(missing, take);
            return;
        } catch (const LostError& e) {
            failed.emplace(FailureKind::kLost, e.what());
        } catch (const FailedTry& f) {
            failed = f;
        } catch (const util::Error&) {
            return;  // stopped, or a certificate: each box will report it
        }
        tries = missing.size() < before ? 1 : tries + 1;
        util::log_debug("{}; {} of {} boxes missing", failed->what(), missing.size(), before);
        if (failed->kind == FailureKind::kBusy) {
            const auto pause = std::clamp(failed->retry_after.value_or(kShortestPause),
                                          kShortestPause, kLongestPause);
            m_from.store((m_client.now() + pause).time_since_epoch().count(),
                         std::memory_order_relaxed);
            return;
        }
        const auto wait = retry.wait_after(failed->kind, m_client.now(), std::nullopt, chance());
        if (!wait)
            return;
        try {
            m_client.wait(m_url, *wait);
        } catch (const util::Error&) {
            return;  // stopped
        }
    }
}

// Boxes that failed individually stay in `missing`.
// @throws LostError, FailedTry: the request as a whole; Error as HttpClient
void BatchClient::fetch_once(std::vector<voxel::BoxKey>& missing, const voxel::TakeBox& take) {
    const util::StageTimes::Scope timed(m_times, "box transmission");
    const auto stalled = std::chrono::ceil<seconds>(
        std::min<std::chrono::milliseconds>(m_timeout / 4, kMaxBatchStalled));
    const HttpLimits limits{m_timeout, std::max(stalled, seconds{1}),
                            missing.size() * kMaxBox_bytes};
    BatchStream stream(missing.size(), kMaxBox_bytes);
    std::vector<voxel::BoxKey> open(missing);
    const auto one = [&](const BatchRecord& record) {
        if (std::erase(open, record.key) == 0)
            throw util::Error("read a batch of boxes: box {} was not requested, or was sent twice",
                              voxel::to_string(record.key));
        if (auto outcome = read(record)) {
            std::erase(missing, record.key);
            take(record.key, std::move(*outcome));
        }
    };
    const auto find_part = [&](std::span<const std::byte> part) {
        try {
            stream.feed(part, one);
        } catch (const util::Error& e) {
            throw FailedTry(FailureKind::kDamaged, "fetch " + m_url + ": " + e.what());
        }
    };
    check(m_client.post(m_url, batch_request(open), kBatchMediaType, limits, find_part), stream);
}

void BatchClient::check(const HttpReply& reply, const BatchStream& stream) {
    if (reply.status == 200) {
        if (!stream.whole())
            throw FailedTry(FailureKind::kDamaged,
                            "fetch " + m_url + ": no whole batch, of type '" + reply.content_type +
                                "'; allowed: " + kBatchMediaType);
        return;
    }
    const std::string what = "fetch " + m_url + ": " + find_problem(reply);
    if (to_failure_kind(reply.status))
        throw FailedTry(FailureKind::kBusy, what, reply.retry_after);
    // It does not support batches, or a proxy before it blocks them: that will not change.
    util::log_debug("{}; box by box from now on", what);
    m_from.store(Retry::Clock::time_point::max().time_since_epoch().count(),
                 std::memory_order_relaxed);
}

}  // namespace terravox::remote
