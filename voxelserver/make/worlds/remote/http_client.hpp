#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/handle_pool.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"
#include "voxelserver/make/worlds/remote/retry.hpp"

using CURL = void;
struct curl_slist;

namespace terravox::remote {

/// A complete reply.
struct HttpReply {
    long status = 0;
    std::optional<std::chrono::seconds> retry_after;  ///< as sent by the server
    std::string content_type;
    std::string content_encoding;
    std::string etag, last_modified, content_range;  ///< as sent by the server: any text
    std::string edition;                             ///< its Terravox-Edition: any text
    std::vector<std::byte> body;
    bool showed_token = false;  ///< whether the request carried a token
    /// The absolute address that a redirect leads to, which may hold a secret; empty: it is none.
    std::string location;
    std::string redirected_to;  ///< the address that answered, for messages; empty: the given one
    AddressRange machine = AddressRange::kNoMachine;  ///< that answered
};

/// No complete reply was received; a retry may succeed.
class LostError : public util::Error {
public:
    using util::Error::Error;
};

/// The whole file was received instead of a part, or more of it than one request may take.
class WholeFileError : public util::Error {
public:
    WholeFileError(const std::string& message, HttpReply with)
        : util::Error(message), m_head(std::move(with)) {}
    [[nodiscard]] const HttpReply& head() const noexcept { return m_head; }  ///< without a body

private:
    HttpReply m_head;
};

/// The requested part of a file.
struct FilePart {
    std::string range;      ///< bytes "FIRST-LAST"; empty: all
    std::string condition;  ///< a line of the head, as of FileState::condition(); empty: none
};

/// Limits of one request.
struct HttpLimits {
    /// From the first byte sent to the last received, connecting included.
    std::chrono::milliseconds time{60'000};
    std::chrono::seconds stalled{120};          ///< with hardly any data arriving; at least 1
    std::size_t bytes = std::size_t{64} << 20;  ///< of the body
};

/// Receives a part of a body as it arrives. An exception that it throws ends the transfer, and is
/// rethrown by the call that requested it.
using TakePart = std::function<void(std::span<const std::byte>)>;

struct CloseCurl {
    void operator()(CURL* handle) const noexcept;
};
using CurlHandle = std::unique_ptr<CURL, CloseCurl>;

/// Requests over connections that are kept alive: a request takes a free one and gives it back.
/// Thread-safe; one connection for each concurrent request.
///
/// A GET follows up to kMaxRedirects redirects, each time anew, since where they lead may expire.
/// Each is judged as an address of its own: by the access, which also binds the token, and by the
/// address range of the server that sent it (HttpAccess::ranges). None leads from https to http.
class HttpClient {
public:
    /// @param access the origins that it may contact, and the token that it sends there; default:
    /// all, and none
    /// @param clock of now() and wait(), must outlive it
    explicit HttpClient(HttpAccess access = {}, RetryClock& clock = RetryClock::steady());
    ~HttpClient();
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;

    static constexpr int kMaxRedirects = 5;

    /// @param part a server that does not support ranges sends the whole file, with status 200
    /// @throws LostError when no complete reply was received within the limits; WholeFileError when
    /// the whole file was received instead of a part; Error after stop(), and for failures that no
    /// retry resolves: a certificate, a forbidden address, a redirect that is not followed;
    /// UsageError as HttpOrigin::of()
    [[nodiscard]] HttpReply get(const std::string& url, const HttpLimits& limits,
                                const FilePart& part = {});
    /// POST of JSON. The body of a reply with status 200 and this type is passed to `take` part by
    /// part, and the returned reply has none.
    /// @throws as get(), and what `take` throws
    [[nodiscard]] HttpReply post(const std::string& url, const std::string& json,
                                 const std::string& type, const HttpLimits& limits,
                                 const TakePart& take);
    /// Adds a line to the header of all later requests. Not thread-safe: must be called before the
    /// client is shared.
    void add_header(const std::string& line);
    /// The current time of the clock that wait() uses. Limits of requests are real time.
    [[nodiscard]] RetryClock::Steady::time_point now() const noexcept { return m_clock.now(); }
    /// Waits, but no longer than until stop().
    /// @throws Error after stop()
    void wait(const std::string& url, std::chrono::milliseconds time);
    /// Requests and waits in progress end within about a second; later ones at once.
    void stop() noexcept;

private:
    struct Request;
    [[nodiscard]] HttpReply send(const Request& request, const HttpLimits& limits);
    void follow(Request& request, const HttpReply& redirect) const;
    [[nodiscard]] static util::Error stopped(const std::string& url) {
        return util::Error("fetch {}: stopped", url);
    }

    const HttpAccess m_access;
    RetryClock& m_clock;
    /// Header lines of every GET, and of every POST.
    curl_slist *m_headers = nullptr, *m_post_headers = nullptr;
    util::HandlePool<CurlHandle> m_handles;
    std::atomic<bool> m_stopped{false};
    /// Mutex of m_wake, so that no stop() falls between the check of m_stopped and the wait.
    std::mutex m_wait_mutex;
    std::condition_variable m_wake;
};

}  // namespace terravox::remote
