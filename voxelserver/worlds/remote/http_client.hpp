#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/util/error.hpp"
#include "voxelserver/worlds/remote/http_access.hpp"
#include "voxelserver/worlds/remote/retry_clock.hpp"

using CURL = void;
struct curl_slist;

namespace terravox::remote {

/// A reply that came whole.
struct HttpReply {
    long status = 0;
    std::optional<std::chrono::seconds> retry_after;  ///< as the server said it
    std::string content_type, content_encoding;
    std::string etag, last_modified, content_range;  ///< as the server said them: any text
    std::string edition;                             ///< its Terravox-Edition: any text
    std::vector<std::byte> body;
    bool showed_token = false;  ///< whether the request brought one
};

/// No whole reply came; another try may fare better.
class LostError : public util::Error {
public:
    using util::Error::Error;
};

/// Instead of a part of a file all of it came, or more of it than one request may take.
class WholeFileError : public util::Error {
public:
    WholeFileError(const std::string& message, HttpReply with)
        : util::Error(message), m_head(std::move(with)) {}
    [[nodiscard]] const HttpReply& head() const noexcept { return m_head; }  ///< without a body

private:
    HttpReply m_head;
};

/// What of a file is asked for.
struct FilePart {
    std::string range;      ///< bytes "FIRST-LAST"; empty: all
    std::string condition;  ///< a line of the head, as of FileState::condition(); empty: none
};

/// What one request may take.
struct HttpLimits {
    std::chrono::milliseconds time{
        60'000};  ///< from the first byte sent to the last received, connecting included
    std::chrono::seconds stalled{120};          ///< with hardly a byte coming; at least 1
    std::size_t bytes = std::size_t{64} << 20;  ///< of the body
};

/// Takes a part of a body as it comes. What it throws ends the transfer, and is thrown where that
/// was asked for.
using TakePart = std::function<void(std::span<const std::byte>)>;

/// Requests over connections that are kept alive: a request takes a free one and gives it back.
/// Thread-safe; one connection for each thread that asks at the same time. Redirects are not
/// followed.
class HttpClient {
public:
    /// @param access whom it may ask, and the token that it shows there; default: anybody, and none
    /// @param clock of now() and wait(), must outlive it
    explicit HttpClient(HttpAccess access = {}, RetryClock& clock = RetryClock::steady());
    ~HttpClient();
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;

    /// @param part a server that knows no ranges sends all, with status 200
    /// @throws LostError when no whole reply came within the limits; WholeFileError when that was
    /// since all of a file came instead of a part; Error after stop(), and for what no other try
    /// will mend: a certificate, an address that it may not ask; UsageError as HttpOrigin::of()
    [[nodiscard]] HttpReply get(const std::string& url, const HttpLimits& limits,
                                const FilePart& part = {});
    /// POST of JSON. Of a reply with status 200 and this type the body goes to `take` part by part,
    /// and the reply comes back without it.
    /// @throws as get(), and what `take` throws
    [[nodiscard]] HttpReply post(const std::string& url, const std::string& json,
                                 const std::string& type, const HttpLimits& limits,
                                 const TakePart& take);
    /// Adds a line to the head of all later requests. Not thread-safe: before the client is shared.
    void add_header(const std::string& line);
    /// When it is, by the clock that wait() waits by. Limits of requests are real time.
    [[nodiscard]] RetryClock::Steady::time_point now() const noexcept { return m_clock.now(); }
    /// Waits, but no longer than until stop(). @throws Error after stop()
    void wait(const std::string& url, std::chrono::milliseconds time);
    /// Requests and waits under way end within about a second; later ones at once.
    void stop() noexcept;

private:
    class Handle;
    struct Question;
    [[nodiscard]] HttpReply ask(const Question& question, const HttpLimits& limits);
    CURL* take();
    void give_back(CURL* handle) noexcept;
    [[nodiscard]] static util::Error stopped(const std::string& url) {
        return util::Error("fetch " + url + ": stopped");
    }

    const HttpAccess m_access;
    RetryClock& m_clock;
    curl_slist *m_headers = nullptr,
               *m_post_headers = nullptr;  ///< of every GET, and of every POST
    std::mutex m_mutex;                    ///< guards m_free
    std::vector<CURL*> m_free;
    std::atomic<bool> m_stopped{false};
    std::mutex m_wait_mutex;  ///< of m_wake, so that no stop() falls between a look at m_stopped
                              ///< and the wait
    std::condition_variable m_wake;
};

}  // namespace terravox::remote
