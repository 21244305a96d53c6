#include "voxelserver/make/worlds/remote/http_access.hpp"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "common/util/secret.hpp"
#include "common/util/text.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::remote {
namespace {

struct Block {
    std::array<std::uint8_t, 16> first;
    int bits;  ///< of the prefix
    AddressRange range;
};

// Ref: IANA, "IPv4 Special-Purpose Address Registry", "IPv6 Special-Purpose Address Registry". The
// first matching block counts.
constexpr std::array kBlocks4 = {
    Block{{127}, 8, AddressRange::kLoopback},
    Block{{10}, 8, AddressRange::kPrivate},
    Block{{172, 16}, 12, AddressRange::kPrivate},
    Block{{192, 168}, 16, AddressRange::kPrivate},
    Block{{169, 254}, 16, AddressRange::kPrivate},
    Block{{100, 64}, 10, AddressRange::kPrivate},
    Block{{0}, 8, AddressRange::kNoMachine},
    Block{{192, 0, 0}, 24, AddressRange::kNoMachine},
    Block{{192, 0, 2}, 24, AddressRange::kNoMachine},
    Block{{192, 88, 99}, 24, AddressRange::kNoMachine},  // anycast to relays of 6to4
    Block{{198, 18}, 15, AddressRange::kNoMachine},
    Block{{198, 51, 100}, 24, AddressRange::kNoMachine},
    Block{{203, 0, 113}, 24, AddressRange::kNoMachine},
    Block{{224}, 3, AddressRange::kNoMachine},  // multicast, reserved, broadcast
    Block{{}, 0, AddressRange::kPublic},
};
// Only 2000::/3 is assigned to machines. IPv4 within IPv6 (mapped, NAT64, Teredo, 6to4) could lead
// where IPv4 itself must not.
constexpr std::array kBlocks6 = {
    Block{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 128, AddressRange::kLoopback},
    Block{{0xfc}, 7, AddressRange::kPrivate},
    Block{{0xfe, 0x80}, 10, AddressRange::kPrivate},
    Block{{0x20, 0x01}, 23, AddressRange::kNoMachine},
    Block{{0x20, 0x01, 0x0d, 0xb8}, 32, AddressRange::kNoMachine},
    Block{{0x20, 0x02}, 16, AddressRange::kNoMachine},
    Block{{0x3f, 0xff}, 20, AddressRange::kNoMachine},
    Block{{0x20}, 3, AddressRange::kPublic},
    Block{{}, 0, AddressRange::kNoMachine},
};

bool begins_with(const std::uint8_t* address, const Block& block) noexcept {
    const auto whole = static_cast<std::size_t>(block.bits / 8);
    if (std::memcmp(address, block.first.data(), whole) != 0)
        return false;
    const int rest = block.bits % 8;
    return rest == 0 || (address[whole] ^ block.first[whole]) >> (8 - rest) == 0;
}

AddressRange range_in(std::span<const Block> blocks, const std::uint8_t* address) noexcept {
    for (const Block& block : blocks)
        if (begins_with(address, block))
            return block.range;
    return AddressRange::kNoMachine;
}

const std::uint8_t* to_number(const sockaddr& address) noexcept {
    if (address.sa_family == AF_INET)
        return reinterpret_cast<const std::uint8_t*>(
            &reinterpret_cast<const sockaddr_in&>(address).sin_addr);
    if (address.sa_family == AF_INET6)
        return reinterpret_cast<const sockaddr_in6&>(address).sin6_addr.s6_addr;
    return nullptr;
}

}  // namespace

AddressRange make_range(const sockaddr& address) noexcept {
    const std::uint8_t* number = to_number(address);
    if (number == nullptr)
        return AddressRange::kNoMachine;
    return address.sa_family == AF_INET ? range_in(kBlocks4, number) : range_in(kBlocks6, number);
}

std::string to_text(const sockaddr& address) {
    std::array<char, INET6_ADDRSTRLEN> text{};
    const std::uint8_t* number = to_number(address);
    if (number == nullptr ||
        inet_ntop(address.sa_family, number, text.data(), text.size()) == nullptr)
        return "no number of a machine";
    return text.data();
}

namespace {

constexpr std::size_t kMax_bytes = 2048;

struct FreeUrl {
    void operator()(CURLU* url) const noexcept { curl_url_cleanup(url); }
};
using Url = std::unique_ptr<CURLU, FreeUrl>;

/// A component of an address; empty: it has none.
std::string find_part(const Url& url, CURLUPart part, unsigned flags = 0) {
    char* text = nullptr;
    if (curl_url_get(url.get(), part, &text, flags) != CURLUE_OK || text == nullptr)
        return {};
    const std::unique_ptr<char, void (*)(void*)> held(text, &curl_free);
    return text;
}

/// "somebody:password@host:80" of "http://somebody:password@host:80/path".
std::string find_authority(const std::string& url) {
    const auto begin = url.find("://") + 3;
    return url.substr(begin, url.find_first_of("/?#", begin) - begin);
}

/// The fault of an address; empty: it is valid, and the origin and the path are set.
std::string describe_fault(const std::string& text, HttpOrigin& origin, std::string& path) {
    if (!worlds::is_http_address(text))
        return "not an address";
    if (text.size() > kMax_bytes)
        return "an address of " + std::to_string(text.size()) + " bytes";
    // As text: libcurl does not distinguish an empty query from none.
    if (find_authority(text).find('@') != std::string::npos)
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
    origin.tls = find_part(url, CURLUPART_SCHEME) == "https";
    origin.host = util::lower_case(find_part(url, CURLUPART_HOST));
    // Of a link-local address: its network is part of the destination.
    if (const std::string zone = find_part(url, CURLUPART_ZONEID); !zone.empty())
        origin.host.insert(origin.host.size() - 1, "%25" + zone);
    const std::string port = find_part(url, CURLUPART_PORT, CURLU_DEFAULT_PORT);
    if (origin.host.empty() || port.empty())
        return "not an address";
    origin.port =
        static_cast<std::uint16_t>(std::stoul(port));  // libcurl rejects ports beyond 65535
    path = find_part(url, CURLUPART_PATH);
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
        out.push_back(make_range(*one->ai_addr));
    return out;
}

}  // namespace

