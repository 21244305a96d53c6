#include "raytracer/world/http_client.hpp"

#include <curl/curl.h>

#include <cstdlib>
#include <new>
#include <utility>

#include "common/util/version.hpp"

namespace terravox {
namespace {

constexpr long kConnectTimeout_ms = 10'000;
constexpr long kStalledBelow_bytes_per_s = 100;  // a server that drips is as good as none
constexpr std::size_t kMostHeader_bytes = 256 << 10;

/// What the callbacks fill and heed.
struct Transfer {
    HttpReply reply;
    std::size_t most_bytes = 0, header_bytes = 0;
    bool too_long = false;
    const std::atomic<bool>* stopped = nullptr;
};

// Callbacks of C: nothing may be thrown. A short count ends the transfer.
std::size_t take_body(char* data, std::size_t size, std::size_t count, void* into) noexcept {
    auto& transfer = *static_cast<Transfer*>(into);
    auto& body = transfer.reply.body;
    const std::size_t bytes = size * count;
    transfer.too_long = bytes > transfer.most_bytes - body.size();
    if (transfer.too_long) return 0;
    try {
        const auto* first = reinterpret_cast<const std::byte*>(data);
        body.insert(body.end(), first, first + bytes);
    } catch (const std::bad_alloc&) {
        return 0;
    }
    return bytes;
}
std::size_t count_header(char*, std::size_t size, std::size_t count, void* into) noexcept {
    auto& transfer = *static_cast<Transfer*>(into);
    transfer.header_bytes += size * count;
    transfer.too_long = transfer.header_bytes > kMostHeader_bytes;
    return transfer.too_long ? 0 : size * count;
}
int look_for_stop(void* from, curl_off_t, curl_off_t, curl_off_t, curl_off_t) noexcept { return static_cast<Transfer*>(from)->stopped->load() ? 1 : 0; }

void prepare(CURL* handle, const std::string& url, const HttpLimits& limits, curl_slist* headers, Transfer& transfer) {
    static const std::string kAgent = std::string("terravox/") + kVersion;
    curl_easy_reset(handle);
    curl_easy_setopt(handle, CURLOPT_URL, url.c_str());
    curl_easy_setopt(handle, CURLOPT_USERAGENT, kAgent.c_str());
    curl_easy_setopt(handle, CURLOPT_HTTPHEADER, headers);
    curl_easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
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
}

void read_head(CURL* handle, HttpReply& reply) {
    curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &reply.status);
    curl_header* header = nullptr;
    curl_off_t retry_after = 0;
    if (curl_easy_header(handle, "Retry-After", 0, CURLH_HEADER, -1, &header) == CURLHE_OK &&
        curl_easy_getinfo(handle, CURLINFO_RETRY_AFTER, &retry_after) == CURLE_OK)
        reply.retry_after = std::chrono::seconds(retry_after);
    if (curl_easy_header(handle, "Content-Encoding", 0, CURLH_HEADER, -1, &header) == CURLHE_OK) reply.content_encoding = header->value;
    const char* type = nullptr;
    if (curl_easy_getinfo(handle, CURLINFO_CONTENT_TYPE, &type) == CURLE_OK && type != nullptr) reply.content_type = type;
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

}  // namespace

/// A handle on loan.
class HttpClient::Handle {
public:
    explicit Handle(HttpClient& client) : m_client(client), m_curl(client.take()) {}
    ~Handle() { m_client.give_back(m_curl); }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    [[nodiscard]] CURL* get() const noexcept { return m_curl; }

private:
    HttpClient& m_client;
    CURL* m_curl;
};

HttpClient::HttpClient() {
    static std::once_flag once;
    std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
    // Unpacked here: libcurl may have been built without zstd.
    add_header("Accept-Encoding: zstd");
    if (const char* token = std::getenv("TERRAVOX_TOKEN"); token != nullptr && *token != '\0') add_header(std::string("Authorization: Bearer ") + token);
}

HttpClient::~HttpClient() {
    curl_slist_free_all(m_headers);
    for (CURL* handle : m_free) curl_easy_cleanup(handle);
}

void HttpClient::check_address(const std::string& url) {
    CURLU* parsed = curl_url();
    if (parsed == nullptr) throw std::bad_alloc();
    const CURLUcode failed = curl_url_set(parsed, CURLUPART_URL, url.c_str(), CURLU_NON_SUPPORT_SCHEME);
    curl_url_cleanup(parsed);
    if (failed != CURLUE_OK || (!url.starts_with("http://") && !url.starts_with("https://")))
        throw UsageError("open the world '" + url + "': not an address; allowed: http(s)://host[:port]");
}

HttpReply HttpClient::get(const std::string& url, const HttpLimits& limits) {
    if (m_stopped) throw stopped(url);
    Transfer transfer;
    transfer.most_bytes = limits.bytes, transfer.stopped = &m_stopped;
    const Handle handle(*this);
    prepare(handle.get(), url, limits, m_headers, transfer);
    const CURLcode failed = curl_easy_perform(handle.get());
    if (m_stopped) throw stopped(url);
    if (transfer.too_long) throw LostError("fetch " + url + ": more than " + std::to_string(limits.bytes) + " bytes, or a head of more than 256 KiB");
    if (failed != CURLE_OK) {
        const std::string what = "fetch " + url + ": " + curl_easy_strerror(failed);
        if (worth_another_try(failed)) throw LostError(what);
        throw Error(what);
    }
    read_head(handle.get(), transfer.reply);
    return std::move(transfer.reply);
}

void HttpClient::wait(const std::string& url, std::chrono::milliseconds time) {
    std::unique_lock lock(m_wait_mutex);
    if (m_wake.wait_for(lock, time, [this] { return m_stopped.load(); })) throw stopped(url);
}

void HttpClient::stop() noexcept {
    {
        const std::lock_guard lock(m_wait_mutex);
        m_stopped = true;
    }
    m_wake.notify_all();
}

void HttpClient::add_header(const std::string& line) {
    curl_slist* longer = curl_slist_append(m_headers, line.c_str());
    if (longer == nullptr) throw std::bad_alloc();
    m_headers = longer;
}

CURL* HttpClient::take() {
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

void HttpClient::give_back(CURL* handle) noexcept {
    try {
        const std::lock_guard lock(m_mutex);
        m_free.push_back(handle);
    } catch (const std::bad_alloc&) {
        curl_easy_cleanup(handle);
    }
}

}  // namespace terravox
