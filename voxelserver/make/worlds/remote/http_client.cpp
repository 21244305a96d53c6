#include "voxelserver/make/worlds/remote/http_client.hpp"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <utility>

#include "common/util/text.hpp"
#include "common/util/version.hpp"

namespace terravox::remote {
namespace {

constexpr long kConnectTimeout_ms = 10'000;
constexpr long kStalledBelow_bytes_per_s = 100;  // a slower server counts as stalled
constexpr std::size_t kMaxHeader_bytes = 256 << 10;
// Limit of the body where it is not passed on part by part.
constexpr std::size_t kMaxProblem_bytes = std::size_t{1} << 20;

/// The state shared with the callbacks.
struct Transfer {
    CURL* handle = nullptr;
    HttpReply reply;
    std::size_t max_bytes = 0;
    std::size_t header_bytes = 0;
    std::size_t body_bytes = 0;
    bool too_long = false;
    const std::atomic<bool>* stopped = nullptr;
    const TakePart* take = nullptr;  ///< of the body, where status and type are the expected ones
    const std::string* type = nullptr;
    std::exception_ptr failure;  ///< thrown by take
    AddressRanges ranges;        ///< that may be connected to
    bool passes_proxy = false;
    sockaddr_storage refused{};  ///< an address outside of them that the host resolved to
};

AddressRange find_machine(CURL* handle) {
    const char* number = nullptr;
    if (curl_easy_getinfo(handle, CURLINFO_PRIMARY_IP, &number) != CURLE_OK || number == nullptr)
        return AddressRange::kNoMachine;
    sockaddr_in four{};
    four.sin_family = AF_INET;
    if (inet_pton(AF_INET, number, &four.sin_addr) == 1)
        return make_range(reinterpret_cast<const sockaddr&>(four));
    sockaddr_in6 six{};
    six.sin6_family = AF_INET6;
    (void)inet_pton(AF_INET6, number, &six.sin6_addr);
    return make_range(reinterpret_cast<const sockaddr&>(six));
}

bool is_redirect(long status) noexcept {
    return status == 301 || status == 302 || status == 303 || status == 307 || status == 308;
}

void read_head(CURL* handle, HttpReply& reply) {
    curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &reply.status);
    curl_header* header = nullptr;
    curl_off_t retry_after = 0;
    if (curl_easy_header(handle, "Retry-After", 0, CURLH_HEADER, -1, &header) == CURLHE_OK &&
        curl_easy_getinfo(handle, CURLINFO_RETRY_AFTER, &retry_after) == CURLE_OK)
        reply.retry_after = std::chrono::seconds(retry_after);
    const auto read = [&](const char* name, std::string& into) {
        if (curl_easy_header(handle, name, 0, CURLH_HEADER, -1, &header) == CURLHE_OK)
            into = header->value;
    };
    read("Content-Encoding", reply.content_encoding);
    read("ETag", reply.etag);
    read("Last-Modified", reply.last_modified);
    read("Content-Range", reply.content_range);
    read("Terravox-Edition", reply.edition);
    const char* type = nullptr;
    if (curl_easy_getinfo(handle, CURLINFO_CONTENT_TYPE, &type) == CURLE_OK && type != nullptr)
        reply.content_type = type;
    const char* location = nullptr;
    if (curl_easy_getinfo(handle, CURLINFO_REDIRECT_URL, &location) == CURLE_OK &&
        location != nullptr)
        reply.location = location;
    reply.machine = find_machine(handle);
}

void take_part(Transfer& transfer, std::span<const std::byte> part) {
    auto& reply = transfer.reply;
    if (transfer.take != nullptr && reply.status == 0)
        read_head(transfer.handle, reply);  // once: with the first part
    if (transfer.take != nullptr && reply.status == 200 && reply.content_type == *transfer.type)
        return (*transfer.take)(part);
    if (transfer.take != nullptr && part.size() > kMaxProblem_bytes - reply.body.size())
        throw LostError("read a reply: more than " + std::to_string(kMaxProblem_bytes) +
                        " bytes of a reply that was not requested");
    reply.body.insert(reply.body.end(), part.begin(), part.end());
}

// Callbacks of C: they must not throw. A short count ends the transfer.
std::size_t take_body(char* data, std::size_t size, std::size_t count, void* into) noexcept {
    auto& transfer = *static_cast<Transfer*>(into);
    const std::size_t bytes = size * count;
    transfer.too_long = bytes > transfer.max_bytes - transfer.body_bytes;
    // The text of a redirect or a refusal may be longer than the requested data: the rest of it is
    // ignored.
    long status = 0;
    constexpr long kRefusals = 300;
    if (transfer.too_long &&
        curl_easy_getinfo(transfer.handle, CURLINFO_RESPONSE_CODE, &status) == CURLE_OK &&
        status >= kRefusals) {
        transfer.too_long = false;
        return bytes;
    }
    if (transfer.too_long)
        return 0;
    transfer.body_bytes += bytes;
    try {
        take_part(transfer, {reinterpret_cast<const std::byte*>(data), bytes});
    } catch (const std::bad_alloc&) {
        return 0;  // counts as lost: a retry may find memory
    } catch (...) {
        transfer.failure = std::current_exception();
        return 0;
    }
    return bytes;
}
std::size_t count_header(char*, std::size_t size, std::size_t count, void* into) noexcept {
    auto& transfer = *static_cast<Transfer*>(into);
    transfer.header_bytes += size * count;
    transfer.too_long = transfer.header_bytes > kMaxHeader_bytes;
    return transfer.too_long ? 0 : size * count;
}
// Checked here, and not before: a name may resolve differently each time.
curl_socket_t open_socket(void* from, curlsocktype, curl_sockaddr* address) noexcept {
    auto& transfer = *static_cast<Transfer*>(from);
    if (!transfer.ranges.holds(make_range(address->addr))) {
        std::memcpy(&transfer.refused, &address->addr,
                    std::min<std::size_t>(address->addrlen, sizeof transfer.refused));
        return CURL_SOCKET_BAD;
    }
    return ::socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
}
int look_for_stop(void* from, curl_off_t, curl_off_t, curl_off_t, curl_off_t) noexcept {
    return static_cast<Transfer*>(from)->stopped->load() ? 1 : 0;
}

curl_slist* longer(curl_slist* list, const std::string& line) {
    curl_slist* out = curl_slist_append(list, line.c_str());
    if (out == nullptr)
        throw std::bad_alloc();
    return out;
}

/// One more line before those of a list, which stays owned by its owner.
class OneMoreLine {
public:
    OneMoreLine(curl_slist* rest, const std::string& line) : m_line(longer(nullptr, line)) {
        m_line->next = rest;
    }
    ~OneMoreLine() {
        m_line->next = nullptr;
        curl_slist_free_all(m_line);
    }
    OneMoreLine(const OneMoreLine&) = delete;
    OneMoreLine& operator=(const OneMoreLine&) = delete;
    [[nodiscard]] curl_slist* get() const noexcept { return m_line; }

private:
    curl_slist* m_line;
};

void prepare(const std::string& url, const HttpLimits& limits, curl_slist* headers,
             Transfer& transfer) {
    CURL* handle = transfer.handle;
    static const std::string kAgent = std::string("terravox/") + kVersion;
    curl_easy_reset(handle);
    curl_easy_setopt(handle, CURLOPT_URL, url.c_str());
    curl_easy_setopt(handle, CURLOPT_USERAGENT, kAgent.c_str());
    curl_easy_setopt(handle, CURLOPT_HTTPHEADER, headers);
    curl_easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
#if LIBCURL_VERSION_NUM >= 0x075700
    // stop() does not wait for the name service: its thread is left behind.
    curl_easy_setopt(handle, CURLOPT_QUICK_EXIT, 1L);
#endif
    curl_easy_setopt(handle, CURLOPT_CONNECTTIMEOUT_MS, kConnectTimeout_ms);
    curl_easy_setopt(handle, CURLOPT_TIMEOUT_MS, static_cast<long>(limits.time.count()));
    curl_easy_setopt(handle, CURLOPT_LOW_SPEED_LIMIT, kStalledBelow_bytes_per_s);
    curl_easy_setopt(handle, CURLOPT_LOW_SPEED_TIME, static_cast<long>(limits.stalled.count()));
    curl_easy_setopt(handle, CURLOPT_WRITEDATA, &transfer);
    curl_easy_setopt(handle, CURLOPT_WRITEFUNCTION, &take_body);
    curl_easy_setopt(handle, CURLOPT_HEADERDATA, &transfer);
    curl_easy_setopt(handle, CURLOPT_HEADERFUNCTION, &count_header);
    curl_easy_setopt(handle, CURLOPT_XFERINFODATA, &transfer);
    curl_easy_setopt(handle, CURLOPT_XFERINFOFUNCTION, &look_for_stop);
    curl_easy_setopt(handle, CURLOPT_NOPROGRESS, 0L);
    curl_easy_setopt(handle, CURLOPT_OPENSOCKETDATA, &transfer);
    curl_easy_setopt(handle, CURLOPT_OPENSOCKETFUNCTION, &open_socket);
    // With a proxy, only the proxy would be connected to, and it resolves names itself.
    if (!transfer.passes_proxy)
        curl_easy_setopt(handle, CURLOPT_PROXY, "");
}

bool worth_another_try(CURLcode failed) noexcept {
    switch (failed) {
        case CURLE_URL_MALFORMAT:
        case CURLE_UNSUPPORTED_PROTOCOL:
        case CURLE_PEER_FAILED_VERIFICATION:
        case CURLE_SSL_CACERT_BADFILE:
        case CURLE_SSL_CERTPROBLEM: return false;
        default: return true;
    }
}

void set_post_body(CURL* handle, const std::string& json) {
    curl_easy_setopt(handle, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(json.size()));
    curl_easy_setopt(handle, CURLOPT_POSTFIELDS, json.data());
}

void set_token(CURL* handle, const std::string& token) {
    curl_easy_setopt(handle, CURLOPT_HTTPAUTH, CURLAUTH_BEARER);
    curl_easy_setopt(handle, CURLOPT_XOAUTH2_BEARER, token.c_str());
}

/// @throws WholeFileError or LostError where the reply was longer than its limit
void check_length(const std::string& url, bool part_only, Transfer& transfer) {
    if (!transfer.too_long)
        return;
    if (part_only) {
        read_head(transfer.handle, transfer.reply);
        transfer.reply.body.clear();
        if (transfer.reply.status == 200)
            throw WholeFileError(
                "fetch " + url +
                    ": the server does not support range requests; allowed: one that "
                    "knows range requests, such as nginx",
                std::move(transfer.reply));
    }
    throw LostError("fetch " + url + ": more than " + std::to_string(transfer.max_bytes) +
                    " bytes, or a head of more than 256 KiB");
}

/// @throws LostError where a retry may succeed, else Error, unless `result` is CURLE_OK
void check_result(const std::string& url, const char* allowed, CURLcode result,
                  const Transfer& transfer) {
    if (result == CURLE_OK)
        return;
    if (result == CURLE_COULDNT_CONNECT && transfer.refused.ss_family != AF_UNSPEC)
        throw util::Error(
            "fetch {}: it leads to {}, which may not be contacted from here; allowed: {}", url,
            to_text(reinterpret_cast<const sockaddr&>(transfer.refused)), allowed);
    const std::string what = "fetch " + url + ": " + curl_easy_strerror(result);
    if (worth_another_try(result))
        throw LostError(what);
    throw util::Error(what);
}

CurlHandle open_handle() {
    CurlHandle handle(curl_easy_init());
    if (!handle)
        throw util::Error("fetch from the voxel server: libcurl could not start");
    return handle;
}

}  // namespace