HttpOrigin HttpOrigin::of(const std::string& url) {
    HttpOrigin out;
    std::string path;
    if (const std::string fault = describe_fault(url, out, path); !fault.empty())
        throw util::UsageError(
            "open the world '{}': {}; allowed: http(s)://host[:port][/path], up to 2048 bytes",
            shown_url(url), fault);
    return out;
}

HttpOrigin HttpOrigin::parse(const std::string& text) {
    HttpOrigin out;
    std::string path;
    std::string fault = describe_fault(text, out, path);
    if (fault.empty() && path != "/")
        fault = "an address with a path in it";
    if (!fault.empty())
        throw util::UsageError("read the origin '{}': {}; allowed: http(s)://host[:port]",
                               shown_url(text), fault);
    return out;
}

std::string HttpOrigin::text() const {
    return (tls ? "https://" : "http://") + host + ":" + std::to_string(port);
}

HttpOrigin redirect_target(const std::string& attempt, const HttpOrigin& from,
                           const std::string& location) {
    if (location.empty())
        throw util::Error("{}: it leads nowhere; allowed: http(s) addresses", attempt);
    const std::string shown = util::printable(shown_url(location));
    HttpOrigin out;
    std::string path;
    const std::string fault =
        describe_fault(location.substr(0, location.find_first_of("?#")), out, path);
    if (!fault.empty())
        throw util::Error("{}: it leads to '{}', {}; allowed: http(s)://host[:port][/path][?query]",
                          attempt, shown, fault);
    if (from.tls && !out.tls)
        throw util::Error("{}: it leads to '{}', without encryption; allowed: https", attempt,
                          shown);
    return out;
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
        throw util::Error("look up {}: stopped", origin.host);
    AddressRanges out;
    for (const AddressRange range : *ranges)
        out.add(range);
    return out;
}

namespace {

constexpr const char* kOriginVariable = "TERRAVOX_SERVER_ORIGIN";

bool contains(const std::vector<HttpOrigin>& origins, const HttpOrigin& origin) {
    return std::find(origins.begin(), origins.end(), origin) != origins.end();
}

/// Whether clear text sent there stays on this machine. A name that suggests so is checked again
/// when the connection is made.
bool is_loopback(const HttpOrigin& origin) {
    const auto range = range_of_number(origin);
    return range ? *range == AddressRange::kLoopback : origin.host == "localhost";
}

}  // namespace

BoundToken::BoundToken(HttpOrigin origin, std::string text)
    : m_origin(std::move(origin)), m_text(std::move(text)) {
    if (!m_origin.tls && !is_loopback(m_origin))
        throw util::UsageError(
            "bind a token to {}: it would go over the network in clear text; allowed: https, or "
            "http to localhost",
            m_origin.text());
}

AddressRanges HttpAccess::ranges(const HttpOrigin& origin) const {
    AddressRanges out = kAnyRange;
    if (limits) {
        if (contains(limits->private_origins, origin))
            out = {AddressRange::kPublic, AddressRange::kPrivate, AddressRange::kLoopback};
        else if (contains(limits->origins, origin))
            out = {AddressRange::kPublic};
        else
            out = {};
    }
    // "localhost" may resolve to another machine after all.
    const bool in_clear_text = token && token->origin() == origin && !origin.tls;
    if (in_clear_text)
        out = out.holds(AddressRange::kLoopback) ? AddressRanges{AddressRange::kLoopback}
                                                 : AddressRanges{};
    return out;
}

AddressRanges HttpAccess::ranges(const HttpOrigin& origin, AddressRange from) const {
    const AddressRanges all = ranges(origin);
    if (limits)
        return all;
    switch (from) {
        case AddressRange::kLoopback: return all;
        case AddressRange::kPrivate:
            return all & AddressRanges{AddressRange::kPublic, AddressRange::kPrivate};
        default: return all & AddressRanges{AddressRange::kPublic};
    }
}

const char* HttpAccess::allowed() const noexcept {
    return limits ? "origins of allow_origins that lead to public addresses, and of "
                    "allow_private_origins"
                  : "addresses of loopback, since a token goes there in clear text";
}

HttpAccess access_of_environment() {
    HttpAccess out;
    std::string token = util::find_token({}, util::kServerTokenVariable);
    const char* origin = std::getenv(kOriginVariable);
    if (origin == nullptr || *origin == '\0')
        return out;
    const std::string attempt =
        std::string("read the environment variable ") + kOriginVariable + ": ";
    if (token.empty())
        throw util::UsageError("{}{} is not set; allowed: both, or neither", attempt,
                               util::kServerTokenVariable);
    try {
        out.token.emplace(HttpOrigin::parse(origin), std::move(token));
    } catch (const util::UsageError& e) {
        throw util::UsageError(attempt + e.what());
    }
    return out;
}

}  // namespace terravox::remote
