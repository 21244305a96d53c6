#include "voxelserver/make/worlds/remote/http_origin.hpp"

#include <curl/curl.h>
#include <netdb.h>

#include <algorithm>
#include <memory>
#include <new>
#include <vector>

#include "common/thread/call_until_stopped.hpp"
#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"
#include "voxelserver/make/worlds/kind/http_address.hpp"

namespace terravox::remote {
namespace {

constexpr std::size_t kMax_bytes = 2048;

struct FreeUrl {
    void operator()(CURLU* url) const noexcept { curl_url_cleanup(url); }
};
using Url = std::unique_ptr<CURLU, FreeUrl>;

/// A component of an address; empty: it has none.
std::string part_of(const Url& url, CURLUPart part, unsigned flags = 0) {
    char* text = nullptr;
    if (curl_url_get(url.get(), part, &text, flags) != CURLUE_OK || text == nullptr)
        return {};
    const std::unique_ptr<char, void (*)(void*)> held(text, &curl_free);
    return text;
}

/// "somebody:password@host:80" of "http://somebody:password@host:80/path".
std::string authority_of(const std::string& url) {
    const auto begin = url.find("://") + 3;
    return url.substr(begin, url.find_first_of("/?#", begin) - begin);
}

/// The fault of an address; empty: it is valid, and the origin and the path are set.
std::string fault_of(const std::string& text, HttpOrigin& origin, std::string& path) {
    if (!worlds::is_http_address(text))
        return "not an address";
    if (text.size() > kMax_bytes)
        return "an address of " + std::to_string(text.size()) + " bytes";
    // As text: libcurl does not distinguish an empty query from none.
    if (authority_of(text).find('@') != std::string::npos)
        return "an address with a user in it";
    if (text.find('?') != std::string::npos)
        return "an address with a query in it";
    if (text.find('#') != std::string::npos)
        return "an address with a fragment in it";
    const Url url(curl_url());
    if (!url)
        throw std::bad_alloc();
    if (curl_url_set(url.get(), CURLUPART_URL, text.c_str(), CURLU_NON_SUPPORT_SCHEME) != CURLUE_OK)
        return "not an address";
    origin.tls = part_of(url, CURLUPART_SCHEME) == "https";
    origin.host = util::lower_case(part_of(url, CURLUPART_HOST));
    // Of a link-local address: its network is part of the destination.
    if (const std::string zone = part_of(url, CURLUPART_ZONEID); !zone.empty())
        origin.host.insert(origin.host.size() - 1, "%25" + zone);
    const std::string port = part_of(url, CURLUPART_PORT, CURLU_DEFAULT_PORT);
    if (origin.host.empty() || port.empty())
        return "not an address";
    origin.port =
        static_cast<std::uint16_t>(std::stoul(port));  // libcurl rejects ports beyond 65535
    path = part_of(url, CURLUPART_PATH);
    return {};
}

/// @param flags of getaddrinfo
/// @return the ranges of all addresses that are found
std::vector<AddressRange> resolve(const HttpOrigin& origin, int flags) {
    std::string host = origin.host;
    if (host.starts_with('['))
        host = host.substr(1, host.size() - 2);
    if (const auto zone = host.find("%25"); zone != std::string::npos)
        host.erase(zone + 1, 2);
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = flags;
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0)
        return {};
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> held(found, &::freeaddrinfo);
    std::vector<AddressRange> out;
    for (const addrinfo* one = found; one != nullptr; one = one->ai_next)
        out.push_back(range_of(*one->ai_addr));
    return out;
}

}  // namespace

HttpOrigin HttpOrigin::of(const std::string& url) {
    HttpOrigin out;
    std::string path;
    if (const std::string fault = fault_of(url, out, path); !fault.empty())
        throw util::UsageError("open the world '" + shown_url(url) + "': " + fault +
                               "; allowed: http(s)://host[:port][/path], up to 2048 bytes");
    return out;
}

HttpOrigin HttpOrigin::parse(const std::string& text) {
    HttpOrigin out;
    std::string path;
    std::string fault = fault_of(text, out, path);
    if (fault.empty() && path != "/")
        fault = "an address with a path in it";
    if (!fault.empty())
        throw util::UsageError("read the origin '" + shown_url(text) + "': " + fault +
                               "; allowed: http(s)://host[:port]");
    return out;
}

std::string HttpOrigin::text() const {
    return (tls ? "https://" : "http://") + host + ":" + std::to_string(port);
}

std::string shown_url(const std::string& url) {
    std::string out = url.substr(0, std::min(url.find_first_of("?#"), kMax_bytes));
    const auto scheme = out.find("://");
    if (scheme == std::string::npos)
        return out;
    const auto begin = scheme + 3;
    const auto at = out.rfind('@', out.find('/', begin));
    if (at != std::string::npos && at >= begin)
        out.erase(begin, at + 1 - begin);
    return out;
}

std::optional<AddressRange> range_of_number(const HttpOrigin& origin) {
    const auto found = resolve(origin, AI_NUMERICHOST);
    return found.empty() ? std::nullopt : std::optional(found.front());
}

AddressRanges ranges_of_host(const HttpOrigin& origin, const std::stop_token& stop) {
    if (const auto range = range_of_number(origin))
        return {*range};
    // A name service may take minutes to report a failure.
    const auto ranges = thread::call_until_stopped([origin] { return resolve(origin, 0); }, stop);
    if (!ranges)
        throw util::Error("look up " + origin.host + ": stopped");
    AddressRanges out;
    for (const AddressRange range : *ranges)
        out.add(range);
    return out;
}

}  // namespace terravox::remote
