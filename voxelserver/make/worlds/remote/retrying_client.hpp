#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <type_traits>

#include "common/util/error.hpp"
#include "voxelserver/make/worlds/remote/http_client.hpp"
#include "voxelserver/make/worlds/remote/retry.hpp"

namespace terravox::remote {

/// A failure of a try that a retry may resolve.
struct FailedTry : util::Error {
    FailedTry(FailureKind failure, const std::string& why,
              std::optional<std::chrono::seconds> later = std::nullopt)
        : util::Error(why), kind(failure), retry_after(later) {}
    FailureKind kind;
    std::optional<std::chrono::seconds> retry_after;  ///< as requested by the server
};

/// The kind of failure that a status stands for; nullopt: the status is final, no retry.
[[nodiscard]] std::optional<FailureKind> to_failure_kind(long status) noexcept;

/// "HTTP status 500, reason", one line whatever the server sends.
[[nodiscard]] std::string find_problem(const HttpReply& reply);

/// A random number in [0, 1), for Retry. Affects only waits, never a picture. Thread-safe.
[[nodiscard]] double chance();

/// Sends requests to a server that may be late, silent, restarting or damaged: retries where that
/// may help (retry.hpp), and gives up at about the timeout after the request at the latest. When
/// many requests in a row had to be given up without one reply between them, the rest get a
/// twentieth of the timeout each, until a reply is received: a dead server must not hold up a
/// picture for days. Thread-safe.
class RetryingClient {
public:
    using Milliseconds = std::chrono::milliseconds;
    /// @param clock of the timeout and of waits, must outlive it
    explicit RetryingClient(Milliseconds timeout, HttpAccess access = {},
                            RetryClock& clock = RetryClock::steady())
        : m_timeout(std::max(timeout, Milliseconds{1})), m_client(std::move(access), clock) {}
    [[nodiscard]] HttpClient& http() noexcept { return m_client; }
    [[nodiscard]] Milliseconds timeout() const noexcept { return m_timeout; }
    [[nodiscard]] bool is_reachable() const noexcept;
    void on_reply() noexcept { m_given_up.store(0, std::memory_order_relaxed); }
    void stop() noexcept { m_client.stop(); }

    /// The result type of Read for a reply.
    template <class Read>
    using Made = std::invoke_result_t<Read, const std::string&, const HttpReply&>;
    /// GET.
    /// @param max_bytes of the reply
    /// @param part where it has a condition, 412 and 416 are replies that are passed to read, too
    /// @param read parses a reply with status 200, 204 or 206; an Error that it throws means a
    /// damaged reply, which is requested again
    /// @throws WholeFileError as HttpClient::get(), at once; voxel::ChangedError for a 412 that is
    /// not passed to read: the server has another edition than the request names; Error when it is
    /// given up, for a final refusal, and after stop()
    template <class Read>
    Made<Read> fetch(const std::string& url, std::size_t max_bytes, const FilePart& part,
                     Milliseconds timeout, const Read& read) {
        Request request = begin(timeout);
        for (;;) {
            std::optional<FailedTry> failed;
            try {
                const HttpReply reply = m_client.get(url, limits(request, max_bytes), part);
                check(url, reply, !part.condition.empty());
                Made<Read> out = [&] {
                    try {
                        return read(url, reply);
                    } catch (const util::Error& e) {
                        throw FailedTry(FailureKind::kDamaged, e.what());
                    }
                }();
                on_reply();
                return out;
            } catch (const LostError& e) {
                failed.emplace(FailureKind::kLost, e.what());
            } catch (const FailedTry& f) {
                failed = f;
            }
            wait_or_give_up(url, request, *failed);
        }
    }

private:
    struct Request {
        Milliseconds timeout;
        std::chrono::seconds stalled;
        Retry retry;
    };
    [[nodiscard]] Request begin(Milliseconds timeout) const;
    [[nodiscard]] HttpLimits limits(const Request& request, std::size_t max_bytes) const;
    /// @throws FailedTry for what a retry may resolve, Error for a final answer
    void check(const std::string& url, const HttpReply& reply, bool on_condition);
    void wait_or_give_up(const std::string& url, Request& request, const FailedTry& failed);
    [[noreturn]] void give_up(const FailedTry& failed, const Request& request);

    const Milliseconds m_timeout;
    HttpClient m_client;
    std::atomic<int> m_given_up{0};  ///< consecutive requests without any reply
};

}  // namespace terravox::remote