struct HttpClient::Request {
    std::string url;  ///< of a redirect: it may hold a secret
    HttpOrigin origin;
    AddressRanges ranges;  ///< that may be connected to
    const char* allowed = "";
    std::string name;                   ///< the address for messages
    const std::string* json = nullptr;  ///< nullptr: GET
    const std::string* type = nullptr;
    const TakePart* take = nullptr;
    const FilePart* part = nullptr;

    Request(const std::string& given, const HttpAccess& access)
        : url(given),
          origin(HttpOrigin::of(url)),
          ranges(access.ranges(origin)),
          allowed(access.allowed()),
          name(given) {}
};

HttpClient::HttpClient(HttpAccess access, RetryClock& clock)
    : m_access(std::move(access)), m_clock(clock) {
    static std::once_flag once;
    std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
    // Decompressed here: libcurl may have been built without zstd.
    for (curl_slist** list : {&m_headers, &m_post_headers})
        *list = longer(*list, "Accept-Encoding: zstd");
    m_post_headers = longer(m_post_headers, "Content-Type: application/json");
}

void CloseCurl::operator()(CURL* handle) const noexcept {
    curl_easy_cleanup(handle);
}

HttpClient::~HttpClient() {
    curl_slist_free_all(m_headers);
    curl_slist_free_all(m_post_headers);
}

