#include "voxelserver/serve/host/host_names.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

#include "common/util/error.hpp"
#include "common/util/process.hpp"
#include "common/util/text.hpp"

namespace terravox::http {
namespace {

constexpr std::size_t kMaxNameBytes = 253;  // limit for a domain name

bool is_digit(char c) noexcept {
    return c >= '0' && c <= '9';
}

bool is_name(std::string_view text) noexcept {
    const auto fits = [](char c) {
        return is_digit(c) || (util::lower_case(c) >= 'a' && util::lower_case(c) <= 'z') ||
               c == '-' || c == '.' || c == '_';
    };
    return !text.empty() && text.size() <= kMaxNameBytes && text.front() != '.' &&
           std::all_of(text.begin(), text.end(), fits);
}

bool is_address(int family, std::string_view text) noexcept {
    std::array<char, INET6_ADDRSTRLEN + 1> terminated{};
    if (text.size() >= terminated.size())
        return false;
    std::copy(text.begin(), text.end(), terminated.begin());
    std::array<unsigned char, sizeof(in6_addr)> ignored{};
    return inet_pton(family, terminated.data(), ignored.data()) == 1;
}

bool is_port(std::string_view text) noexcept {
    return text.size() <= 5 && std::all_of(text.begin(), text.end(), is_digit);
}

}  // namespace

bool is_loopback(const std::string& address) noexcept {
    in_addr v4{};
    if (inet_pton(AF_INET, address.c_str(), &v4) == 1)
        return (ntohl(v4.s_addr) >> 24) == 127;
    in6_addr v6{};
    return inet_pton(AF_INET6, address.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6) != 0;
}

HostNames::HostNames(const std::string& bind, const std::vector<std::string>& names)
    : m_names{"localhost"} {
    for (const std::string& name : names) {
        if (!is_name(name))
            throw util::UsageError("answer to the host name '" + name +
                                   "'; allowed: a name without a port, such as voxels.example.org");
        m_names.push_back(name);
    }
    if (std::string own = util::host_name(); !is_loopback(bind) && !own.empty())
        m_names.push_back(std::move(own));
    for (std::string& name : m_names)
        std::transform(name.begin(), name.end(), name.begin(),
                       [](char c) { return util::lower_case(c); });
}

bool HostNames::allow(std::string_view host) const noexcept {
    if (!host.empty() && host.front() == '[') {
        const std::size_t end = host.find(']');
        if (end == std::string_view::npos || !is_address(AF_INET6, host.substr(1, end - 1)))
            return false;
        const std::string_view rest = host.substr(end + 1);
        return rest.empty() || (rest.front() == ':' && is_port(rest.substr(1)));
    }
    const std::size_t colon = std::min(host.find(':'), host.size());
    if (colon < host.size() && !is_port(host.substr(colon + 1)))
        return false;
    const std::string_view name = host.substr(0, colon);
    return is_address(AF_INET, name) ||
           std::any_of(m_names.begin(), m_names.end(),
                       [&](const std::string& own) { return util::equal_but_for_case(own, name); });
}

bool from_another_origin(const Request& request) {
    if (const std::string origin = request.header("Origin"); !origin.empty()) {
        constexpr std::string_view kMark = "://";
        const std::size_t mark = origin.find(kMark);
        if (mark == std::string::npos ||
            !same_word(std::string_view(origin).substr(mark + kMark.size()),
                       request.header("Host")))
            return true;
    }
    const std::string site = request.header("Sec-Fetch-Site");
    if (site.empty() || site == "none" || site == "same-origin")
        return false;
    const bool is_link = request.header("Sec-Fetch-Mode") == "navigate" &&
                         request.header("Sec-Fetch-Dest") == "document" &&
                         (request.method == "GET" || request.method == "HEAD");
    return !is_link;
}

}  // namespace terravox::http