HttpReply HttpClient::get(const std::string& url, const HttpLimits& limits, const FilePart& part) {
    const auto end = std::chrono::steady_clock::now() + limits.time;
    HttpLimits left = limits;
    Request request(url, m_access);
    request.part = &part;
    std::string redirected_to;
    for (int redirects = 0;; ++redirects) {
        HttpReply reply = send(request, left);
        reply.redirected_to = redirected_to;
        if (!is_redirect(reply.status))
            return reply;
        redirected_to = util::printable(shown_url(reply.location));
        if (redirects == kMaxRedirects)
            throw util::Error("fetch {}: more than {} redirects, the last to {}; allowed: up to {}",
                              url, kMaxRedirects, redirected_to, kMaxRedirects);
        follow(request, reply);
        request.name = url + ", redirected to " + redirected_to;
        using std::chrono::milliseconds;
        left.time =
            std::max(std::chrono::ceil<milliseconds>(end - std::chrono::steady_clock::now()),
                     milliseconds{1});
    }
}

/// @throws Error as redirect_target()
void HttpClient::follow(Request& request, const HttpReply& redirect) const {
    request.origin = redirect_target(
        "fetch " + request.name + ": HTTP status " + std::to_string(redirect.status),
        request.origin, redirect.location);
    request.url = redirect.location;
    request.ranges = m_access.ranges(request.origin, redirect.machine);
    if (!m_access.limits)
        request.allowed =
            "a redirect to no more private a network, or the new address given itself";
}

HttpReply HttpClient::post(const std::string& url, const std::string& json, const std::string& type,
                           const HttpLimits& limits, const TakePart& take) {
    Request request(url, m_access);
    request.json = &json;
    request.type = &type;
    request.take = &take;
    return send(request, limits);
}

HttpReply HttpClient::send(const Request& request, const HttpLimits& limits) {
    if (m_stopped)
        throw stopped(request.name);
    Transfer transfer;
    transfer.ranges = request.ranges;
    transfer.passes_proxy = m_access.ranges(request.origin) == kAnyRange;
    if (transfer.ranges.empty())
        throw util::Error("fetch {}: {} may not be contacted from here; allowed: {}", request.name,
                          request.origin.text(), request.allowed);
    const auto handle = m_handles.borrow(open_handle);
    transfer.handle = handle.get();
    transfer.max_bytes = limits.bytes;
    transfer.stopped = &m_stopped;
    transfer.take = request.take;
    transfer.type = request.type;
    curl_slist* headers = request.json != nullptr ? m_post_headers : m_headers;
    const bool part_only = request.part != nullptr && !request.part->range.empty();
    std::optional<OneMoreLine> condition;
    if (request.part != nullptr && !request.part->condition.empty())
        headers = condition.emplace(headers, request.part->condition).get();
    prepare(request.url, limits, headers, transfer);
    if (request.json != nullptr)
        set_post_body(handle.get(), *request.json);
    if (part_only)
        curl_easy_setopt(handle.get(), CURLOPT_RANGE, request.part->range.c_str());
    transfer.reply.showed_token = m_access.token && m_access.token->origin() == request.origin;
    if (transfer.reply.showed_token)
        set_token(handle.get(), m_access.token->text());
    const CURLcode result = curl_easy_perform(handle.get());
    if (m_stopped)
        throw stopped(request.name);
    if (transfer.failure)
        std::rethrow_exception(transfer.failure);
    check_length(request.name, part_only, transfer);
    check_result(request.name, request.allowed, result, transfer);
    read_head(handle.get(), transfer.reply);
    return std::move(transfer.reply);
}

void HttpClient::add_header(const std::string& line) {
    m_headers = longer(m_headers, line);
    m_post_headers = longer(m_post_headers, line);
}

void HttpClient::wait(const std::string& url, std::chrono::milliseconds time) {
    const auto real_time = m_clock.begin_wait(time);
    std::unique_lock lock(m_wait_mutex);
    if (m_wake.wait_for(lock, real_time, [this] { return m_stopped.load(); }))
        throw stopped(url);
}

void HttpClient::stop() noexcept {
    {
        const std::lock_guard lock(m_wait_mutex);
        m_stopped = true;
    }
    m_wake.notify_all();
}

}  // namespace terravox::remote
